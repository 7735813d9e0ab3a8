"""How far a cell is from a ground, in a way that a finer grid does not change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.maps import CityMap

__all__ = ["REFERENCE_CELL_M", "ground_distance_m"]

REFERENCE_CELL_M = 5.0
"""Side of the cells that the paper's widths were set on, metres."""


def ground_distance_m(city: CityMap, ground: str) -> NDArray[np.float64]:
    """Return the distance from each cell's centre to the nearest cell of a ground, shape (H, W).

    Parameters
    ----------
    city : the map.
    ground : id of the landmark.

    Notes
    -----
    Source: the published code measures from the ground's nearest cell, on cells of 5 m. A ground
    touches less on smaller cells, which would move every belief, so on a grid finer than 5 m the
    distance is still measured to the ground's 5 m cells; it is then not 0 all over the ground.
    """
    grid = city.grid
    if grid.cell_m >= REFERENCE_CELL_M:
        return city.fields(ground).distance_m
    coarse = city.with_grid(replace(grid, cell_m=REFERENCE_CELL_M))
    rows, cols = coarse.fields(ground).nearest
    x, y = coarse.grid.x_m, coarse.grid.y_m
    row = np.clip(((grid.y_m - y[0]) / REFERENCE_CELL_M).round().astype(int), 0, len(y) - 1)
    col = np.clip(((grid.x_m - x[0]) / REFERENCE_CELL_M).round().astype(int), 0, len(x) - 1)
    best = np.full(grid.shape, np.inf)
    # The nearest of the cells that are nearest to the coarse cells around a point is the point's.
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            near = np.ix_(np.clip(row + down, 0, len(y) - 1), np.clip(col + right, 0, len(x) - 1))
            north = grid.y_m[:, None] - y[rows[near]]
            east = grid.x_m[None, :] - x[cols[near]]
            np.minimum(best, np.hypot(north, east), out=best)
    return best
