"""Lay many geometries out as runs of points, so that a few array operations move them all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

__all__ = ["AREA", "DOT", "HOLE", "LINE", "Shapes", "laid_out", "spans"]

AREA, HOLE, LINE, DOT = range(4)
"""What a run of points is: an outline to fill, one to leave out of it, a line, or one point."""

_POINT, _POLYGON, _MULTIPOINT = 0, 3, 4  # numbers of shapely; all from the last one on have parts


@dataclass(frozen=True, eq=False)
class Shapes:
    """Runs of points, in the order of the geometries that they are taken from.

    Shape legend: G geometries, R runs, P points.

    Parameters
    ----------
    points : x + iy of each, metres, shape (P,).
    point : first point of each run, and P, shape (R + 1,).
    kind : `AREA`, `HOLE`, `LINE` or `DOT`, shape (R,). A hole follows the area it is in.
    run : first run of each geometry, and R, shape (G + 1,).
    """

    points: NDArray[np.complex128]
    point: NDArray[np.intp]
    kind: NDArray[np.intp]
    run: NDArray[np.intp]


def laid_out(geometries: NDArray[np.object_]) -> Shapes:
    """Return the runs of points that some geometries, those of several parts too, are made of."""
    parts, owner = geometries, np.arange(len(geometries))
    while ((types := shapely.get_type_id(parts)) >= _MULTIPOINT).any():
        parts, within = shapely.get_parts(parts, return_index=True)
        owner = owner[within]
    areas, others = np.flatnonzero(types == _POLYGON), np.flatnonzero(types != _POLYGON)
    rings, of_area = shapely.get_rings(parts[areas], return_index=True)
    part = np.concatenate([areas[of_area], others])
    hole = np.zeros(len(rings), dtype=bool)
    hole[1:] = of_area[1:] == of_area[:-1]
    kind = np.concatenate([
        np.where(hole, HOLE, AREA), np.where(types[others] == _POINT, DOT, LINE)
    ])  # fmt: skip
    order = np.argsort(part, kind="stable")
    xy, run = shapely.get_coordinates(
        np.concatenate([rings, parts[others]])[order], return_index=True
    )
    return Shapes(
        xy.view(np.complex128)[:, 0],
        _starts(run, len(order)),
        kind[order],
        _starts(owner[part[order]], len(geometries)),
    )


def spans(
    starts: NDArray[np.intp], which: NDArray[np.intp]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return what the chosen spans hold, one after the other, and where each then starts.

    Parameters
    ----------
    starts : first member of each span, and the end of the last, shape (S + 1,).
    which : the spans wanted, shape (K,).

    Returns
    -------
    tuple of numpy.ndarray
        The members, and the first of each of the K spans among them with their number last,
        shape (K + 1,).
    """
    count = starts[which + 1] - starts[which]
    ends = np.zeros(len(which) + 1, dtype=np.intp)
    np.cumsum(count, out=ends[1:])
    return np.repeat(starts[which] - ends[:-1], count) + np.arange(ends[-1]), ends


def _starts(owner: NDArray[Any], count: int) -> NDArray[np.intp]:
    """Return where the members of each owner start in a sorted list of owners, and its length."""
    return np.searchsorted(owner, np.arange(count + 1))
