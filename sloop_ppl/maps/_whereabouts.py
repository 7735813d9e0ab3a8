"""Say in words where a point is: by the nearest landmark and the nearest street."""

from __future__ import annotations

import math
from collections.abc import Callable

from sloop_ppl.maps.city import CityMap
from sloop_ppl.maps.landmark import PATH_KINDS, Landmark

__all__ = ["COMPASS_POINTS", "nearest_landmark", "whereabouts"]

COMPASS_POINTS = (
    "east", "northeast", "north", "northwest", "west", "southwest", "south", "southeast",
)  # fmt: skip
"""Words for the eighths of a turn, anticlockwise from east."""


def nearest_landmark(city: CityMap, x_m: float, y_m: float) -> Landmark | None:
    """Return the nearest named landmark that is no street or path, else the nearest of any sort."""
    places = [m for m in city.landmarks if m.kind not in PATH_KINDS]
    for among in ([m for m in places if m.name], places, city.landmarks):
        found = city.nearest(x_m, y_m, among)
        if found is not None:
            return found[0]
    return None


def whereabouts(
    city: CityMap, x_m: float, y_m: float, name_of: Callable[[str], str] | None = None
) -> str:
    """Say where a point is, such as "12 m southwest of Velvet Dog, on Johnson Court".

    Parameters
    ----------
    city
        The map.
    x_m, y_m
        The point, metres.
    name_of
        What a landmark is called, by its id; its label when None.

    Examples
    --------
    >>> from sloop_ppl.maps import load_map
    >>> whereabouts(load_map("cleveland"), -72.5, -77.5)
    '29 m west of Joseph and, 44 m from Johnson Court'
    """
    parts = []
    name_of = name_of or (lambda landmark_id: city.landmark(landmark_id).label)
    landmark = nearest_landmark(city, x_m, y_m)
    if landmark is not None:
        measured = city.nearest(x_m, y_m, [landmark])
        distance = measured[1] if measured else 0.0
        # Within half a cell a direction would say more than is known.
        if distance < city.grid.cell_m / 2:
            parts.append(f"at {name_of(landmark.id)}")
        else:
            x, y = city.centroid(landmark.id)
            # Eighths of a turn from the centroid, the nearest compass word.
            octant = round(math.atan2(y_m - y, x_m - x) / (math.pi / 4)) % 8
            parts.append(f"{distance:.0f} m {COMPASS_POINTS[octant]} of {name_of(landmark.id)}")
    paths = city.of_kind(*PATH_KINDS)
    street = city.nearest(x_m, y_m, [m for m in paths if m.name] or paths)
    if street is not None:
        near = street[1] <= city.grid.cell_m
        label = name_of(street[0].id)
        parts.append(f"on {label}" if near else f"{street[1]:.0f} m from {label}")
    return ", ".join(parts) or f"at ({x_m:g}, {y_m:g}) m"
