"""Shapes on the map that relations to several grounds, to streets and to the map itself mean."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps import CityMap, Grid
from sloop_ppl.maps.landmark import PATH_KINDS

__all__ = [
    "across_region",
    "along_region",
    "between_region",
    "map_region",
    "meeting_point",
]

BESIDE_M = 5.0
"""How far from a street's edge, or from a wall, one still is along it, metres."""

OPPOSITE_M = 15.0
"""How deep the other side of a street is, metres."""

SIDE_SHARE = 0.4
"""Share of the map's width or height that one of its sides takes."""

_LEAST_WIDTH_M = 5.0
_SIDES: dict[str, tuple[int, int]] = {
    "north": (0, 1),
    "south": (0, -1),
    "east": (1, 0),
    "west": (-1, 0),
    "northeast": (1, 1),
    "northwest": (-1, 1),
    "southeast": (1, -1),
    "southwest": (-1, -1),
}


def between_region(shapes: Sequence[BaseGeometry]) -> BaseGeometry:
    """Return the region between two or more shapes: the hull of the parts that face each other.

    Parameters
    ----------
    shapes : footprints of the grounds, at least two, metres.

    Returns
    -------
    shapely geometry
        The segment between two points; the block between two parallel streets; the crossing of
        two streets that meet. What the grounds themselves cover is left out, unless nothing else
        would be left.

    Notes
    -----
    Of each ground only the part counts that is about as near to the others as it gets: within
    1.5 times its distance from them, and at least 10 m more.
    """
    facing = []
    for i, shape in enumerate(shapes):
        others = shapely.union_all([other for k, other in enumerate(shapes) if k != i])
        gap = shapely.distance(shape, others)
        part = shapely.intersection(shape, others.buffer(gap + max(10.0, 0.5 * gap)))
        facing.append(shape if part.is_empty else part)
    hull = shapely.convex_hull(shapely.union_all(facing))
    free = shapely.difference(hull, shapely.union_all(list(shapes)))
    return hull if free.is_empty else free


def meeting_point(shapes: Sequence[BaseGeometry]) -> BaseGeometry:
    """Return the point where shapes meet, or half way between the nearest parts of each two."""
    points = []
    for one, other in itertools.combinations(shapes, 2):
        common = shapely.intersection(one, other)
        if common.is_empty:
            common = shapely.shortest_line(one, other)
        points.append(common.centroid)
    return shapely.multipoints(points).centroid


def along_region(shape: BaseGeometry, width_m: float | None, is_line: bool) -> BaseGeometry:
    """Return what lies along a street, its verges included, or along the walls of an area.

    Parameters
    ----------
    shape : line, or footprint of something else, metres.
    width_m : width of a line, metres; what is narrower than 5 m on a drawing counts as 5 m.
    is_line : tell a street from an area.
    """
    if is_line:
        return shape.buffer(max(width_m or 0.0, _LEAST_WIDTH_M) / 2 + BESIDE_M)
    return shape.boundary.buffer(BESIDE_M) if shape.area else shape.buffer(BESIDE_M)


def across_region(city: CityMap, ground: str, street: str | None = None) -> BaseGeometry | None:
    """Return what lies across from a ground.

    Parameters
    ----------
    city : the map.
    ground : id of what one is across from.
    street : id of the street one crosses; the one the ground fronts when None.

    Returns
    -------
    shapely geometry or None
        Either side of a ground that is a street itself; else the ground's mirror image on the
        other side of the street, cut to 15 m behind the mirrored wall; None when the map has no
        street.
    """
    landmark = city.landmark(ground)
    if landmark.kind in PATH_KINDS and street is None:
        half = max(landmark.width_m or 0.0, _LEAST_WIDTH_M) / 2
        band = landmark.geometry.buffer(half + OPPOSITE_M)
        return shapely.difference(band, landmark.geometry.buffer(half))
    if street is None:
        facing = city.frontage(ground).best
        crossed = facing.street if facing else None
    else:
        crossed = city.landmark(street)
    if crossed is None or crossed.id == ground:
        return None
    shape = city.footprint(ground)
    wall, foot = shapely.get_coordinates(shapely.shortest_line(shape, crossed.geometry))
    gap = math.dist(wall, foot)
    if gap < 1e-6:  # it touches the street: across is away from its middle
        wall = np.array(city.centroid(ground))
        if math.dist(wall, foot) < 1e-6:
            return None
    over = (foot - wall) / math.dist(wall, foot)
    mirrored = shapely.transform(
        shape, lambda points: points - 2 * ((points - foot) @ over)[:, None] * over
    )
    return _strip(mirrored, foot, over, gap + OPPOSITE_M)


def map_region(grid: Grid, relation: str, relation_class: str) -> BaseGeometry:
    """Return the part of a map that a relation to the map itself means.

    Parameters
    ----------
    grid : the map's cells.
    relation : what was said, such as ``"middle"``.
    relation_class : its class; a compass class is a side or corner of the map.

    Returns
    -------
    shapely geometry
        The outer two fifths on that side, the middle two fifths, or all of the map's cells.
    """
    west, south, east, north = grid.cells_extent_m
    if relation_class not in _SIDES and relation != "middle":
        return shapely.box(west, south, east, north)
    along_x, along_y = _SIDES.get(relation_class, (0, 0))
    middle = relation == "middle"
    x0, x1 = _part(west, east, along_x, middle)
    y0, y1 = _part(south, north, along_y, middle)
    return shapely.box(x0, y0, x1, y1)


def _part(low: float, high: float, side: int, middle: bool) -> tuple[float, float]:
    size = (high - low) * SIDE_SHARE
    if side:
        return (high - size, high) if side > 0 else (low, low + size)
    return ((low + high - size) / 2, (low + high + size) / 2) if middle else (low, high)


def _strip(
    shape: BaseGeometry, foot: NDArray[np.float64], over: NDArray[np.float64], depth_m: float
) -> BaseGeometry:
    """Return what of a shape lies beyond a line by at most a depth."""
    along = np.array([-over[1], over[0]]) * 1e4
    near, far = foot, foot + over * depth_m
    band = shapely.polygons([near - along, near + along, far + along, far - along])
    part = shapely.intersection(shape, band)
    return shape if part.is_empty else part
