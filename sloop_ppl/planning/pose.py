"""Poses: where the robot is and where it heads, in metres and radians."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from sloop_ppl.errors import InputError

__all__ = ["HEADINGS", "Pose", "as_pose"]

HEADINGS = 8
"""Directions a planner's robot can face, 45 degrees apart, anticlockwise from east."""


class Pose(NamedTuple):
    """A position and a heading; equal to the plain tuple of its three numbers.

    Parameters
    ----------
    x_m, y_m
        Metres east and north of the map's centre.
    heading_rad
        Radians anticlockwise from east.

    Examples
    --------
    >>> import math
    >>> Pose(5.0, -10.0, math.pi / 2).heading_deg
    90.0
    """

    x_m: float
    y_m: float
    heading_rad: float = 0.0

    @property
    def heading_deg(self) -> float:
        """The heading in degrees, in [0, 360)."""
        return math.degrees(self.heading_rad) % 360.0


def as_pose(value: Any, source: str) -> Pose:
    """Return three finite numbers as a `Pose`, or refuse them; `source` names them."""
    try:
        numbers = tuple(float(v) for v in value)
    except (TypeError, ValueError):
        numbers = ()
    if len(numbers) != 3 or not all(math.isfinite(v) for v in numbers):
        raise InputError(
            f"{source} is {value!r}; expected (x_m, y_m, heading_rad) as three finite numbers"
        )
    return Pose(*numbers)
