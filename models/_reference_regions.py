"""What a relation measures from, as shapes on the map, and how far each cell is from it."""

from __future__ import annotations

import hashlib
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from sloop_ppl.errors import InputError
from sloop_ppl.language import HEARER, RELATIONS, WHOLE_MAP, Relation, StreetPart
from sloop_ppl.language.relations import Region
from sloop_ppl.maps import CityMap, Grid, Landmark, LandmarkFields, UnevenGrid, uneven_fields
from sloop_ppl.maps.city import FIELDS
from sloop_ppl.maps.fields import BYTES_PER_CELL, landmark_fields
from sloop_ppl.maps.landmark import PATH_KINDS
from sloop_ppl.maps.rasterise import touched_cells
from sloop_ppl.models._street_parts import part_region
from sloop_ppl.models._street_regions import (
    block_region,
    crossing_region,
    same_block_region,
    street_side_region,
    stretch_region,
)
from sloop_ppl.registry import Registry

__all__ = [
    "REFERENCE_CELL_M",
    "REGIONS",
    "ReferenceRegion",
    "across_region",
    "along_region",
    "between_region",
    "distance_from",
    "ground_distance_m",
    "is_hearer",
    "is_map",
    "map_region",
    "meeting_point",
    "point_fields",
    "reference_region_of",
    "shape_fields",
    "with_points",
]

BESIDE_M = 5.0
"""How far from a street's edge, or from a wall, one still is along it, metres: a verge."""

OPPOSITE_M = 15.0
"""How deep the other side of a street is, metres: a front garden and part of a house."""

SIDE_SHARE = 0.4
"""Share of the map's width or height that one of its sides takes: over a third, so that sides and
middle overlap where people differ."""

_LEAST_WIDTH_M = 5.0  # a street drawn as a line without a width still is two lanes


@dataclass(frozen=True, eq=False)
class ReferenceRegion:
    """What a relation measures from.

    Parameters
    ----------
    shape
        Distance is that to the cells it touches, direction that from its centroid, metres.
    grounds
        When given, distance is that to the farthest of these grounds instead: a place is as near to
        a corner as it is to the street that is farther away.
    is_part
        True for a part of a street, such as a side, which takes the place of the relation's own
        direction: on the north side of a street one is at that side.
    """

    shape: BaseGeometry
    grounds: tuple[str, ...] = ()
    is_part: bool = False


def is_map(city: CityMap, ground: str) -> bool:
    """Tell whether a ground is the map itself."""
    return ground == WHOLE_MAP and ground not in city


def is_hearer(city: CityMap, ground: str) -> bool:
    """Tell whether a ground is the place of who listens."""
    return ground == HEARER and ground not in city


def with_points(city: CityMap, points: Mapping[str, tuple[float, float]]) -> CityMap:
    """Return a map with some points as landmarks too, for regions that take several grounds.

    Parameters
    ----------
    city
        The map.
    points
        Id -> (x, y), metres, inside the map or outside.
    """
    if not points:
        return city
    # A square has the shape it is drawn with; a poi would take that of a building around it.
    added = tuple(Landmark(name, "square", shapely.Point(xy)) for name, xy in points.items())
    key = f"with points {sorted(points.items())}"
    return city.derived(key, lambda: replace(city, landmarks=(*city.landmarks, *added), _cache={}))


def reference_region_of(
    relation: str,
    record: Relation,
    grounds: tuple[str, ...],
    city: CityMap,
    joint: bool,
    part: StreetPart | None = None,
) -> ReferenceRegion | None:
    """Return what a relation measures from; None when it is simply its one ground.

    Parameters
    ----------
    relation, record
        The canonical word and what it means of this ground.
    grounds
        Ids, distinct.
    joint
        True to give words with a region and several grounds their own meaning; the map as a
        ground always has its own.
    part
        The part of a street that is meant, which has its own region where the map has it.

    Notes
    -----
    Source: ours. The paper and its code read a relation to several grounds as one to each, and
    across and along as near.
    """
    if is_map(city, grounds[0]):
        return ReferenceRegion(map_region(city.grid, record))
    if not joint:
        return None
    key = f"reference region {RELATIONS.changes} of {relation} {' '.join(grounds)} {part}"
    return city.derived(key, lambda: _joint_region(relation, record, grounds, city, part))


