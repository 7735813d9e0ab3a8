"""A small drawing of a map, for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from sloop_ppl._html import svg_map
from sloop_ppl.maps.grid import Grid
from sloop_ppl.maps.landmark import Landmark

__all__ = ["city_svg"]

_MOST = 400
"""Landmarks that are drawn: of more, the largest."""

_STYLES = {
    "building": 'fill="#d9d6ce" stroke="#b3aea2" stroke-width=".5"',
    "park": 'fill="#cfe3c5"',
    "water": 'fill="#c4dcec"',
    "square": 'fill="#ece6d6"',
    "parking": 'fill="#e6e6ea"',
}
_LINE = 'fill="none" stroke="#ffffff" stroke-width="2.5"'


class Drawn(Protocol):
    """What is drawn: a map."""

    @property
    def grid(self) -> Grid:
        """Its cells."""

    @property
    def landmarks(self) -> tuple[Landmark, ...]:
        """Its landmarks."""


def city_svg(
    city: Drawn,
    title: str,
    *,
    heat: NDArray[np.float64] | None = None,
    path: Sequence[tuple[float, float]] = (),
    marks: Iterable[tuple[float, float, str]] = (),
) -> str:
    """Return a map as SVG; `heat` is over its cells, the rest as in `svg_map`."""
    extent = city.grid.cells_extent_m
    drawn = [m for m in city.landmarks if m.geometry.geom_type != "Point"]
    if len(drawn) > _MOST:
        sizes = np.array([m.geometry.length for m in drawn])
        drawn = [drawn[i] for i in sorted(np.argsort(-sizes, kind="stable")[:_MOST])]
    shapes = []
    for landmark in sorted(drawn, key=lambda m: m.kind == "building"):
        for line in _outlines(shapely.clip_by_rect(landmark.geometry, *extent)):
            style = _STYLES.get(landmark.kind, _LINE)
            shapes.append((style if line.is_closed else _LINE, list(line.coords)))
    return svg_map(extent, shapes=shapes, heat=heat, path=path, marks=marks, title=title)


def _outlines(geometry: BaseGeometry) -> list[BaseGeometry]:
    """Return the outer rings and lines of a geometry."""
    lines = []
    for part in shapely.get_parts(geometry):
        line = part.exterior if part.geom_type == "Polygon" else part
        if line.geom_type in ("LineString", "LinearRing") and not line.is_empty:
            lines.append(line)
    return lines
