"""Find the cells that a landmark's geometry touches."""

from __future__ import annotations

import math

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps.grid import Grid

__all__ = ["touched_cells"]


def touched_cells(grid: Grid, geometry: BaseGeometry) -> NDArray[np.bool_]:
    """Return the cells a geometry touches, or the nearest cell where it touches none.

    Parameters
    ----------
    grid : the grid.
    geometry : shapely geometry in the grid's frame, metres. A point takes the cell that holds
        it; anything else takes every cell whose closed square it meets, borders included.

    Returns
    -------
    numpy.ndarray
        True on the cells taken, never empty, shape (H, W).
    """
    cells = np.zeros(grid.shape, dtype=bool)
    if geometry.geom_type == "Point" and grid.contains(geometry.x, geometry.y):
        cells[grid.cell_at(geometry.x, geometry.y)] = True
        return cells
    west, south, _, _ = grid.cells_extent_m
    min_x, min_y, max_x, max_y = geometry.bounds
    c0, c1 = _window(min_x - west, max_x - west, grid.cell_m, grid.n_cols)
    r0, r1 = _window(min_y - south, max_y - south, grid.cell_m, grid.n_rows)
    if c0 < c1 and r0 < r1:
        half = grid.cell_m / 2
        x, y = np.meshgrid(grid.x_m[c0:c1], grid.y_m[r0:r1])
        boxes = shapely.box(x - half, y - half, x + half, y + half)
        shapely.prepare(geometry)
        cells[r0:r1, c0:c1] = shapely.intersects(geometry, boxes)
    if not cells.any():
        x, y = np.meshgrid(grid.x_m, grid.y_m)
        nearest = np.argmin(shapely.distance(geometry, shapely.points(x, y)))
        cells[np.unravel_index(nearest, grid.shape)] = True
    return cells


def _window(low: float, high: float, cell_m: float, count: int) -> tuple[int, int]:
    """Return the half-open range of indices whose closed cells may meet ``[low, high]``."""
    first = max(math.floor(low / cell_m) - 1, 0)
    last = min(math.floor(high / cell_m) + 2, count)
    return first, max(last, first)