def _joint_region(
    relation: str,
    record: Relation,
    grounds: tuple[str, ...],
    city: CityMap,
    part: StreetPart | None,
) -> ReferenceRegion | None:
    region = None if part is None else part_region(city, grounds, part)
    if region is not None:
        return ReferenceRegion(region, is_part=True)
    if record.region is not None and record.takes(len(grounds)):
        return _own_region(relation, record.region, grounds, city)
    if len(grounds) == 1:
        return None
    lines = [city.landmark(ground).geometry for ground in grounds]
    crossing = all("LineString" in line.geom_type for line in lines)
    shapes = lines if crossing else [city.footprint(ground) for ground in grounds]
    return ReferenceRegion(meeting_point(shapes), grounds)


def _own_region(
    relation: str, region: str | Region, grounds: tuple[str, ...], city: CityMap
) -> ReferenceRegion | None:
    shape: object = (REGIONS[region] if isinstance(region, str) else region)(city, grounds)
    if shape is None:
        return None
    if not isinstance(shape, BaseGeometry) or shape.is_empty:
        found = "empty" if isinstance(shape, BaseGeometry) else f"a {type(shape).__name__}"
        raise InputError(
            f"The region of relation '{relation}' to {' and '.join(grounds)} is {found}; "
            "expected a shape in metres, or None for the grounds themselves"
        )
    return ReferenceRegion(shape)


def _along(city: CityMap, grounds: tuple[str, ...]) -> BaseGeometry:
    landmark = city.landmark(grounds[0])
    is_line = "LineString" in landmark.geometry.geom_type
    shape = landmark.geometry if is_line else city.footprint(grounds[0])
    return along_region(shape, landmark.width_m, is_line)


def _across(city: CityMap, grounds: tuple[str, ...]) -> BaseGeometry | None:
    streets = [g for g in grounds if city.landmark(g).kind in PATH_KINDS]
    others = [g for g in grounds if g not in streets]
    street = streets[0] if streets and others else None
    return across_region(city, (others or streets)[0], street)


def _between(city: CityMap, grounds: tuple[str, ...]) -> BaseGeometry:
    return between_region([city.footprint(ground) for ground in grounds])


REGIONS: Registry[Region] = Registry("region")
"""Functions of the map and the grounds' ids that give the shape a relation measures from, by
name; `Relation.region` names one, or is one."""

REGIONS.add("along", _along)
REGIONS.add("across", _across)
REGIONS.add("between", _between)
REGIONS.add("street side", street_side_region)
REGIONS.add("crossing", crossing_region)
REGIONS.add("block", block_region)
REGIONS.add("stretch", stretch_region)
REGIONS.add("same block", same_block_region)


def between_region(shapes: Sequence[BaseGeometry]) -> BaseGeometry:
    """Return the region between two or more shapes: the hull of the parts that face each other.

    Parameters
    ----------
    shapes
        Footprints of the grounds, at least two, metres.

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
    shape
        Line, or footprint of something else, metres.
    width_m
        Width of a line, metres; what is narrower than 5 m on a drawing counts as 5 m.
    is_line
        Tell a street from an area.
    """
    if is_line:
        return shape.buffer(max(width_m or 0.0, _LEAST_WIDTH_M) / 2 + BESIDE_M)
    return shape.boundary.buffer(BESIDE_M) if shape.area else shape.buffer(BESIDE_M)


def across_region(city: CityMap, ground: str, street: str | None = None) -> BaseGeometry | None:
    """Return what lies across from a ground.

    Parameters
    ----------
    ground
        Id of what one is across from.
    street
        Id of the street one crosses; the one the ground fronts when None.

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


def map_region(grid: Grid, record: Relation) -> BaseGeometry:
    """Return the part of a map that a relation to the map itself means.

    Returns
    -------
    shapely geometry
        The outer two fifths on the side or in the corner of a compass word, the middle two
        fifths, or all of the map's cells.
    """
    west, south, east, north = grid.cells_extent_m
    middle = record.of_map == "middle"
    if record.bearing_rad is None and not middle:
        return shapely.box(west, south, east, north)
    x0, x1 = _part(west, east, _side(record.bearing_rad, math.cos), middle)
    y0, y1 = _part(south, north, _side(record.bearing_rad, math.sin), middle)
    return shapely.box(x0, y0, x1, y1)


def _side(bearing_rad: float | None, axis: Callable[[float], float]) -> int:
    """Return -1, 0 or 1: whether a direction points down an axis, across it, or up."""
    return 0 if bearing_rad is None else round(axis(bearing_rad))


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


REFERENCE_CELL_M = 5.0
"""Side of the cells that the paper's widths were set on, metres."""


