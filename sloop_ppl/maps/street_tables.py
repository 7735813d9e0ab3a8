"""How each cell lies to a street, its crossings and its blocks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from sloop_ppl.maps._along import NearestOnLines, nearest_on_lines
from sloop_ppl.maps.city import FIELDS, CityMap
from sloop_ppl.maps.crossings import Crossing
from sloop_ppl.maps.grid import Grid
from sloop_ppl.maps.street_network import StreetNetwork, Stretch, street_network

__all__ = [
    "EdgeTables",
    "StreetTables",
    "block_table",
    "edge_tables",
    "quadrant_table",
    "street_tables",
]

# The tables of a street: distance, two offsets, place along it, distance to a crossing and place
# along the edge as float64, two numbers of spine and stretch, side and median as bool.
_BYTES_PER_CELL = 6 * 8 + 2 * 8 + 2


@dataclass(frozen=True, eq=False)
class EdgeTables:
    """Where along the edges of blocks each cell lies, by its nearest street.

    Tables have shape (H, W), row 0 in the south.

    Parameters
    ----------
    street
        Position of the street in `StreetNetwork.streets`; -1 where there is none.
    stretch
        Position of the stretch in `StreetNetwork.stretches`; -1 where there is none.
    along_m
        Place on the street's spine, metres from its start; nan where there is none.
    on_left
        Whether the cell lies on the left of the spine's direction.
    position
        Place along the stretch as a share of its length, counted from the nearer of its ends: 0 at
        a corner, .5 in the middle of the block; nan where no corner is known.

    Notes
    -----
    A stretch that a dead end closes ends there as at a corner. Of one that the border of the map
    cuts the other end is unknown: what is seen of it counts from its corner as if it were at most
    all, so that its cells are no nearer to the middle than they seem.
    """

    street: NDArray[np.int64]
    stretch: NDArray[np.int64]
    along_m: NDArray[np.float64]
    on_left: NDArray[np.bool_]
    position: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class StreetTables:
    """How each cell lies to one street.

    Tables have shape (H, W), row 0 in the south.

    Parameters
    ----------
    axis_m
        Distance to the axis, metres; inf where the street has none.
    offset_m
        From the nearest point of the axis to the cell, east and north, metres, shape (2, H, W).
    carriageway_m
        Distance to the edge of the carriageway, metres, 0 on it and between two carriageways.
    in_median
        Whether the cell lies between two carriageways.
    crossing_m
        Distance to the nearest crossing on the street, metres; inf where it has none.
    edge
        Where along the street's stretches the cell lies.
    """

    axis_m: NDArray[np.float64]
    offset_m: NDArray[np.float64]
    carriageway_m: NDArray[np.float64]
    in_median: NDArray[np.bool_]
    crossing_m: NDArray[np.float64]
    edge: EdgeTables

    def side(self, bearing_rad: float) -> NDArray[np.float64]:
        """Return how much each cell lies on one side of the street, shape (H, W).

        Parameters
        ----------
        bearing_rad
            The side, as the direction from the axis, radians anticlockwise from east: 0 for the
            east side, pi / 2 for the north side.

        Returns
        -------
        numpy.ndarray
            Cosine between the bearing and the direction from the axis to the cell: 1 and -1 on the
            two sides of a street that runs across the bearing, nearly 0 where it runs along it,
            and 0 on the axis and between two carriageways.
        """
        east, north = self.offset_m
        ahead = east * math.cos(bearing_rad) + north * math.sin(bearing_rad)
        # Less than a micrometre has no direction.
        sure = (self.axis_m > 1e-6) & np.isfinite(self.axis_m) & ~self.in_median
        return np.where(sure, np.divide(ahead, self.axis_m, where=sure, out=ahead * 0), 0.0)


def street_tables(city: CityMap, street_id: str) -> StreetTables:
    """Return how each cell lies to a street.

    Parameters
    ----------
    city
        The map.
    street_id
        Id of any landmark of the street. What is no street that is a line has empty tables:
        infinitely far, on no side, on no stretch.
    """
    network = street_network(city)
    at = network.position(street_id)
    return FIELDS.get(
        ("street", city.grid, network, at),
        lambda: _street_tables(city.grid, network, at),
        cost_bytes=city.grid.size * _BYTES_PER_CELL,
    )


def edge_tables(city: CityMap) -> EdgeTables:
    """Return where along the edges of blocks each cell lies, by the nearest street that bounds any.

    Parameters
    ----------
    city
        The map; without streets no cell has a street, a stretch or a position.
    """
    network = street_network(city)
    bounding = [i for i, axis in enumerate(network.streets) if axis.bounds_blocks]
    return FIELDS.get(
        ("edges", city.grid, network),
        lambda: _edges(city.grid, network, bounding),
        cost_bytes=city.grid.size * _BYTES_PER_CELL,
    )


def block_table(city: CityMap) -> NDArray[np.int64]:
    """Return the number of the block in which the centre of each cell lies, shape (H, W).

    Parameters
    ----------
    city
        The map.

    Returns
    -------
    numpy.ndarray
        Position in `StreetNetwork.blocks`; -1 between the carriageways of a road and where the map
        has no blocks. The centre of a cell that overhangs the border counts as on the border, one
        on an axis as in the first of the blocks there.
    """
    network = street_network(city)
    return FIELDS.get(
        ("blocks", city.grid, network),
        lambda: _block_table(city.grid, network),
        cost_bytes=city.grid.size * 8,
    )


def quadrant_table(grid: Grid, crossing: Crossing, bearing_rad: float) -> NDArray[np.bool_]:
    """Return the cells at the corner of a crossing that a bearing means, shape (H, W).

    Parameters
    ----------
    grid
        The cells.
    crossing
        The crossing.
    bearing_rad
        The bearing as seen from the crossing, radians anticlockwise from east; 5 pi / 4 for "the
        SW corner".

    Returns
    -------
    numpy.ndarray
        True between the two arms that enclose the corner, however far away.
    """
    begin, end = crossing.sector(bearing_rad)
    x, y = crossing.point_m
    bearing = np.arctan2(grid.y_m[:, None] - y, grid.x_m[None, :] - x)
    return (bearing - begin) % (2 * math.pi) <= end - begin


def _street_tables(grid: Grid, network: StreetNetwork, at: int | None) -> StreetTables:
    edge = _edges(grid, network, [] if at is None else [at])
    if at is None or not network.streets[at].spines:
        nowhere = np.full(grid.shape, np.inf)
        none = np.zeros(grid.shape, dtype=np.bool_)
        return StreetTables(
            nowhere, np.full((2, *grid.shape), np.nan), nowhere, none, nowhere, edge
        )
    axis = network.streets[at]
    centres = _centres(grid)
    nearest = nearest_on_lines(shapely.get_parts(axis.lines), centres)
    axis_m = np.hypot(*nearest.offset_m.T).reshape(grid.shape)
    median = axis.median
    shapely.prepare(median)
    in_median = shapely.contains_xy(median, centres).reshape(grid.shape)
    crossing_m = np.full(grid.shape, np.inf)
    for crossing in network.crossings:
        if at in crossing.streets:
            x, y = crossing.point_m
            away = np.hypot(grid.y_m[:, None] - y, grid.x_m[None, :] - x)
            np.minimum(crossing_m, away, out=crossing_m)
    return StreetTables(
        axis_m=axis_m,
        offset_m=nearest.offset_m.T.reshape(2, *grid.shape),
        carriageway_m=np.where(in_median, 0.0, np.maximum(axis_m - axis.width_m / 2, 0.0)),
        in_median=in_median,
        crossing_m=crossing_m,
        edge=edge,
    )


def _edges(grid: Grid, network: StreetNetwork, streets: Sequence[int]) -> EdgeTables:
    owners = [(i, k) for i in streets for k in range(len(network.streets[i].spines))]
    none = np.full(grid.shape, -1)
    nan = np.full(grid.shape, np.nan)
    if not owners:
        return EdgeTables(none, none, nan, np.zeros(grid.shape, dtype=np.bool_), nan)
    lines = [network.streets[i].spines[k] for i, k in owners]
    nearest = nearest_on_lines(lines, _centres(grid))
    stretch, position = none.ravel().copy(), nan.ravel().copy()
    numbers = {owner: n for n, owner in enumerate(owners)}
    for number, part in enumerate(network.stretches):
        n = numbers.get((part.street, part.spine))
        if n is not None:
            here = _within(nearest, n, part)
            stretch[here] = number
            position[here] = _position(part, nearest.along_m[here])
    return EdgeTables(
        street=np.array([i for i, _ in owners])[nearest.line].reshape(grid.shape),
        stretch=stretch.reshape(grid.shape),
        along_m=nearest.along_m.reshape(grid.shape),
        on_left=nearest.on_left.reshape(grid.shape),
        position=position.reshape(grid.shape),
    )


def _within(nearest: NearestOnLines, line: int, part: Stretch) -> NDArray[np.bool_]:
    along = nearest.along_m
    # Rounding may put the end of a spine a hair beyond the end of its last stretch.
    is_between = (along >= part.start_m - 1e-6) & (along <= part.end_m + 1e-6)
    return is_between & np.equal(nearest.line, line)


def _position(part: Stretch, along_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the place along a stretch, 0 at its nearer end and .5 in its middle, shape (N,)."""
    share = np.clip((along_m - part.start_m) / (part.end_m - part.start_m), 0.0, 1.0)
    if part.start_open and part.end_open:
        return np.full_like(share, np.nan)
    if part.start_open or part.end_open:
        return np.minimum(1.0 - share if part.start_open else share, 0.5)
    return np.minimum(share, 1.0 - share)


def _block_table(grid: Grid, network: StreetNetwork) -> NDArray[np.int64]:
    west, south, east, north = grid.extent_m
    x, y = np.clip(grid.x_m, west, east), np.clip(grid.y_m, south, north)
    table = np.full(grid.shape, -1)
    for block in network.blocks:
        x0, y0, x1, y1 = block.polygon.bounds
        rows, cols = np.flatnonzero((y >= y0) & (y <= y1)), np.flatnonzero((x >= x0) & (x <= x1))
        if len(rows) and len(cols):
            shapely.prepare(block.polygon)
            window = np.ix_(rows, cols)
            inside = shapely.intersects_xy(block.polygon, *np.meshgrid(x[cols], y[rows]))
            table[window] = np.where((table[window] < 0) & inside, block.number, table[window])
    return table


def _centres(grid: Grid) -> NDArray[np.float64]:
    """Return x and y of the cells' centres, row by row, shape (H W, 2)."""
    x, y = np.meshgrid(grid.x_m, grid.y_m)
    return np.column_stack([x.ravel(), y.ravel()])
