"""Regions that streets and blocks give a relation to measure from."""

from __future__ import annotations

from itertools import permutations

import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps import CityMap, across_street, blocks_of, street_network
from sloop_ppl.maps._along import nearest_on_lines
from sloop_ppl.maps.street_places import SIDE_M, street_band

__all__ = [
    "block_region",
    "crossing_region",
    "same_block_region",
    "street_side_region",
    "stretch_region",
]


def street_side_region(city: CityMap, grounds: tuple[str, ...]) -> BaseGeometry | None:
    """Return the sides of a street; with a second ground the side on which that lies.

    Parameters
    ----------
    city
        The map.
    grounds
        Id of the street, and of what tells the side if one is meant.

    Returns
    -------
    shapely geometry or None
        From the kerb 15 m deep, along the whole street; None for what is no street.

    Notes
    -----
    A side by its compass word is :func:`sloop_ppl.maps.street_side`.
    """
    network = street_network(city)
    axis = network.street(grounds[0])
    if axis is None:
        return None
    if len(grounds) == 1:
        return across_street(city, grounds[0])
    other = shapely.get_coordinates(city.footprint(grounds[1]).centroid)
    if not axis.spines:
        return None
    nearest = nearest_on_lines(axis.spines, other)
    spine, left = axis.spines[int(nearest.line[0])], bool(nearest.on_left[0])
    return _or_none(street_band(network, axis, spine, left, SIDE_M))


def crossing_region(city: CityMap, grounds: tuple[str, ...]) -> BaseGeometry | None:
    """Return the crossings at which streets meet, as discs that cover their carriageways.

    Parameters
    ----------
    city
        The map.
    grounds
        Ids of the streets; all crossings of the street when there is one.

    Returns
    -------
    shapely geometry or None
        Also the crossing where several crossings are meant: it then has several parts. None when
        the streets do not meet.
    """
    network = street_network(city)
    discs = [
        shapely.Point(c.point_m).buffer(max(network.streets[i].width_m for i in c.streets))
        for c in network.crossings_of(*grounds)
    ]
    return _or_none(shapely.union_all(discs))


def block_region(city: CityMap, grounds: tuple[str, ...]) -> BaseGeometry | None:
    """Return the blocks that all of some streets bound, or the block that something lies in.

    Parameters
    ----------
    city
        The map.
    grounds
        Ids of streets, of other landmarks, or of both: the blocks that all of them have in common.

    Returns
    -------
    shapely geometry or None
        Up to the axes of the streets around; None when they have no block in common.
    """
    network = street_network(city)
    common = set(range(len(network.blocks)))
    for ground in grounds:
        at = network.position(ground)
        if at is not None and network.streets[at].bounds_blocks:
            common &= {block.number for block in network.blocks if at in block.streets}
        else:
            common &= {block.number for block in blocks_of(city, ground)}
    return _or_none(shapely.union_all([network.blocks[i].polygon for i in sorted(common)]))


def stretch_region(city: CityMap, grounds: tuple[str, ...]) -> BaseGeometry | None:
    """Return the stretch of a street between two others, its sides included.

    Parameters
    ----------
    city
        The map.
    grounds
        Ids of the street and of the two that it crosses, as in "on C between A and B", or in any
        order when only one of them crosses both others; the whole street when it is alone.

    Returns
    -------
    shapely geometry or None
        The carriageway and 15 m on either side; None when the streets do not cross.
    """
    network = street_network(city)
    if len(grounds) == 1:
        axis = network.street(grounds[0])
        return None if axis is None else axis.lines.buffer(axis.width_m / 2 + SIDE_M)
    if len(grounds) != 3:
        return None
    for street, one, other in permutations(grounds):
        axis, part = network.street(street), network.between(street, one, other)
        if axis is not None and part is not None:
            return part.buffer(axis.width_m / 2 + SIDE_M, cap_style="flat")
    return None


def same_block_region(city: CityMap, grounds: tuple[str, ...]) -> BaseGeometry | None:
    """Return what else lies on the block of a landmark.

    Parameters
    ----------
    city
        The map.
    grounds
        Id of the landmark; of several the blocks they have in common.

    Returns
    -------
    shapely geometry or None
        The block less what the landmarks themselves cover; None where they have no block in common.
    """
    block = block_region(city, grounds)
    if block is None:
        return None
    covered = shapely.union_all([city.footprint(ground) for ground in grounds])
    return _or_none(shapely.difference(block, covered)) or block


def _or_none(shape: BaseGeometry) -> BaseGeometry | None:
    return None if shape.is_empty else shape
