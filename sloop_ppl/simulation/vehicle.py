"""What a flying vehicle must offer to be served or flown: the protocol and its values.

The frame is the map's: x east, y north, z up from the ground, metres; yaw in radians,
anticlockwise from east.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal, NamedTuple, Protocol, runtime_checkable

from numpy.typing import NDArray

__all__ = ["CameraImage", "ImageKind", "Stop", "Vehicle", "VehiclePose"]

Stop = Callable[[], bool]
"""Asked again and again during a flight; True ends it where the vehicle is."""

ImageKind = Literal["scene", "segmentation"]


class VehiclePose(NamedTuple):
    """Where something is in the air or on the ground, and where it heads.

    Parameters
    ----------
    x_m, y_m, z_m
        Metres east and north of the map's centre, and above the ground.
    yaw_rad
        Radians anticlockwise from east.
    """

    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float = 0.0


class CameraImage(NamedTuple):
    """A picture and the pinhole camera that took it.

    Parameters
    ----------
    pixels
        For a scene red, green and blue, uint8, shape (height, width, 3). For a segmentation what
        each pixel shows, whole numbers, shape (height, width): 0 for nothing that has a name, and
        k for the k-th of the vehicle's `objects`, counted from 1.
    pose
        Where the camera is and where it looks; its yaw is that of the optical axis.
    pitch_rad
        How far the optical axis is above the horizon, radians; negative when it looks down.
    fov_deg
        Horizontal opening, degrees.
    """

    pixels: NDArray[Any]
    pose: VehiclePose
    pitch_rad: float
    fov_deg: float


@runtime_checkable
class Vehicle(Protocol):
    """A vehicle that takes off, flies to places, and carries a camera.

    Attributes
    ----------
    pose
        Where it is in truth.
    estimated_pose
        Where it believes to be.
    collision
        Name of what it ran into since the last command began; None where it touched nothing.

    Notes
    -----
    Commands block until they are done or `stop` says True, and tell whether they were done. They
    forget the collision of the command before, then ask `stop` at every step. All of
    them and `camera_image` are called from one thread; the attributes, `objects` and
    `object_pose` may be read from another one meanwhile, so each is to return a whole value.
    """

    @property
    def pose(self) -> VehiclePose:
        """Where it is in truth."""
        ...

    @property
    def estimated_pose(self) -> VehiclePose:
        """Where it believes to be."""
        ...

    @property
    def collision(self) -> str | None:
        """Name of what it ran into since the last command began."""
        ...

    def take_off(self, stop: Stop | None = None) -> bool:
        """Leave the ground."""
        ...

    def land(self, stop: Stop | None = None) -> bool:
        """Come down where it is."""
        ...

    def hover(self, stop: Stop | None = None) -> bool:
        """Come to rest where it is."""
        ...

    def move_to(
        self, x_m: float, y_m: float, z_m: float, speed_m_s: float, stop: Stop | None = None
    ) -> bool:
        """Fly straight to a place; the yaw stays."""
        ...

    def yaw_to(self, yaw_rad: float, stop: Stop | None = None) -> bool:
        """Turn on the spot, the shorter way round."""
        ...

    def camera_image(self, kind: ImageKind) -> CameraImage:
        """Take a picture."""
        ...

    def objects(self) -> Sequence[str]:
        """Return the names of what stands in the world, always in the same order."""
        ...

    def object_pose(self, name: str) -> VehiclePose:
        """Return where an object stands, at its middle."""
        ...
