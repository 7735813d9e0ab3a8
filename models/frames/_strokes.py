"""Lay geometries out as runs of points, and draw these as strokes on pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from PIL import Image, ImageDraw

__all__ = ["SHARPER", "Shapes", "Strokes", "drawn", "laid_out", "spans"]

AREA, HOLE, LINE, DOT = range(4)
"""What a run of points is: an outline to fill, one to leave out of it, a line, or one point."""

_POINT, _POLYGON, _MULTIPOINT = 0, 3, 4  # numbers of shapely; all from the last one on have parts

SHARPER = 2
"""Pictures are drawn so much finer, then averaged."""


@dataclass(frozen=True, eq=False)
class Shapes:
    """Runs of points, in the order of the geometries that they are taken from.

    Shape legend: G geometries, R runs, P points.

    Parameters
    ----------
    points
        x + iy of each, metres, shape (P,).
    point
        First point of each run, and P, shape (R + 1,).
    kind
        `AREA`, `HOLE`, `LINE` or `DOT`, shape (R,). A hole follows the area it is in.
    run
        First run of each geometry, and R, shape (G + 1,).
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
    starts
        First member of each span, and the end of the last, shape (S + 1,).
    which
        The spans wanted, shape (K,).

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


@dataclass(frozen=True, eq=False)
class Strokes:
    """What is to be drawn on N pictures, in order; lists, for the pen takes no arrays.

    Parameters
    ----------
    stroke
        First stroke of each picture, and their number S; N + 1 numbers.
    plane, kind, width
        Plane, kind and width of each stroke: the plane, `AREA`, `HOLE`, `LINE` or `DOT`, and how
        wide a line is, fine pixels.
    point
        First point of each stroke, and their number; S + 1 numbers.
    xy
        x and y of all points in turn, fine pixels from the corner.
    """

    stroke: list[int]
    plane: list[int]
    kind: list[int]
    width: list[int]
    point: list[int]
    xy: list[float]


def drawn(layers: Sequence[Strokes], planes: int, pixels: int) -> NDArray[np.float32]:
    """Return how much of each pixel is covered, 0 to 1, shape (N, planes, pixels, pixels).

    Parameters
    ----------
    layers
        Strokes of the same N pictures, at least one; what comes later is drawn over.
    planes
        How many there are; a stroke leaves all but its own as they are.
    pixels
        Pixels a side.
    """
    count, side = len(layers[0].stroke) - 1, pixels * SHARPER
    images = [Image.new("L", (side, side)) for _ in range(planes)]
    pens = [ImageDraw.Draw(image) for image in images]
    read = []
    for picture in range(count):
        for pen in pens:
            pen.rectangle((0, 0, side, side), fill=0)
        for layer in layers:
            _draw(pens, layer, layer.stroke[picture], layer.stroke[picture + 1])
        read += [image.tobytes() for image in images]
    fine = np.frombuffer(b"".join(read), np.uint8)
    fine = fine.reshape(count, planes, pixels, SHARPER, pixels, SHARPER)
    rows = reduce(np.add, (fine[:, :, :, row] for row in range(SHARPER)))
    covered = reduce(np.add, (rows[..., col] for col in range(SHARPER)))
    shares: NDArray[np.float32] = covered * np.float32(1 / SHARPER**2)
    return shares


def _draw(pens: Sequence[ImageDraw.ImageDraw], strokes: Strokes, first: int, end: int) -> None:
    point = strokes.point
    for i in range(first, end):
        pen, kind = pens[strokes.plane[i]], strokes.kind[i]
        xy = strokes.xy[2 * point[i] : 2 * point[i + 1]]
        if kind == LINE:
            pen.line(xy, fill=1, width=strokes.width[i])
        elif kind == DOT:
            pen.rectangle((xy[0] - 1, xy[1] - 1, xy[0], xy[1]), fill=1)
        else:
            pen.polygon(xy, fill=1 if kind == AREA else 0)
