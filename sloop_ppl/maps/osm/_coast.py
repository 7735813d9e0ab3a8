"""Tell the sea from the land by the coastline, which has the water on its right."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps._shapes import parts_of_dimension
from sloop_ppl.maps.grid import Grid
from sloop_ppl.maps.osm._feature import OsmFeature, source_key
from sloop_ppl.maps.osm._pieces import Piece

__all__ = ["sea"]

# How far beside the shore it is asked whether a face lies there, metres.
_BESIDE_M = 0.05
# Share of its shore that must have a face on the right for it to be sea.
_SURE = 0.9


def sea(features: list[OsmFeature], grid: Grid) -> Piece | None:
    """Return the sea within a grid's extent as one nameless water; None when no coast crosses it.

    Notes
    -----
    The coast cuts the extent into faces. A face is sea when it lies on the right of the coast along
    nine tenths of its shore; a coast that ends inside the extent cuts nothing off.
    """
    coasts = [f for f in features if f.tags.get("natural") == "coastline" and _line(f) is not None]
    lines = [_line(f) for f in coasts]
    box = shapely.box(*grid.extent_m)
    shore = [part for line in lines for part in shapely.get_parts(shapely.intersection(line, box))]
    shore = [part for part in shore if part.geom_type == "LineString" and part.length > 0]
    if not shore:
        return None
    # Cut wherever lines meet, for polygonize takes them as they are.
    noded = shapely.get_parts(shapely.union_all([box.exterior, *shore]))
    faces = shapely.get_parts(shapely.polygonize([shapely.geometrycollections(noded)]))
    wet = [face for face in faces if _is_sea(face, shore)]
    if not wet:
        return None
    area = parts_of_dimension(shapely.union_all(wet), 2)
    if area is None:
        return None
    sources = sorted((f.source for f in coasts), key=source_key)
    return Piece(sources, "water", "Sea", None, {"natural": "coastline"}, area)


def _line(feature: OsmFeature) -> BaseGeometry | None:
    if feature.outline is not None:
        return feature.outline
    return feature.geometry if feature.geometry.geom_type == "LineString" else None


def _is_sea(face: BaseGeometry, shore: list[BaseGeometry]) -> bool:
    right = left = 0.0
    shapely.prepare(face)
    for line in shore:
        ends = shapely.get_coordinates(line)
        along = np.diff(ends, axis=0)
        length = np.hypot(*along.T)
        some = length > 0
        middle, along, length = ((ends[:-1] + ends[1:]) / 2)[some], along[some], length[some]
        # (dy, -dx) / length points to the right of the way.
        beside = _BESIDE_M * np.column_stack([along[:, 1], -along[:, 0]]) / length[:, None]
        right += float(length[shapely.contains_xy(face, middle + beside)].sum())
        left += float(length[shapely.contains_xy(face, middle - beside)].sum())
    return right > 0 and right >= _SURE * (right + left)
