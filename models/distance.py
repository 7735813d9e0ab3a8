"""How far a cell is from a ground, in a way that a finer grid does not change."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps import CityMap, Grid, LandmarkFields
from sloop_ppl.maps.city import FIELDS
from sloop_ppl.maps.fields import BYTES_PER_CELL, landmark_fields
from sloop_ppl.maps.rasterise import touched_cells

__all__ = ["REFERENCE_CELL_M", "distance_from", "ground_distance_m", "shape_fields"]

REFERENCE_CELL_M = 5.0
"""Side of the cells that the paper's widths were set on, metres."""


def ground_distance_m(city: CityMap, ground: str) -> NDArray[np.float64]:
    """Return the distance from each cell's centre to the nearest cell of a ground, shape (H, W).

    Parameters
    ----------
    city : the map.
    ground : id of the landmark.
    """
    return distance_from(city.grid, lambda grid: _on(city, grid).fields(ground))


def shape_fields(shape: BaseGeometry, grid: Grid) -> LandmarkFields:
    """Return distance and bearing of every cell as seen from a shape, kept as landmarks' are.

    Parameters
    ----------
    shape : shapely geometry, metres; it takes the cells it touches.
    grid : the cells.
    """
    west, south, east, north = shape.bounds
    centre = shape.centroid
    return FIELDS.get(
        (grid, hashlib.sha256(shape.wkb).hexdigest()),
        lambda: landmark_fields(
            grid,
            touched_cells(grid, shape),
            (float(centre.x), float(centre.y)),
            max(east - west, north - south),
        ),
        cost_bytes=grid.size * BYTES_PER_CELL,
    )


def distance_from(grid: Grid, fields_on: Callable[[Grid], LandmarkFields]) -> NDArray[np.float64]:
    """Return the distance from each cell's centre to the nearest cell of a thing, shape (H, W).

    Parameters
    ----------
    grid : the cells.
    fields_on : returns the fields of the thing on a grid.

    Notes
    -----
    Source: the published code measures from the ground's nearest cell, on cells of 5 m. A ground
    touches less on smaller cells, which would move every belief, so on a grid finer than 5 m the
    distance is still measured to the ground's 5 m cells; it is then not 0 all over the ground,
    and it is kept as the fields are.
    """
    if grid.cell_m >= REFERENCE_CELL_M:
        return fields_on(grid).distance_m
    coarse = fields_on(replace(grid, cell_m=REFERENCE_CELL_M))
    key = ("distance", grid, hashlib.sha256(coarse.cells.tobytes()).hexdigest())
    return FIELDS.get(key, lambda: _distance_to(coarse, grid), cost_bytes=8 * grid.size)


def _distance_to(coarse: LandmarkFields, grid: Grid) -> NDArray[np.float64]:
    """Return the distance from the cells of a fine grid to the nearest cell of a coarse one."""
    rows, cols = coarse.nearest
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


def _on(city: CityMap, grid: Grid) -> CityMap:
    return city if grid == city.grid else city.with_grid(grid)
