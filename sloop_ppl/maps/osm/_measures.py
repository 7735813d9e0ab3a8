"""Take widths and heights from tags, or what is usual for the class."""

from __future__ import annotations

from collections.abc import Mapping

from sloop_ppl.maps.osm._lengths import length_m, levels

__all__ = ["ROAD_WIDTH_M", "height_m", "road_width_m", "unread"]

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
# Beyond these a tag is a slip.
_NARROWEST_M, _WIDEST_M = 0.5, 60.0
_TALLEST_M, _MOST_LEVELS = 1000.0, 300


def road_width_m(tags: Mapping[str, str]) -> float:
    """Return the width of a road or watercourse, metres in [0.5, 60].

    ``width``, else ``est_width``, else 3.25 m for each of ``lanes`` (motor roads only), else what
    is usual for its class.
    """
    for key in ("width", "est_width"):
        tagged_m = length_m(tags.get(key))
        # Wider or narrower is a slip of the tag.
        if tagged_m is not None and _NARROWEST_M <= tagged_m <= _WIDEST_M:
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
    if tagged_m is not None and 0 < tagged_m <= _TALLEST_M:
        return tagged_m
    storeys = levels(tags.get("building:levels"))
    return round(storeys * _LEVEL_M, 3) if storeys and storeys <= _MOST_LEVELS else None


def unread(tags: Mapping[str, str], is_building: bool) -> list[str]:
    """Return those tags for height, levels or width whose values cannot be used.

    Examples
    --------
    >>> unread({"height": "1O m", "building:levels": "0"}, is_building=True)
    ['height=1O m']
    """
    found = []
    for key in ("height", "building:levels") if is_building else ("width", "est_width"):
        if key not in tags:
            continue
        if key == "building:levels":
            value = levels(tags[key])
            low, high = 0.0, float(_MOST_LEVELS)
        else:
            value = length_m(tags[key])
            low, high = (1e-3, _TALLEST_M) if is_building else (_NARROWEST_M, _WIDEST_M)
        if value is None or not low <= value <= high:
            found.append(f"{key}={' '.join(tags[key].split())[:30]}")
    return found
