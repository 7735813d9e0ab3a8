"""Read widths and heights from tags, or take what is usual for the class."""

from __future__ import annotations

import re
from collections.abc import Mapping

__all__ = ["ROAD_WIDTH_M", "height_m", "length_m", "road_width_m"]

ROAD_WIDTH_M = {
    "motorway": 15.0, "trunk": 13.0, "primary": 12.0, "secondary": 10.0, "tertiary": 9.0,
    "unclassified": 7.0, "residential": 7.0, "living_street": 6.0, "road": 7.0, "busway": 7.0,
    "motorway_link": 6.0, "trunk_link": 6.0, "primary_link": 6.0, "secondary_link": 5.5,
    "tertiary_link": 5.5, "service": 4.0, "track": 3.0, "pedestrian": 6.0, "footway": 2.0,
    "path": 1.5, "steps": 2.5, "cycleway": 3.0, "bridleway": 2.0,
    "river": 20.0, "canal": 10.0, "stream": 2.0,
}  # fmt: skip
"""Width of a carriageway or watercourse by class, metres, where no tag tells it."""

# Width of a lane and height of a storey where no tag tells it, metres.
_LANE_M = 3.25
_LEVEL_M = 3.0
_LENGTH = re.compile(r"\s*(\d+(?:[.,]\d+)?)\s*(m|metres?|meters?|km|cm|ft|feet|')?\s*")
_FEET = re.compile(r"\s*(\d+)\s*'\s*(\d+)\s*(?:\"|'')?\s*")
_UNIT_M = {"km": 1000.0, "cm": 0.01, "ft": 0.3048, "feet": 0.3048, "'": 0.3048}


def length_m(text: str | None) -> float | None:
    """Read a length such as ``"12"``, ``"3.5 m"``, ``"40 ft"`` or ``5'6"``; None if it is none.

    Examples
    --------
    >>> length_m("10 ft"), length_m("3,5 m"), length_m("wide")
    (3.048, 3.5, None)
    """
    if text is None:
        return None
    if feet := _FEET.fullmatch(text):
        return round((int(feet[1]) + int(feet[2]) / 12) * 0.3048, 3)
    if not (found := _LENGTH.fullmatch(text)):
        return None
    return round(float(found[1].replace(",", ".")) * _UNIT_M.get(found[2] or "m", 1.0), 3)


def road_width_m(tags: Mapping[str, str]) -> float:
    """Return the width of a road or watercourse, metres in [0.5, 60].

    ``width``, else ``est_width``, else 3.25 m for each of ``lanes`` (motor roads only), else what
    is usual for its class.
    """
    for key in ("width", "est_width"):
        tagged_m = length_m(tags.get(key))
        # Wider or narrower is a slip of the tag.
        if tagged_m is not None and 0.5 <= tagged_m <= 60.0:
            return tagged_m
    usual = ROAD_WIDTH_M.get(tags.get("highway", tags.get("waterway", "")), 4.0)
    lanes = tags.get("lanes", "")
    # Only of classes at least 5.5 m wide: a lane of a path takes no 3.25 m.
    if lanes.isascii() and lanes.isdigit() and 1 <= int(lanes) <= 16 and usual >= 5.5:
        return int(lanes) * _LANE_M
    return usual


def height_m(tags: Mapping[str, str]) -> float | None:
    """Return the height of a building, metres: ``height``, else 3 m a level; None if untold."""
    tagged_m = length_m(tags.get("height"))
    if tagged_m is not None and 0 < tagged_m <= 1000:
        return tagged_m
    try:
        levels = float(tags.get("building:levels", ""))
    except ValueError:
        return None
    # More than 300 levels are a slip of the tag.
    return round(levels * _LEVEL_M, 3) if 0 < levels <= 300 else None
