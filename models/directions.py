"""Which way a relation points: offsets from a ground's front, and compass bearings."""

from __future__ import annotations

import math

__all__ = ["ABSOLUTE_FRONT_RAD", "COMPASS_RAD", "FRAME_OFFSET_RAD"]

FRAME_OFFSET_RAD: dict[str, float] = {
    "front": 0.0,
    "behind": math.pi,
    "left": math.pi / 2,
    "right": -math.pi / 2,
}
"""Class of frame relation -> its direction less the direction the ground faces, radians.

Source: SLOOP fig. 4 (right is 90 degrees clockwise of front).
"""

COMPASS_RAD: dict[str, float] = {
    "east": 0.0,
    "northeast": math.pi / 4,
    "north": math.pi / 2,
    "northwest": 3 * math.pi / 4,
    "west": math.pi,
    "southwest": -3 * math.pi / 4,
    "south": -math.pi / 2,
    "southeast": -math.pi / 4,
}
"""Compass class -> its direction, radians anticlockwise from east.

The published code has southwest at 75 degrees of its compass, a slip for 135; not followed.
"""

ABSOLUTE_FRONT_RAD = math.pi / 2
"""The front that makes left and right those of the map: facing north, right is east."""
