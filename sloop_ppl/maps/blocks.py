"""The blocks between the streets of a map."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps.crossings import Crossing
from sloop_ppl.maps.street_axes import StreetAxis

__all__ = ["Block", "corner_towards", "find_blocks"]

# An island between carriageways is no block: without the streets less than this is left of it,
# either in width or in area.
_LEAST_WIDTH_M = 8.0
_LEAST_AREA_M2 = 150.0
# A street bounds a block when so much of the block's outline lies on it.
_LEAST_EDGE_M = 5.0
# A crossing of a divided road lies this far from the corner of the block at most.
_CORNER_M = 20.0


@dataclass(frozen=True, eq=False)
class Block:
    """An area between streets that no street parts.

    Parameters
    ----------
    number
        Its position in `StreetNetwork.blocks`.
    polygon
        Its outline on the axes of the streets around it, metres.
    streets
        Positions of these streets in `StreetNetwork.streets`, ascending.
    corners
        Positions of the crossings at its corners in `StreetNetwork.crossings`, ascending.
    cut
        Whether the border of the map cuts it.
    """

    number: int
    polygon: shapely.Polygon
    streets: tuple[int, ...]
    corners: tuple[int, ...]
    cut: bool


def find_blocks(
    axes: Sequence[StreetAxis],
    crossings: Sequence[Crossing],
    extent_m: tuple[float, float, float, float],
) -> tuple[Block, ...]:
    """Return the blocks of a map, southernmost first; none where no street bounds any.

    Parameters
    ----------
    axes, crossings
        The streets and where they cross.
    extent_m
        West, south, east and north border of the map, metres; blocks end there, too.
    """
    bounding = [i for i, axis in enumerate(axes) if axis.bounds_blocks]
    if not bounding:
        return ()
    area = shapely.box(*extent_m)
    # What lies on it was computed, and may miss it by rounding.
    border = shapely.buffer(area.exterior, 0.01)
    lines = shapely.union_all([axes[i].lines for i in bounding])
    # A union has a node wherever two lines meet, which is what polygonising asks for.
    noded = shapely.union_all([shapely.intersection(lines, area), area.exterior])
    pieces = shapely.get_parts(shapely.polygonize(shapely.get_parts(noded)))
    surfaces = np.array([shapely.buffer(axes[i].lines, axes[i].width_m / 2) for i in bounding])
    medians = np.array([axes[i].median for i in bounding])
    roads = shapely.STRtree(surfaces)
    kept = []
    for piece in pieces:
        beside = roads.query(piece, predicate="intersects")
        # Of long roads only what is near, or each block would cost as much as all.
        around = shapely.buffer(piece.envelope, 1.0)
        surface = shapely.union_all(shapely.intersection(surfaces[beside], around))
        median = shapely.union_all(shapely.intersection(medians[beside], around))
        if not _is_island(piece, surface, median, border):
            kept.append(piece)
    kept.sort(key=lambda p: (round(p.centroid.y, 3), round(p.centroid.x, 3)))
    near = [shapely.buffer(axes[i].lines, 0.01) for i in bounding]
    tree = shapely.STRtree(near)
    corners = [k for k, crossing in enumerate(crossings) if crossing.is_corner]
    points = shapely.STRtree([shapely.Point(crossings[k].point_m) for k in corners])
    blocks = []
    for number, polygon in enumerate(kept):
        outline = shapely.boundary(polygon)  # round holes, too
        streets = sorted(
            bounding[i]
            for i in tree.query(outline, predicate="intersects")
            if shapely.intersection(near[i], outline).length >= _LEAST_EDGE_M
        )
        rim = shapely.intersection(border, outline)
        close = points.query(outline, predicate="dwithin", distance=_CORNER_M)
        at = sorted(
            k
            for k in (corners[i] for i in close)
            if len(set(crossings[k].streets) & set(streets)) > 1
        )
        blocks.append(Block(number, polygon, tuple(streets), tuple(at), rim.length > 0.1))
    return tuple(blocks)


def corner_towards(
    block: Block, crossings: Sequence[Crossing], bearing_rad: float
) -> Crossing | None:
    """Return the corner of a block that a bearing means, as "the NE corner of the block" does.

    Parameters
    ----------
    block, crossings
        The block and the crossings of its map.
    bearing_rad
        The bearing as seen from the middle of the block, radians anticlockwise from east.

    Returns
    -------
    Crossing or None
        The corner farthest in that direction, if it lies within 60 degrees of it.
    """
    middle = block.polygon.centroid
    found = []
    for k in block.corners:
        east, north = crossings[k].point_m[0] - middle.x, crossings[k].point_m[1] - middle.y
        ahead = east * math.cos(bearing_rad) + north * math.sin(bearing_rad)
        if ahead > math.hypot(east, north) / 2:
            found.append((ahead, -k))
    return crossings[-max(found)[1]] if found else None


def _is_island(
    polygon: shapely.Polygon, surface: BaseGeometry, medians: BaseGeometry, rim: BaseGeometry
) -> bool:
    # What the border cuts may be a corner of a large block.
    share = 0.25 if shapely.intersects(polygon, rim) else 1.0
    free = shapely.difference(polygon, surface)
    if free.area < share * _LEAST_AREA_M2:
        return True
    if shapely.buffer(free, -share * _LEAST_WIDTH_M / 2).is_empty:
        return True
    return bool(shapely.intersection(free, medians).area > 0.8 * free.area)
