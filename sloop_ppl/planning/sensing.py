"""The fan sensor: which cells a robot sees from a pose, for every user of that question."""

from __future__ import annotations

import math
from functools import cache

__all__ = ["HEADINGS", "cells_between", "fan_offsets"]

HEADINGS = 8
"""Directions a robot can face, 45 degrees apart, anticlockwise from east."""

# Takes rounding out of comparisons between distances and angles on the lattice.
_SLACK = 1e-9


def fan_offsets(
    heading: int, range_cells: float, min_range_cells: float = 1.0, fov_deg: float = 90.0
) -> tuple[tuple[int, int], ...]:
    """Return the cells in a fan, relative to the robot's cell.

    Parameters
    ----------
    heading : direction of the fan's axis in eighths of a turn, anticlockwise from east.
    range_cells, min_range_cells : distances between cell centres that are seen, cells, closed.
    fov_deg : opening of the fan, degrees, in (0, 360]; its borders are seen.

    Returns
    -------
    tuple
        ``(rows north, columns east)`` of each cell seen, ordered by row, then column.

    Examples
    --------
    >>> fan_offsets(0, range_cells=1)
    ((0, 1),)
    >>> fan_offsets(1, range_cells=1)
    ((0, 1), (1, 0))
    """
    reach = math.floor(range_cells + _SLACK)
    axis = heading * 2 * math.pi / HEADINGS
    seen = []
    for row in range(-reach, reach + 1):
        for col in range(-reach, reach + 1):
            distance = math.hypot(row, col)
            if not min_range_cells - _SLACK <= distance <= range_cells + _SLACK:
                continue
            off_axis = math.remainder(math.atan2(row, col) - axis, 2 * math.pi)
            if distance == 0 or abs(off_axis) <= math.radians(fov_deg) / 2 + _SLACK:
                seen.append((row, col))
    return tuple(seen)


@cache
def cells_between(rows: int, cols: int) -> tuple[tuple[tuple[int, int], ...], ...]:
    """Return the cells strictly between a cell and another one, seen along a straight line.

    Parameters
    ----------
    rows, cols : where the other cell is, cells north and east.

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
    n = max(abs(rows), abs(cols))
    between = []
    for k in range(1, n):
        across = [(r, c) for r in _nearest(rows * k, n) for c in _nearest(cols * k, n)]
        between.append(tuple(across))
    return tuple(between)


def _nearest(numerator: int, denominator: int) -> tuple[int, ...]:
    """Return the whole number nearest to a fraction, or both when two are equally near."""
    low = numerator // denominator
    over = 2 * (numerator - low * denominator)
    if over == denominator:
        return low, low + 1
    return (low,) if over < denominator else (low + 1,)
