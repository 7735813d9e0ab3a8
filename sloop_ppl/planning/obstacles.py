"""How tall the buildings of a map are, and which cells they close to flight and sight."""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.maps import CityMap, Landmark

__all__ = ["DEFAULT_HEIGHTS_M", "LEVEL_HEIGHT_M", "height_m", "tall_cells"]

DEFAULT_HEIGHTS_M: Mapping[str, float] = MappingProxyType({"building": 12.0})
"""Height of a landmark that does not tell it, by kind, metres; other kinds are flat."""

LEVEL_HEIGHT_M = 3.0
"""Height of a storey, metres."""

_NUMBER = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(m|ft|')?\s*$")


def height_m(landmark: Landmark) -> float:
    """Return how tall a landmark is, metres.

    Its property ``height`` (metres unless it says ft) counts first, then ``building:levels``
    times `LEVEL_HEIGHT_M`, then the default of its kind.
    """
    found = _NUMBER.match(str(landmark.properties.get("height", "")))
    if found:
        return float(found[1]) * (1.0 if found[2] in (None, "m") else 0.3048)
    levels = _NUMBER.match(str(landmark.properties.get("building:levels", "")))
    if levels:
        return float(levels[1]) * LEVEL_HEIGHT_M
    return DEFAULT_HEIGHTS_M.get(landmark.kind, 0.0)


def tall_cells(city: CityMap, flight_height_m: float) -> NDArray[np.bool_]:
    """Return the cells whose centre lies in a tall building as True, shape (H, W).

    Parameters
    ----------
    city
        The map.
    flight_height_m
        How high the robot flies, metres; buildings at least as high are tall.

    Notes
    -----
    Centres count, not touched cells: else walls of 5 m cells would close streets of 5 m.
    """
    import shapely

    tall = np.zeros(city.grid.shape, dtype=bool)
    x, y = np.meshgrid(city.grid.x_m, city.grid.y_m)
    for building in city.of_kind("building"):
        if height_m(building) >= flight_height_m > 0:
            footprint = city.footprint(building.id)
            shapely.prepare(footprint)
            tall |= shapely.contains_xy(footprint, x, y)
    return tall
