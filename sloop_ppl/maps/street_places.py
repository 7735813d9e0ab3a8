"""Places that people name by streets: a side, the same block, across the street."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import groupby

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps._along import nearest_on_lines
from sloop_ppl.maps.blocks import Block
from sloop_ppl.maps.city import CityMap
from sloop_ppl.maps.street_axes import StreetAxis
from sloop_ppl.maps.street_network import StreetNetwork, street_network
from sloop_ppl.maps.street_tables import block_table

__all__ = ["SIDE_M", "across_street", "blocks_of", "same_block", "street_band", "street_side"]

SIDE_M = 15.0
"""How deep the side of a street is from the kerb, metres: a pavement and a house front."""

# A block belongs to a landmark that covers at least so much of it as a share of what it covers of
# the block it covers most of: a corner that reaches over the street does not count.
_SHARE = 0.25
# A street has no side towards a bearing where it runs within 15 degrees of it.
_LEAST_COSINE = math.sin(math.radians(15.0))


def blocks_of(city: CityMap, landmark_id: str) -> tuple[Block, ...]:
    """Return the blocks a landmark lies in; those on either side of a street.

    Parameters
    ----------
    city
        The map.
    landmark_id
        Id of any landmark.

    Returns
    -------
    tuple of Block
        By their number; empty where the map has no blocks, and for what lies off them.
    """
    landmark = city.landmark(landmark_id)
    network = street_network(city)
    shape = landmark.geometry
    if landmark.kind != "poi" or shape.geom_type != "Point":
        shape = city.footprint(landmark_id)
    if shape.area == 0:
        return tuple(b for b in network.blocks if shapely.intersects(b.polygon, shape))
    shares = [float(shapely.intersection(b.polygon, shape).area) for b in network.blocks]
    least = max([*shares, 0.0]) * _SHARE
    found = zip(network.blocks, shares, strict=True)
    return tuple(block for block, share in found if share > 0 and share >= least)


def same_block(city: CityMap, landmark_id: str) -> NDArray[np.bool_]:
    """Return the cells on the block of a landmark, shape (H, W); none where it has no block."""
    numbers = [block.number for block in blocks_of(city, landmark_id)]
    return np.isin(block_table(city), numbers)


def across_street(city: CityMap, landmark_id: str, depth_m: float = SIDE_M) -> BaseGeometry | None:
    """Return what lies across the street from a landmark.

    Parameters
    ----------
    city
        The map.
    landmark_id
        Id of any landmark. Of a street either side is across.
    depth_m
        How deep the other side is from the kerb, metres, > 0.

    Returns
    -------
    shapely geometry or None
        The other side of the street nearest to the landmark, on the same stretch between corners;
        service roads count where there is nothing else. None where the map has no street.
    """
    network = street_network(city)
    own = network.street(landmark_id)
    if own is not None:
        return _joined(
            street_band(network, own, spine, left, depth_m)
            for spine in own.spines
            for left in (True, False)
        )
    stretches = [s for s in network.stretches if network.streets[s.street].bounds_blocks]
    # An alley at the back is no street that one is across from, unless there is no other.
    roads = [s for s in stretches if network.streets[s.street].kind != "service"] or stretches
    if not roads:
        return None
    shape = city.footprint(landmark_id)
    nearest = min(roads, key=lambda stretch: float(shapely.distance(shape, stretch.line)))
    middle = shapely.get_coordinates(shape.centroid)
    left = bool(nearest_on_lines([nearest.line], middle).on_left[0])
    axis = network.streets[nearest.street]
    band = street_band(network, axis, nearest.line, not left, depth_m)
    return None if band.is_empty else band


def street_side(
    city: CityMap, street_id: str, bearing_rad: float, depth_m: float = SIDE_M
) -> BaseGeometry | None:
    """Return one side of a street.

    Parameters
    ----------
    city
        The map.
    street_id
        Id of any landmark of the street.
    bearing_rad
        The side, as the direction from the axis, radians anticlockwise from east: pi / 2 for the
        north side.
    depth_m
        How deep it is from the kerb, metres, > 0.

    Returns
    -------
    shapely geometry or None
        Where the street winds each part has its own side; a part that runs within 15 degrees of
        the bearing has none. None for what is no street, or has no such side at all.
    """
    network = street_network(city)
    axis = network.street(street_id)
    if axis is None:
        return None
    towards = np.array([math.cos(bearing_rad), math.sin(bearing_rad)])
    return _joined(
        street_band(network, axis, run, left, depth_m)
        for spine in axis.spines
        for run, left in _runs(spine, towards)
    )


def street_band(
    network: StreetNetwork, axis: StreetAxis, line: shapely.LineString, left: bool, depth_m: float
) -> BaseGeometry:
    """Return the strip beside the carriageway on one side of a part of a street's spine.

    Parameters
    ----------
    network, axis
        The street and its network.
    line
        The part of its spine, metres.
    left
        Whether the strip on the left of the line's direction is asked for.
    depth_m
        Its depth from the kerb, metres.

    Returns
    -------
    shapely geometry
        An area without the carriageways of other streets; empty where nothing is left.
    """
    carriageway = axis.carriageway
    reach = axis.width_m / 2 + depth_m
    near = shapely.buffer(shapely.intersection(axis.lines, shapely.buffer(line, 30.0)), reach)
    strip = shapely.buffer(line, reach, cap_style="flat")
    if not axis.median.is_empty:
        # The kerb of the other carriageway is farther from the spine than half a width.
        strip = shapely.intersection(shapely.buffer(line, reach + 30.0, cap_style="flat"), near)
    others = [
        shapely.buffer(other.lines, other.width_m / 2)
        for other in network.streets
        if other is not axis and other.bounds_blocks and shapely.intersects(other.lines, strip)
    ]
    free = shapely.difference(strip, shapely.union_all([carriageway, *others]))
    parts = [p for p in shapely.get_parts(free) if p.area > 0]
    if not parts:
        return shapely.Polygon()
    inside = shapely.get_coordinates(shapely.point_on_surface(parts))
    sides = nearest_on_lines([line], inside).on_left
    return shapely.union_all([p for p, side in zip(parts, sides, strict=True) if side == left])


def _runs(
    line: shapely.LineString, towards: NDArray[np.float64]
) -> list[tuple[shapely.LineString, bool]]:
    """Return the parts of a line that have a side towards a direction, and whether it is left."""
    points = shapely.get_coordinates(line)
    way = np.diff(points, axis=0)
    normal = np.column_stack([-way[:, 1], way[:, 0]]) / np.hypot(*way.T)[:, None]
    cosine = normal @ towards
    side = np.where(np.abs(cosine) < _LEAST_COSINE, 0, np.sign(cosine)).astype(int)
    found = []
    for value, group in groupby(range(len(side)), key=lambda i: int(side[i])):
        chosen = list(group)
        if value:
            found.append((shapely.LineString(points[chosen[0] : chosen[-1] + 2]), value > 0))
    return found


def _joined(shapes: Iterable[BaseGeometry]) -> BaseGeometry | None:
    whole = shapely.union_all(list(shapes))
    return None if whole.is_empty else whole
