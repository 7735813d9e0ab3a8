"""What a relation measures from when that is not simply its one ground."""

from __future__ import annotations

from dataclasses import dataclass

from shapely.geometry.base import BaseGeometry

from sloop_ppl.language import WHOLE_MAP
from sloop_ppl.maps import CityMap
from sloop_ppl.maps.landmark import PATH_KINDS
from sloop_ppl.models.regions import (
    across_region,
    along_region,
    between_region,
    map_region,
    meeting_point,
)

__all__ = ["MAP_CLASS", "Sense", "is_map", "sense_of"]

MAP_CLASS = {"left": "west", "right": "east", "front": "north", "behind": "south"}
"""Frame words said of the map -> the class they mean: its front is north."""


@dataclass(frozen=True, eq=False)
class Sense:
    """What a relation measures from.

    Parameters
    ----------
    shape : distance is that to the cells it touches, direction that from its centroid, metres.
    grounds : when given, distance is that to the farthest of these grounds instead: a place is as
        near to a corner as it is to the street that is farther away.
    """

    shape: BaseGeometry
    grounds: tuple[str, ...] = ()


def is_map(city: CityMap, ground: str) -> bool:
    """Tell whether a ground is the map itself."""
    return ground == WHOLE_MAP and ground not in city


def sense_of(
    relation: str, relation_class: str, grounds: tuple[str, ...], city: CityMap, joint: bool
) -> Sense | None:
    """Return what a relation measures from; None when it is simply its one ground.

    Parameters
    ----------
    relation, relation_class : the canonical word and its class.
    grounds : ids, distinct.
    city : the map.
    joint : True to give between, across, along and several grounds their own meaning; the map as
        a ground always has its own.

    Notes
    -----
    Source: ours. The paper and its code read a relation to several grounds as one to each, and
    across and along as near.
    """
    if is_map(city, grounds[0]):
        return Sense(map_region(city.grid, relation, relation_class))
    if not joint:
        return None
    key = f"sense of {relation} {relation_class} {' '.join(grounds)}"
    return city.derived(key, lambda: _joint_sense(relation, relation_class, grounds, city))


def _joint_sense(
    relation: str, relation_class: str, grounds: tuple[str, ...], city: CityMap
) -> Sense | None:
    if relation_class == "across":
        return _across(grounds, city)
    if len(grounds) == 1:
        return _along(grounds[0], city) if relation == "along" else None
    shapes = [city.footprint(ground) for ground in grounds]
    if relation_class == "between":
        return Sense(between_region(shapes))
    lines = [city.landmark(ground).geometry for ground in grounds]
    crossing = all("LineString" in line.geom_type for line in lines)
    return Sense(meeting_point(lines if crossing else shapes), grounds)


def _along(ground: str, city: CityMap) -> Sense:
    landmark = city.landmark(ground)
    is_line = "LineString" in landmark.geometry.geom_type
    shape = landmark.geometry if is_line else city.footprint(ground)
    return Sense(along_region(shape, landmark.width_m, is_line))


def _across(grounds: tuple[str, ...], city: CityMap) -> Sense | None:
    streets = [g for g in grounds if city.landmark(g).kind in PATH_KINDS]
    others = [g for g in grounds if g not in streets]
    street = streets[0] if streets and others else None
    region = across_region(city, (others or streets)[0], street)
    return None if region is None else Sense(region)
