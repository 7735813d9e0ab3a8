"""The region that a part of a street means: a side, a corner, an end, the middle of a block."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import numpy as np
import shapely
import shapely.ops
from shapely.geometry.base import BaseGeometry

from sloop_ppl.language import StreetPart
from sloop_ppl.maps import CityMap, Crossing, house_numbers, street_network, street_side
from sloop_ppl.maps.street_places import SIDE_M, street_band
from sloop_ppl.models._street_regions import same_block_region, street_side_region

__all__ = ["part_region"]

Grounds = tuple[str, ...]

_MIDDLE = 0.25
"""Share of a block's edge at either end that is not its middle: what is nearer to a corner than to
the middle of the block belongs to the corner."""

_DOOR_M = 8.0
"""How far from the place of its number a house reaches, metres: half a front."""

_ARC_STEPS = 16  # corners of a quarter of a disc: 1 - cos(pi / 64) = .1 % of its radius is cut off


def part_region(city: CityMap, grounds: Grounds, part: StreetPart) -> BaseGeometry | None:
    """Return the region that a part of some grounds means.

    Parameters
    ----------
    city
        The map.
    grounds
        Ids of the street, or of the streets that meet; of ``"block"`` of any landmark.
    part
        The part.

    Returns
    -------
    shapely geometry or None
        Metres. A side is 15 m deep from the kerb; a corner reaches 15 m beyond the widest street
        that meets there, of its quadrant when a bearing is given, and is all corners of a street
        that stands alone; the middle of a block is the middle half between two corners, with both
        sides; a house number is interpolated. None where the map does not have the part: no
        street, no crossing, no numbers that reach so far.
    """
    return _REGIONS[part.kind](city, grounds, part)


def _side(city: CityMap, grounds: Grounds, part: StreetPart) -> BaseGeometry | None:
    if part.bearing_rad is not None:
        return street_side(city, grounds[0], part.bearing_rad)
    if part.number is None:
        return street_side_region(city, grounds[:1])
    network, numbers = street_network(city), house_numbers(city, grounds[0])
    axis = network.street(grounds[0])
    if axis is None or numbers is None or numbers.even_on_left is None:
        return None
    left = numbers.even_on_left == (part.number % 2 == 0)
    return _union([street_band(network, axis, numbers.line, left, SIDE_M)])


def _corner(city: CityMap, grounds: Grounds, part: StreetPart) -> BaseGeometry | None:
    network = street_network(city)
    corners = [c for c in network.crossings_of(*grounds) if c.is_corner or len(grounds) > 1]
    return _union(
        _around(c, max(network.streets[i].width_m for i in c.streets) / 2, part.bearing_rad)
        for c in corners
    )


def _around(crossing: Crossing, half_width_m: float, bearing_rad: float | None) -> BaseGeometry:
    """Return the disc about a crossing, or of it the corner that a bearing means."""
    disc = shapely.Point(crossing.point_m).buffer(half_width_m + SIDE_M, quad_segs=_ARC_STEPS)
    if bearing_rad is None:
        return disc
    begin, end = crossing.sector(bearing_rad)
    # A wedge that reaches beyond the disc; its outer edge is drawn in steps of 10 degrees at most.
    far_m, steps = 2 * (half_width_m + SIDE_M), max(2, math.ceil((end - begin) / 0.17) + 1)
    at = np.linspace(begin, end, steps)
    x, y = crossing.point_m
    rim = np.column_stack([x + far_m * np.cos(at), y + far_m * np.sin(at)])
    wedge = shapely.Polygon([crossing.point_m, *map(tuple, rim)])
    return shapely.intersection(disc, wedge)


def _block_corner(city: CityMap, grounds: Grounds, part: StreetPart) -> BaseGeometry | None:
    """Return the corners that a bearing means of the blocks along a street.

    The north-east corner of a block lies south-west of a crossing.
    """
    network = street_network(city)
    at = network.position(grounds[0])
    found = []
    for block in network.blocks:
        if at is None or at not in block.streets or part.bearing_rad is None:
            continue
        crossing = network.corner_of(block, part.bearing_rad)
        if crossing is not None and at in crossing.streets:
            half = max(network.streets[i].width_m for i in crossing.streets) / 2
            found.append(shapely.intersection(_around(crossing, half, None), block.polygon))
    return _union(found)


def _mid_block(city: CityMap, grounds: Grounds, part: StreetPart) -> BaseGeometry | None:  # noqa: ARG001 - as the others
    network = street_network(city)
    return _union(
        shapely.ops.substring(s.line, _MIDDLE, 1 - _MIDDLE, normalized=True).buffer(
            network.streets[s.street].width_m / 2 + SIDE_M, cap_style="flat"
        )
        for s in network.stretches_of(grounds[0])
        if not (s.start_open or s.end_open)
    )


def _end(city: CityMap, grounds: Grounds, part: StreetPart) -> BaseGeometry | None:
    network = street_network(city)
    axis, ends = network.street(grounds[0]), network.ends(grounds[0])
    if axis is None or not ends:
        return None
    if part.bearing_rad is not None:
        way = np.array([math.cos(part.bearing_rad), math.sin(part.bearing_rad)])
        ends = (max(ends, key=lambda end: float(np.dot(end.point_m, way))),)
    else:
        # Where the border of the map cuts a street it does not end, unless nothing is known else.
        ends = tuple(end for end in ends if end.kind != "border") or ends
    reach = axis.width_m / 2 + SIDE_M
    return _union(shapely.Point(end.point_m).buffer(reach) for end in ends)


def _number(city: CityMap, grounds: Grounds, part: StreetPart) -> BaseGeometry | None:
    numbers = house_numbers(city, grounds[0])
    place = None if numbers is None or part.number is None else numbers.locate(part.number)
    return None if place is None else shapely.Point(place).buffer(_DOOR_M)


def _block(city: CityMap, grounds: Grounds, part: StreetPart) -> BaseGeometry | None:  # noqa: ARG001 - as the others
    return same_block_region(city, grounds)


def _union(shapes: Iterable[BaseGeometry]) -> BaseGeometry | None:
    whole = shapely.union_all(list(shapes))
    return None if whole.is_empty else whole


_REGIONS: dict[str, Callable[[CityMap, Grounds, StreetPart], BaseGeometry | None]] = {
    "side": _side,
    "corner": _corner,
    "block-corner": _block_corner,
    "mid-block": _mid_block,
    "end": _end,
    "number": _number,
    "block": _block,
}
