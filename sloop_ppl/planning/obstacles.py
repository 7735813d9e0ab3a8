"""Which cells tall buildings close to flight and sight, and which stand between two others."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.maps import CityMap, Landmark

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

__all__ = [
    "DEFAULT_HEIGHTS_M",
    "LEVEL_HEIGHT_M",
    "Offsets",
    "cells_between",
    "height_m",
    "is_blocked",
    "tall_cells",
    "walls_of",
]

Offsets = tuple[tuple[int, int], ...]
"""``(rows north, columns east)`` of several cells."""

DEFAULT_HEIGHTS_M: Mapping[str, float] = MappingProxyType({"building": 12.0})
"""Height of a landmark that does not tell it, by kind, metres; other kinds are flat."""

LEVEL_HEIGHT_M = 3.0
"""Height of a storey, metres."""

_NUMBER = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(m|ft|')?\s*$")


def height_m(landmark: Landmark) -> float:
    """Return how tall a landmark is, metres.

    Its property ``height_m`` counts first, then ``height`` (metres unless it says ft), then
    ``building:levels`` times `LEVEL_HEIGHT_M`, then the default of its kind.
    """
    height = landmark.properties.get("height_m")
    if height is not None:
        return float(height)
    found = _NUMBER.match(str(landmark.properties.get("height", "")))
    if found:
        # 0.3048 m a foot
        return float(found[1]) * (1.0 if found[2] in (None, "m") else 0.3048)
    levels = _NUMBER.match(str(landmark.properties.get("building:levels", "")))
    if levels:
        return float(levels[1]) * LEVEL_HEIGHT_M
    return DEFAULT_HEIGHTS_M.get(landmark.kind, 0.0)


def tall_cells(city: CityMap, flight_height_m: float) -> NDArray[np.bool_]:
    """Return the cells whose centre lies in a tall building as True, shape (H, W).

    Parameters
    ----------
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


def walls_of(city: CityMap, flight_height_m: float) -> BaseGeometry:
    """Return what tall buildings cover, as one geometry; it may be empty.

    Parameters
    ----------
    flight_height_m
        As in `tall_cells`.
    """
    import shapely

    tall = [
        city.footprint(b.id) for b in city.of_kind("building") if height_m(b) >= flight_height_m > 0
    ]
    walls: BaseGeometry = shapely.union_all(tall)
    shapely.prepare(walls)
    return walls


def is_blocked(
    closed: frozenset[int], n_cols: int, row: int, col: int, rows: int, cols: int
) -> bool:
    """Tell whether closed cells stand between a cell and the one at an offset from it."""
    return any(
        all((row + r) * n_cols + col + c in closed for r, c in choices)
        for choices in cells_between(rows, cols)
    )


@cache
def cells_between(rows: int, cols: int) -> tuple[Offsets, ...]:
    """Return the cells strictly between a cell and another one, seen along a straight line.

    Parameters
    ----------
    rows, cols
        Where the other cell is, cells north and east.

    Returns
    -------
    tuple
        One entry per step along the longer axis: the one cell that the line runs through or,
        where it runs along the border of two, both; it is blocked when all of them are.

    Examples
    --------
    >>> cells_between(0, 3)
    (((0, 1),), ((0, 2),))
    >>> cells_between(1, 2)
    (((0, 1), (1, 1)),)
    """
    # One sample a cell of the longer axis, as Bresenham draws a line; exact in whole numbers.
    n = max(abs(rows), abs(cols))
    between = []
    for k in range(1, n):
        across = [(r, c) for r in _nearest(rows * k, n) for c in _nearest(cols * k, n)]
        between.append(tuple(across))
    return tuple(between)


def _nearest(numerator: int, denominator: int) -> tuple[int, ...]:
    """Return the whole number nearest to a fraction, or both when two are equally near."""
    low = numerator // denominator
    # Twice the remainder against the denominator: the half way point without fractions.
    over = 2 * (numerator - low * denominator)
    if over == denominator:
        return low, low + 1
    return (low,) if over < denominator else (low + 1,)
