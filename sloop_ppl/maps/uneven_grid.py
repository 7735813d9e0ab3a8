"""A grid whose rows and columns are several cells high and wide where little happens."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps.fields import LandmarkFields
from sloop_ppl.maps.grid import Grid
from sloop_ppl.maps.rasterise import touched_cells

__all__ = ["UnevenGrid", "cells_of_map", "log_cells", "uneven_fields"]


@dataclass(frozen=True)
class UnevenGrid(Grid):
    """The cells of an even grid, gathered into blocks by row and by column.

    A block counts as its centre; `counts` tells how many cells it stands for.

    Parameters
    ----------
    col_edges, row_edges
        First cell of each column of blocks, west to east, and of each row, south to north, and the
        number of cells behind the last; ascending whole numbers from 0.

    Examples
    --------
    >>> even = Grid(0, 0, 15, 5)
    >>> even.shape
    (2, 4)
    >>> grid = UnevenGrid(*even.extent_m, col_edges=(0, 2, 3, 4), row_edges=(0, 2))
    >>> grid.shape, grid.counts.tolist(), grid.x_m.tolist()
    ((1, 3), [[4, 2, 2]], [5.0, 12.5, 17.5])
    """

    col_edges: tuple[int, ...] = (0, 1)
    row_edges: tuple[int, ...] = (0, 1)

    @property
    def even(self) -> Grid:
        """The grid of cells."""
        return Grid(*self.extent_m, self.cell_m, self.centre)

    @property
    def n_rows(self) -> int:
        """Number of rows of blocks."""
        return len(self.row_edges) - 1

    @property
    def n_cols(self) -> int:
        """Number of columns of blocks."""
        return len(self.col_edges) - 1

    @property
    def cells_extent_m(self) -> tuple[float, float, float, float]:
        """West, south, east and north border of the cells, overhang included, metres."""
        return self.even.cells_extent_m

    @cached_property
    def x_m(self) -> NDArray[np.float64]:
        """East coordinate of the blocks' centres by column, metres, shape (n_cols,)."""
        edges = np.array(self.col_edges)
        middle: NDArray[np.float64] = self.west_m + (edges[1:] + edges[:-1]) / 2 * self.cell_m
        return middle

    @cached_property
    def y_m(self) -> NDArray[np.float64]:
        """North coordinate of the blocks' centres by row, metres, shape (n_rows,)."""
        edges = np.array(self.row_edges)
        south = self.cells_extent_m[1]
        middle: NDArray[np.float64] = south + (edges[1:] + edges[:-1]) / 2 * self.cell_m
        return middle

    @cached_property
    def counts(self) -> NDArray[np.int64]:
        """How many cells each block stands for, shape (n_rows, n_cols)."""
        return np.outer(np.diff(self.row_edges), np.diff(self.col_edges))

    def cell_at(self, x_m: float, y_m: float) -> tuple[int, int]:
        """Return ``(row, col)`` of the block that holds a point; see `Grid.cell_at`."""
        return self.block_of(*self.even.cell_at(x_m, y_m))

    def cell_covering(self, x_m: float, y_m: float) -> tuple[int, int]:
        """Return ``(row, col)`` of the block that covers a point; see `Grid.cell_covering`."""
        return self.block_of(*self.even.cell_covering(x_m, y_m))

    def block_of(self, row: int, col: int) -> tuple[int, int]:
        """Return ``(row, col)`` of the block that holds a cell of the even grid."""
        return bisect_right(self.row_edges, row) - 1, bisect_right(self.col_edges, col) - 1

    def spread(self, mass: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the mass of each cell, that of its block by its number of cells.

        Parameters
        ----------
        mass
            Mass of each block, shape (n_rows, n_cols).

        Returns
        -------
        numpy.ndarray
            Shape of the even grid; the sum is that of `mass`.
        """
        by_row = np.repeat(mass / self.counts, np.diff(self.row_edges), axis=0)
        return np.repeat(by_row, np.diff(self.col_edges), axis=1)


def cells_of_map(grid: Grid) -> int:
    """Return of how many cells a map is, those that blocks stand for counted one by one."""
    return grid.even.size if isinstance(grid, UnevenGrid) else grid.size


def log_cells(grid: Grid) -> NDArray[np.float64] | None:
    """Return the log number of cells each entry of a table stands for, shape (S,); None for one."""
    return np.log(grid.counts).reshape(-1) if isinstance(grid, UnevenGrid) else None


def uneven_fields(grid: UnevenGrid, shape: BaseGeometry) -> LandmarkFields:
    """Return distance and bearing of every block's centre as seen from a shape.

    Distances are to the nearest cell of the even grid that the shape touches, as on that grid.
    """
    rows, cols = _touched(grid.even, shape)
    even = grid.even
    _, south, _, _ = even.cells_extent_m
    touched = np.column_stack(
        [even.west_m + (cols + 0.5) * even.cell_m, south + (rows + 0.5) * even.cell_m]
    )
    cells = np.zeros(grid.shape, dtype=np.bool_)
    blocks = (
        np.searchsorted(grid.row_edges, rows, side="right") - 1,
        np.searchsorted(grid.col_edges, cols, side="right") - 1,
    )
    cells[blocks] = True
    min_x, min_y, max_x, max_y = shape.bounds
    centre = shape.centroid
    return LandmarkFields(
        grid,
        cells,
        (float(centre.x), float(centre.y)),
        max(max_x - min_x, max_y - min_y),
        (touched, np.array(blocks, dtype=np.int32)),
    )


def _touched(even: Grid, shape: BaseGeometry) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return rows and columns of the cells a shape touches; only those about it are looked at."""
    west, south, _, _ = even.cells_extent_m
    min_x, min_y, max_x, max_y = shape.bounds
    c0, c1 = _range(min_x - west, max_x - west, even.cell_m, even.n_cols)
    r0, r1 = _range(min_y - south, max_y - south, even.cell_m, even.n_rows)
    # Half a cell less than whole ones: a grid has one more than fit between its borders.
    part = replace(
        even,
        west_m=west + c0 * even.cell_m,
        east_m=west + (c1 - 0.5) * even.cell_m,
        north_m=south + r1 * even.cell_m,
        south_m=south + (r0 + 0.5) * even.cell_m,
    )
    rows, cols = np.nonzero(touched_cells(part, shape))
    return rows + r0, cols + c0


def _range(low: float, high: float, cell_m: float, count: int) -> tuple[int, int]:
    first = min(max(int(low // cell_m) - 1, 0), count - 1)
    return first, max(min(int(high // cell_m) + 2, count), first + 1)
