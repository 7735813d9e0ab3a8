"""A map as what a page draws: outlines in metres with names and kinds."""

from __future__ import annotations

from typing import Any

import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps import CityMap, Landmark

__all__ = ["scene_of"]

_ORDER = ("park", "water", "square", "parking", "street", "service", "pedestrian", "building")
"""Kinds from the ground up; what is none of them is drawn last."""

_ROAD_WIDTHS_M = {"street": 8.0, "service": 4.0, "pedestrian": 2.0}
_LINEAR = ("LineString", "MultiLineString", "LinearRing")


def scene_of(city: CityMap, key: str) -> dict[str, Any]:
    """Return what is drawn of a map.

    Parameters
    ----------
    city
        The map.
    key
        What requests call it.
    """
    grid = city.grid
    order = {kind: place for place, kind in enumerate(_ORDER)}
    landmarks = sorted(city.landmarks, key=lambda m: order.get(m.kind, len(order)))
    return {
        "key": key,
        "name": city.name,
        "digest": city.digest,
        "attribution": city.attribution,
        "extent_m": list(grid.extent_m),
        "cells_extent_m": list(grid.cells_extent_m),
        "cell_m": grid.cell_m,
        "shape": list(grid.shape),
        "landmarks": [_drawn(city, landmark) for landmark in landmarks],
    }


def _drawn(city: CityMap, landmark: Landmark) -> dict[str, Any]:
    geometry = shapely.set_precision(landmark.geometry, 0.05, mode="pointwise")
    x, y = city.centroid(landmark.id)
    drawn: dict[str, Any] = {
        "id": landmark.id,
        "name": landmark.name,
        "kind": landmark.kind,
        "path": _path(geometry),
        "at": [round(x, 2), round(y, 2)],
        "label_at": [round(v, 2) for v in _label_place(landmark.geometry)],
        "size_m": round(float(landmark.geometry.area**0.5 or landmark.geometry.length), 1),
    }
    if geometry.geom_type in _LINEAR:
        drawn["width_m"] = landmark.width_m or _ROAD_WIDTHS_M.get(landmark.kind, 2.0)
    if not drawn["path"]:
        # A point is drawn as one, but it takes the cells of the building it stands in.
        drawn["point"] = drawn["label_at"]
        footprint = city.footprint(landmark.id)
        drawn["path_within"] = _path(footprint) if footprint is not landmark.geometry else ""
    return drawn


def _label_place(geometry: BaseGeometry) -> tuple[float, float]:
    point = geometry.representative_point()
    return float(point.x), float(point.y)


def _path(geometry: BaseGeometry) -> str:
    """Return the outline as path data, y down as in SVG; empty for points."""
    parts = getattr(geometry, "geoms", [geometry])
    return "".join(_part(part) for part in parts)


def _part(geometry: BaseGeometry) -> str:
    if geometry.geom_type == "Polygon":
        rings = (geometry.exterior, *geometry.interiors)
        return "".join(f"{_line(ring)}Z" for ring in rings if not ring.is_empty)
    return _line(geometry) if geometry.geom_type in _LINEAR else ""


def _line(line: BaseGeometry) -> str:
    return "M" + "L".join(f"{x:.1f} {-y:.1f}" for x, y, *_ in line.coords)
