"""Find the cells that a landmark's geometry touches."""

from __future__ import annotations

import math

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps.grid import Grid

__all__ = ["touched_cells"]

# Sides of blocks in cells; each is split into 4 x 4 of the next.
_BLOCKS = (64, 16, 4, 1)
# So many cells are tested one by one sooner than by blocks.
_FEW_CELLS = 256
# Blocks are tested a little larger than they are, so that rounding loses no cell on their border.
_SLACK_M = 1e-6


def touched_cells(grid: Grid, geometry: BaseGeometry) -> NDArray[np.bool_]:
    """Return the cells a geometry touches, or the nearest cell where it touches none.

    Parameters
    ----------
    grid
        The grid.
    geometry
        Shapely geometry in the grid's frame, metres. A point takes the cell that holds it; anything
        else takes every cell whose closed square it meets, borders included.

    Returns
    -------
    numpy.ndarray
        True on the cells taken, never empty, shape (H, W).

    Notes
    -----
    Blocks of cells are tested before cells, so that the work grows with the length of the
    geometry's outline and not with the area of its bounding box.
    """
    cells = np.zeros(grid.shape, dtype=bool)
    if geometry.geom_type == "Point" and grid.contains(geometry.x, geometry.y):
        cells[grid.cell_at(geometry.x, geometry.y)] = True
        return cells
    _mark_touched(cells, grid, geometry)
    if not cells.any():
        cells[_nearest_cell(grid, geometry)] = True
    return cells


def _mark_touched(cells: NDArray[np.bool_], grid: Grid, geometry: BaseGeometry) -> None:
    west, south, _, _ = grid.cells_extent_m
    min_x, min_y, max_x, max_y = geometry.bounds
    c0, c1 = _window(min_x - west, max_x - west, grid.cell_m, grid.n_cols)
    r0, r1 = _window(min_y - south, max_y - south, grid.cell_m, grid.n_rows)
    if c0 >= c1 or r0 >= r1:
        return
    sizes = [size for size in _BLOCKS if size <= max(c1 - c0, r1 - r0)]
    if (c1 - c0) * (r1 - r0) <= _FEW_CELLS:
        sizes = [1]
    half = grid.cell_m / 2
    rows, cols = np.arange(r0, r1, sizes[0]), np.arange(c0, c1, sizes[0])
    row, col = (a.ravel() for a in np.meshgrid(rows, cols, indexing="ij"))
    shapely.prepare(geometry)
    for size, finer in zip(sizes, [*sizes[1:], None], strict=True):
        last_row, last_col = np.minimum(row + size, r1) - 1, np.minimum(col + size, c1) - 1
        # Single cells are tested as they are.
        slack = _SLACK_M if finer else 0.0
        boxes = shapely.box(
            grid.x_m[col] - half - slack,
            grid.y_m[row] - half - slack,
            grid.x_m[last_col] + half + slack,
            grid.y_m[last_row] + half + slack,
        )
        # Wholly inside: all of its cells. Partly: split. Outside: dropped.
        hit = shapely.intersects(geometry, boxes)
        if finer is None:
            cells[row[hit], col[hit]] = True
            return
        inside = shapely.contains(geometry, boxes)
        for r, c in zip(row[inside], col[inside], strict=True):
            cells[r : min(r + size, r1), c : min(c + size, c1)] = True
        row, col = _split(row[hit & ~inside], col[hit & ~inside], size, finer, r1, c1)


def _split(
    row: NDArray[np.intp], col: NDArray[np.intp], size: int, finer: int, r1: int, c1: int
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the corners of the finer blocks within blocks, those outside the window left out."""
    step = np.arange(0, size, finer)
    rows = (row[:, None, None] + step[:, None] + 0 * step[None, :]).ravel()
    cols = (col[:, None, None] + 0 * step[:, None] + step[None, :]).ravel()
    keep = (rows < r1) & (cols < c1)
    return rows[keep], cols[keep]


def _nearest_cell(grid: Grid, geometry: BaseGeometry) -> tuple[int, int]:
    """Return the cell whose centre is nearest to a geometry that lies outside all cells.

    Such a cell lies on the border of the grid; of several the southernmost, then westernmost.
    """
    border = np.zeros(grid.shape, dtype=bool)
    border[[0, -1], :] = True
    border[:, [0, -1]] = True
    rows, cols = np.nonzero(border)
    centres = shapely.points(grid.x_m[cols], grid.y_m[rows])
    nearest = int(np.argmin(shapely.distance(geometry, centres)))
    return int(rows[nearest]), int(cols[nearest])


def _window(low: float, high: float, cell_m: float, count: int) -> tuple[int, int]:
    """Return the half-open range of indices whose closed cells may meet ``[low, high]``."""
    # One cell more on either side: a closed square touches its neighbours.
    first = max(math.floor(low / cell_m) - 1, 0)
    last = min(math.floor(high / cell_m) + 2, count)
    return first, max(last, first)
