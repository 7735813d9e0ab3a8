"""AirSim's frame and the map's: north, east, down and degrees, against east, north, up and radians.

Nothing else of the package knows of north, east, down (NED).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["NedFrame", "map_yaw_rad", "ned_yaw_deg", "quaternion", "rotation", "yaw_pitch"]

Triple = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


class NedFrame(NamedTuple):
    """Where the origin of NED lies on the map.

    Parameters
    ----------
    x_m, y_m
        Metres east and north of the map's centre.
    z_m
        Metres above the ground.
    """

    x_m: float = 0.0
    y_m: float = 0.0
    z_m: float = 0.0

    def to_ned(self, x_m: float, y_m: float, z_m: float) -> Triple:
        """Return metres north, east and down of the origin."""
        return y_m - self.y_m, x_m - self.x_m, self.z_m - z_m

    def to_map(self, north_m: float, east_m: float, down_m: float) -> Triple:
        """Return x, y and z on the map."""
        return east_m + self.x_m, north_m + self.y_m, self.z_m - down_m


def ned_yaw_deg(yaw_rad: float) -> float:
    """Return degrees clockwise from north, in [-180, 180]."""
    return math.degrees(math.remainder(math.pi / 2 - yaw_rad, 2 * math.pi))


def map_yaw_rad(yaw_deg: float) -> float:
    """Return radians anticlockwise from east, in [0, 2 pi)."""
    # The second remainder takes care of -1e-17, whose first is 2 pi itself.
    return (math.pi / 2 - math.radians(yaw_deg)) % (2 * math.pi) % (2 * math.pi)


def quaternion(yaw_rad: float, pitch_rad: float = 0.0) -> Quaternion:
    """Return w, x, y and z of a heading and a pitch in NED.

    Parameters
    ----------
    yaw_rad
        Radians anticlockwise from east.
    pitch_rad
        Radians above the horizon.
    """
    half_yaw, half_pitch = math.radians(ned_yaw_deg(yaw_rad)) / 2, pitch_rad / 2
    c, s = math.cos(half_yaw), math.sin(half_yaw)
    cp, sp = math.cos(half_pitch), math.sin(half_pitch)
    # Yaw about down, then pitch about the body's right: q = q_yaw * q_pitch.
    return c * cp, -s * sp, c * sp, s * cp


def rotation(quaternion: Quaternion) -> NDArray[np.float64]:
    """Return the matrix from the body (forward, right, down) to the map (east, north, up).

    Returns
    -------
    ndarray
        Shape (3, 3). Its columns are forward, right and down in the map's axes.
    """
    w, x, y, z = (v / math.hypot(*quaternion) for v in quaternion)
    ned = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    # Rows north, east, down become east, north, up.
    return np.array([ned[1], ned[0], -ned[2]])


def yaw_pitch(quaternion: Quaternion) -> tuple[float, float]:
    """Return the heading on the map, in [0, 2 pi), and the pitch above the horizon, radians."""
    forward = rotation(quaternion)[:, 0]
    yaw = math.atan2(forward[1], forward[0]) % (2 * math.pi) % (2 * math.pi)
    return yaw, math.asin(min(1.0, max(-1.0, float(forward[2]))))
