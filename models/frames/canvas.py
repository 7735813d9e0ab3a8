"""Draw strokes on the planes of pictures, one picture after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from sloop_ppl.models.frames.shapes import AREA, DOT, LINE

__all__ = ["SHARPER", "Strokes", "drawn"]

SHARPER = 2
"""Pictures are drawn so much finer, then averaged."""


@dataclass(frozen=True, eq=False)
class Strokes:
    """What is to be drawn on N pictures, in order; lists, for the pen takes no arrays.

    Parameters
    ----------
    stroke : first stroke of each picture, and their number S; N + 1 numbers.
    plane, kind, width : of each stroke: the plane, `AREA`, `HOLE`, `LINE` or `DOT`, and how wide
        a line is, fine pixels.
    point : first point of each stroke, and their number; S + 1 numbers.
    xy : x and y of all points in turn, fine pixels from the corner.
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
    layers : strokes of the same N pictures, at least one; what comes later is drawn over.
    planes : how many there are; a stroke leaves all but its own as they are.
    pixels : pixels a side.
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
