"""How a place or a yaw is approached: from rest to rest, without a jerk."""

from __future__ import annotations

import math
from typing import NamedTuple

__all__ = ["Ramp", "line_time", "turn_time"]

_MOST_M_S2 = 3.5
_MOST_RAD_S, _MOST_RAD_S2 = 1.8, 3.0
_SHORTEST_S = 0.3

# Greatest first and second derivative of 10 s^3 - 15 s^4 + 6 s^5 over [0, 1].
_PEAK_SPEED, _PEAK_BEND = 1.875, 10.0 / math.sqrt(3.0)


class Ramp(NamedTuple):
    """The smooth way from 0 to 1 in some time: 10 s^3 - 15 s^4 + 6 s^5 with s = t / duration.

    Parameters
    ----------
    duration_s
        How long it takes, seconds, > 0.
    """

    duration_s: float

    def ticks(self, tick_s: float) -> int:
        """Return how many ticks it takes."""
        return math.ceil(self.duration_s / tick_s)

    def at(self, t_s: float) -> tuple[float, float, float]:
        """Return value, first and second derivative by time; it stays at 1 from the end on."""
        s = min(t_s / self.duration_s, 1.0)
        value = s**3 * (10 - 15 * s + 6 * s * s)
        rate = 30 * s * s * (1 - s) ** 2 / self.duration_s
        bend = 60 * s * (1 - s) * (1 - 2 * s) / self.duration_s**2
        return value, rate, bend


def line_time(length_m: float, speed_m_s: float) -> float:
    """Return how long a straight flight takes with a limit on speed and on acceleration."""
    return max(
        _PEAK_SPEED * length_m / speed_m_s, math.sqrt(_PEAK_BEND * length_m / _MOST_M_S2),
        _SHORTEST_S,
    )  # fmt: skip


def turn_time(angle_rad: float) -> float:
    """Return how long a turn on the spot takes."""
    return max(
        _PEAK_SPEED * angle_rad / _MOST_RAD_S, math.sqrt(_PEAK_BEND * angle_rad / _MOST_RAD_S2),
        _SHORTEST_S,
    )  # fmt: skip
