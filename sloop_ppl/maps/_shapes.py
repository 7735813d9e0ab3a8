"""Project, repair and cut geometries, keeping only what is of their own dimension."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

__all__ = ["clip", "parts_of_dimension", "project", "repair"]

# What is left of a feature at the border of the map and nobody would see.
_MIN_LINE_M = 0.5
_MIN_AREA_M2 = 1.0


def clip(
    geometry: BaseGeometry, extent_m: tuple[float, float, float, float]
) -> BaseGeometry | None:
    """Return what of a geometry lies inside an extent, or None when next to nothing does.

    Parameters
    ----------
    geometry
        Shapely geometry, metres; areas must be valid.
    extent_m
        West, south, east, north, metres.

    Returns
    -------
    shapely geometry or None
        Points, lines or areas, as the given geometry is: the corners and edges where an area only
        touches the border are left out, and so are lines under 0.5 m and areas under 1 m2 that
        the border cuts off.
    """
    box = shapely.box(*extent_m)
    if shapely.covers(box, geometry):
        return geometry
    inside = parts_of_dimension(
        shapely.intersection(geometry, box), int(shapely.get_dimensions(geometry))
    )
    if inside is None or (inside.length < _MIN_LINE_M and inside.geom_type.endswith("LineString")):
        return None
    if inside.geom_type.endswith("Polygon") and inside.area < _MIN_AREA_M2:
        return None
    return inside


def project(
    geometry: BaseGeometry, convert: Callable[[Any, Any], tuple[NDArray[Any], NDArray[Any]]]
) -> BaseGeometry:
    """Return a geometry with x and y converted, altitudes kept."""

    def each(coordinates: NDArray[np.float64]) -> NDArray[np.float64]:
        x, y = convert(coordinates[:, 0], coordinates[:, 1])
        return np.column_stack([x, y, *coordinates.T[2:]])

    moved: BaseGeometry = shapely.transform(geometry, each, include_z=geometry.has_z)
    return moved


def repair(geometry: BaseGeometry) -> BaseGeometry | None:
    """Return an area as valid area that covers what its outline winds round; None if nothing."""
    # "structure" takes what the outline winds round; "linework" would go by where it crosses.
    sound = shapely.make_valid(geometry, method="structure", keep_collapsed=False)
    return parts_of_dimension(sound, 2)


def parts_of_dimension(geometry: BaseGeometry, dimension: int) -> BaseGeometry | None:
    """Return the parts of a geometry that are points (0), lines (1) or areas (2); None if none."""
    parts = [
        part
        for part in shapely.get_parts(_flat(geometry))
        if shapely.get_dimensions(part) == dimension and not part.is_empty
    ]
    if not parts:
        return None
    if len(parts) == 1:
        only: BaseGeometry = parts[0]
        return only
    joined: BaseGeometry = {
        0: shapely.multipoints,
        1: shapely.multilinestrings,
        2: shapely.multipolygons,
    }[dimension](parts)
    return joined


def _flat(geometry: BaseGeometry) -> BaseGeometry:
    """Return a geometry whose parts are simple: collections within collections are opened."""
    parts = shapely.get_parts(geometry)
    # get_parts opens one level; a collection may hold collections.
    while any(part.geom_type.startswith(("Multi", "GeometryCollection")) for part in parts):
        parts = shapely.get_parts(parts)
    flat: BaseGeometry = shapely.geometrycollections(parts)
    return flat
