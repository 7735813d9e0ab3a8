"""Lay square cells over a map and convert between cells, metres and longitude/latitude."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sloop_ppl.errors import InputError, OutsideMap

__all__ = ["Grid"]

# Keeps floor(side / cell) right when the quotient is a whole number but for rounding.
_SLACK = 1e-9

# A table of float64 over them takes 400 MB; more is a slip of the pen in cell_m.
_MAX_CELLS = 50_000_000


@dataclass(frozen=True)
class Grid:
    """Square cells laid from the north-west corner of a rectangular extent.

    The frame is local: metres from the map's centre, x east, y north. Arrays are ``[row, col]``
    with row 0 in the south. A side of length L has ``floor(L / cell_m) + 1`` cells, so the last
    column and the southernmost row overhang the extent by up to one cell.

    Parameters
    ----------
    west_m, south_m, east_m, north_m
        Extent, metres.
    cell_m
        Side of a cell, metres, > 0.
    centre
        Latitude and longitude of the frame's origin in degrees (WGS84), or None for a map that is
        nowhere on earth.

    Raises
    ------
    InputError
        When the extent is empty, a number is not finite, `cell_m` is not positive, or there would
        be more than 50 million cells.

    Notes
    -----
    Source: SLOOP sec. V (41 x 41 cells of 5 m over a 200 m patch), as laid by the published data.

    Examples
    --------
    >>> grid = Grid(-100, -100, 100, 100)
    >>> grid.shape
    (41, 41)
    >>> grid.cell_at(-37.5, -72.5)
    (6, 12)
    """

    west_m: float
    south_m: float
    east_m: float
    north_m: float
    cell_m: float = 5.0
    centre: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        numbers = (self.west_m, self.south_m, self.east_m, self.north_m, self.cell_m)
        if not all(math.isfinite(n) for n in numbers):
            raise InputError(f"Grid has a number that is not finite: {numbers}")
        if self.east_m <= self.west_m or self.north_m <= self.south_m:
            raise InputError(
                f"Grid extent is empty: west {self.west_m}, south {self.south_m}, "
                f"east {self.east_m}, north {self.north_m}; expected west < east, south < north"
            )
        if self.cell_m <= 0:
            raise InputError(f"cell_m is {self.cell_m}; expected a positive number of metres")
        cells = ((self.east_m - self.west_m) / self.cell_m + 1) * (
            (self.north_m - self.south_m) / self.cell_m + 1
        )
        if cells > _MAX_CELLS:
            raise InputError(
                f"Grid would have {cells:.3g} cells; expected {_MAX_CELLS:,} at most: give "
                "a larger cell_m or a smaller extent"
            )

    @classmethod
    def square(
        cls, half_extent_m: float, cell_m: float = 5.0, centre: tuple[float, float] | None = None
    ) -> Grid:
        """Return the grid of a square map that spans `half_extent_m` either side of its centre."""
        h = half_extent_m
        return cls(-h, -h, h, h, cell_m, centre)

    @property
    def n_rows(self) -> int:
        """Number of rows, south to north."""
        return int((self.north_m - self.south_m) / self.cell_m + _SLACK) + 1

    @property
    def n_cols(self) -> int:
        """Number of columns, west to east."""
        return int((self.east_m - self.west_m) / self.cell_m + _SLACK) + 1

    @property
    def shape(self) -> tuple[int, int]:
        """``(n_rows, n_cols)``, the shape of every array over this grid."""
        return self.n_rows, self.n_cols

    @property
    def size(self) -> int:
        """Number of cells."""
        return self.n_rows * self.n_cols

    @property
    def extent_m(self) -> tuple[float, float, float, float]:
        """West, south, east and north border, metres."""
        return self.west_m, self.south_m, self.east_m, self.north_m

    @property
    def cells_extent_m(self) -> tuple[float, float, float, float]:
        """West, south, east and north border of the cells, overhang included, metres."""
        east = self.west_m + self.n_cols * self.cell_m
        south = self.north_m - self.n_rows * self.cell_m
        return self.west_m, south, east, self.north_m

    @cached_property
    def x_m(self) -> NDArray[np.float64]:
        """East coordinate of the cell centres by column, metres, shape (n_cols,)."""
        x: NDArray[np.float64] = (
            self.west_m + (np.arange(self.n_cols, dtype=np.float64) + 0.5) * self.cell_m
        )
        return x

    @cached_property
    def y_m(self) -> NDArray[np.float64]:
        """North coordinate of the cell centres by row, metres, shape (n_rows,)."""
        # Cells are laid from the north, rows counted from the south.
        rows = np.arange(self.n_rows, dtype=np.float64)[::-1]
        y: NDArray[np.float64] = self.north_m - (rows + 0.5) * self.cell_m
        return y

    def contains(self, x_m: float, y_m: float) -> bool:
        """Tell whether a point lies inside the extent, borders included."""
        return self.west_m <= x_m <= self.east_m and self.south_m <= y_m <= self.north_m

    def cell_at(self, x_m: float, y_m: float) -> tuple[int, int]:
        """Return ``(row, col)`` of the cell that holds a point.

        Raises
        ------
        OutsideMap
            When the point is outside the extent; choose one inside it.
        """
        if not self.contains(x_m, y_m):
            raise OutsideMap(
                f"Place ({x_m:g}, {y_m:g}) is outside the map; expected x in "
                f"[{self.west_m:g}, {self.east_m:g}] and y in [{self.south_m:g}, {self.north_m:g}] "
                "metres from the map's centre"
            )
        col = int((x_m - self.west_m) / self.cell_m + _SLACK)
        row_from_north = int((self.north_m - y_m) / self.cell_m + _SLACK)
        return self.n_rows - 1 - row_from_north, col

    def cell_covering(self, x_m: float, y_m: float) -> tuple[int, int]:
        """Return ``(row, col)`` of the cell that covers a point, which may lie on the overhang.

        Raises
        ------
        OutsideMap
            When no cell covers the point.
        """
        # floor, not int: int would round -0.5 to column 0, which is off the map.
        col = math.floor((x_m - self.west_m) / self.cell_m + _SLACK)
        row = self.n_rows - 1 - math.floor((self.north_m - y_m) / self.cell_m + _SLACK)
        if not (0 <= row < self.n_rows and 0 <= col < self.n_cols):
            west, south, east, north = self.cells_extent_m
            raise OutsideMap(
                f"Place ({x_m:g}, {y_m:g}) is off the map; expected x in [{west:g}, {east:g}) and "
                f"y in ({south:g}, {north:g}], metres"
            )
        return row, col

    def check_cell(self, row: int, col: int) -> None:
        """Refuse a cell that is not there.

        Raises
        ------
        OutsideMap
            When there is no such cell; the message has the limits.
        """
        if not (0 <= row < self.n_rows and 0 <= col < self.n_cols):
            raise OutsideMap(
                f"Cell ({row}, {col}) is outside the grid; expected a row in [0, {self.n_rows}) "
                f"and a column in [0, {self.n_cols})"
            )

    def centre_of(self, row: int, col: int) -> tuple[float, float]:
        """Return ``(x, y)`` of a cell's centre, metres; a centre may lie on the overhang.

        Raises
        ------
        OutsideMap
            When there is no such cell.
        """
        self.check_cell(row, col)
        return float(self.x_m[col]), float(self.y_m[row])

    def place_in(self, row: int, col: int) -> tuple[float, float]:
        """Return ``(x, y)`` of a place in a cell that lies inside the extent, metres.

        It is the cell's centre, or the nearest place to it where that lies on the overhang.
        """
        x, y = self.centre_of(row, col)
        # Only the east and the south overhang.
        return min(x, self.east_m), max(y, self.south_m)

    def row_from_north(self, row: int) -> int:
        """Return the row as raster files and the published data count it."""
        return self.n_rows - 1 - row

    def to_lonlat(
        self, x_m: ArrayLike, y_m: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Convert local metres to longitude and latitude in degrees (WGS84).

        Raises
        ------
        InputError
            When the grid has no `centre`.
        """
        lon, lat = self._projection(np.asarray(x_m), np.asarray(y_m), inverse=True)
        return np.asarray(lon), np.asarray(lat)

    def from_lonlat(
        self, lon: ArrayLike, lat: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Convert longitude and latitude in degrees (WGS84) to local metres.

        Raises
        ------
        InputError
            When the grid has no `centre`.
        """
        x, y = self._projection(np.asarray(lon), np.asarray(lat))
        return np.asarray(x), np.asarray(y)

    @cached_property
    def _projection(self) -> Any:
        if self.centre is None:
            raise InputError("This grid has no centre on earth; give Grid a centre=(lat, lon)")
        from pyproj import Proj

        lat, lon = self.centre
        # Azimuthal equidistant: distances and bearings from the centre are true.
        return Proj(proj="aeqd", lat_0=lat, lon_0=lon, datum="WGS84", units="m")