def ground_distance_m(city: CityMap, ground: str) -> NDArray[np.float64]:
    """Return the distance from each cell's centre to the nearest cell of a ground, shape (H, W)."""
    return distance_from(city.grid, lambda grid: _on(city, grid).fields(ground))


def shape_fields(shape: BaseGeometry, grid: Grid) -> LandmarkFields:
    """Return distance and bearing of every cell as seen from a shape, kept as landmarks' are.

    Parameters
    ----------
    shape
        Shapely geometry, metres; it takes the cells it touches.
    """
    west, south, east, north = shape.bounds
    centre = shape.centroid

    def made() -> LandmarkFields:
        if isinstance(grid, UnevenGrid):
            return uneven_fields(grid, shape)
        place = float(centre.x), float(centre.y)
        longer = max(east - west, north - south)
        return landmark_fields(grid, touched_cells(grid, shape), place, longer)

    return FIELDS.get(
        (grid, hashlib.sha256(shape.wkb).hexdigest()),
        made,
        cost_bytes=grid.size * BYTES_PER_CELL,
    )


def point_fields(point_m: tuple[float, float], grid: Grid) -> LandmarkFields:
    """Return distance and bearing of every cell as seen from a point, which may be off the grid.

    Parameters
    ----------
    point_m
        The point, (x, y) in metres. The cell it lies in is its cell; off the grid it has none, so
        that `distance_m` and `nearest` of the fields, which count from cells, are of no use.
    grid
        The cells.
    """
    cells = np.zeros(grid.shape, dtype=np.bool_)
    if grid.contains(*point_m):
        cells[grid.cell_at(*point_m)] = True
    return FIELDS.get(
        (grid, f"point {point_m}"),
        lambda: landmark_fields(grid, cells, point_m, 0.0),
        cost_bytes=grid.size * BYTES_PER_CELL,
    )


def distance_from(grid: Grid, fields_on: Callable[[Grid], LandmarkFields]) -> NDArray[np.float64]:
    """Return the distance from each cell's centre to the nearest cell of a thing, shape (H, W).

    Parameters
    ----------
    fields_on
        Returns the fields of the thing on a grid.

    Notes
    -----
    Source: the published code measures from the ground's nearest cell, on cells of 5 m. A ground
    touches less on smaller cells, which would move every belief, so on a grid finer than 5 m the
    distance is still measured to the ground's 5 m cells; it is then not 0 all over the ground,
    and it is kept as the fields are.
    """
    if grid.cell_m >= REFERENCE_CELL_M:
        return fields_on(grid).distance_m
    coarse = fields_on(replace(grid, cell_m=REFERENCE_CELL_M))
    key = ("distance", grid, hashlib.sha256(coarse.cells.tobytes()).hexdigest())
    return FIELDS.get(key, lambda: _distance_to(coarse, grid), cost_bytes=8 * grid.size)


def _distance_to(coarse: LandmarkFields, grid: Grid) -> NDArray[np.float64]:
    """Return the distance from the cells of a fine grid to the nearest cell of a coarse one."""
    rows, cols = coarse.nearest
    x, y = coarse.grid.x_m, coarse.grid.y_m
    row = np.clip(((grid.y_m - y[0]) / REFERENCE_CELL_M).round().astype(int), 0, len(y) - 1)
    col = np.clip(((grid.x_m - x[0]) / REFERENCE_CELL_M).round().astype(int), 0, len(x) - 1)
    best = np.full(grid.shape, np.inf)
    # The nearest of the cells that are nearest to the coarse cells around a point is the point's.
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            near = np.ix_(np.clip(row + down, 0, len(y) - 1), np.clip(col + right, 0, len(x) - 1))
            north = grid.y_m[:, None] - y[rows[near]]
            east = grid.x_m[None, :] - x[cols[near]]
            np.minimum(best, np.hypot(north, east), out=best)
    return best


def _on(city: CityMap, grid: Grid) -> CityMap:
    return city if grid == city.grid else city.with_grid(grid)
