"""List the streets a building may face, each with its direction and what speaks for it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from sloop_ppl.maps import CityMap
from sloop_ppl.maps.landmark import PATH_KINDS

__all__ = ["FEATURES", "Choices", "facing_choices"]

FEATURES = (
    "nearest", "nearest named", "wall distance", "distance over nearest", "log distance",
    "street", "service", "pedestrian", "named", "width", "log length",
    "seen", "square to walls", "towards narrow side", "share of neighbours", "second",
)  # fmt: skip
"""What is told of each choice, in order; all about 0 to 1."""

_REACH_M = 80.0
_MOST = 8
_NEIGHBOURS_M = 50.0


@dataclass(frozen=True, eq=False)
class Choices:
    """The streets a landmark may face.

    Parameters
    ----------
    bearing_rad : direction from the landmark's centroid to each street's nearest point, radians
        anticlockwise from east, shape (C,).
    features : what is told of each, in the order of `FEATURES`, shape (C, F).
    distance_m : metres from the centroid to each, shape (C,).
    """

    bearing_rad: NDArray[np.float64]
    features: NDArray[np.float32]
    distance_m: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Ways:
    """All ways of a map: their geometry, its index, and which street each is a piece of."""

    geometry: NDArray[np.object_]
    tree: shapely.STRtree
    ids: tuple[str, ...]
    street: NDArray[np.int_]
    told: NDArray[np.float32]
    named: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Houses:
    """All buildings of a map: an index, and the named street nearest to each."""

    tree: shapely.STRtree
    centres: shapely.STRtree
    ids: tuple[str, ...]
    street: NDArray[np.int_]


def facing_choices(city: CityMap, landmark_id: str) -> Choices:
    """Return the streets that a landmark may face, at most eight, nearest first.

    Parameters
    ----------
    city : the map.
    landmark_id : id of what faces one of them.

    Returns
    -------
    Choices
        Pieces of one name are one street. The nearest way is always there, others within 80 m
        of the wall; none on a map without ways.
    """
    ways = city.derived("frame ways", lambda: _ways(city))
    own = city.footprint(landmark_id)
    centre = own.centroid
    near = _near(ways, own, centre, landmark_id)
    foot = shapely.get_coordinates(shapely.shortest_line(centre, ways.geometry[near]))[1::2]
    offset = foot - (centre.x, centre.y)
    distance = np.hypot(offset[:, 0], offset[:, 1])
    keep = _one_per_street(ways.street[near], distance)
    if not len(keep):
        return Choices(np.zeros(0), np.zeros((0, len(FEATURES)), np.float32), np.zeros(0))
    near, foot, offset, distance = near[keep], foot[keep], offset[keep], distance[keep]
    bearing = np.arctan2(offset[:, 1], offset[:, 0])
    wall = shapely.distance(own, ways.geometry[near])
    named = ways.named[near]
    nearest_named = np.zeros(len(near), dtype=bool)
    if named.any():
        nearest_named[np.flatnonzero(named)[0]] = True
    houses = city.derived("frame houses", lambda: _houses(city, ways))
    features = np.column_stack([
        np.arange(len(near)) == 0,
        nearest_named,
        np.minimum(wall / 40, 3),
        np.minimum(distance / max(distance[0], 1.0) - 1, 4) / 2,
        np.log(np.maximum(distance, 1)) / 4,
        ways.told[near],
        _seen(houses, centre, foot, landmark_id, city.landmark(landmark_id).within),
        *_walls(own, bearing),
        _share(houses, centre, ways.street[near], landmark_id),
        np.arange(len(near)) == 1,
    ])  # fmt: skip
    return Choices(bearing, features.astype(np.float32), distance)


def _ways(city: CityMap) -> _Ways:
    ways = city.of_kind(*PATH_KINDS)
    geometry = np.array([way.geometry for way in ways], dtype=object)
    numbers: dict[str, int] = {}
    street = [numbers.setdefault(way.name or f"\n{way.id}", len(numbers)) for way in ways]
    length = np.bincount(street, shapely.length(geometry), len(numbers)) if ways else np.zeros(0)
    told = [
        (
            way.kind == "street",
            way.kind == "service",
            way.kind == "pedestrian",
            way.name is not None,
            min((way.width_m or 4.0) / 20, 2.0),
            min(math.log1p(length[number]) / 8, 1.5),
        )
        for way, number in zip(ways, street, strict=True)
    ]
    return _Ways(
        geometry,
        shapely.STRtree(geometry),
        tuple(way.id for way in ways),
        np.array(street, dtype=int),
        np.array(told, dtype=np.float32).reshape(len(ways), 6),
        np.array([way.name is not None for way in ways], dtype=bool),
    )


def _houses(city: CityMap, ways: _Ways) -> _Houses:
    houses = city.of_kind("building")
    geometry = np.array([house.geometry for house in houses], dtype=object)
    centres = shapely.centroid(geometry)
    street = np.full(len(houses), -1)
    named = np.flatnonzero(ways.named)
    if len(named) and len(houses):
        tree = shapely.STRtree(ways.geometry[named])
        which, found = tree.query_nearest(centres, all_matches=False)
        street[which] = ways.street[named[found]]
    return _Houses(
        shapely.STRtree(geometry),
        shapely.STRtree(centres),
        tuple(house.id for house in houses),
        street,
    )


def _near(
    ways: _Ways, own: shapely.Geometry, centre: shapely.Point, landmark_id: str
) -> NDArray[np.int_]:
    """Return the ways within reach, and the nearest one whatever its distance."""
    if not len(ways.ids):
        return np.zeros(0, dtype=int)
    within = ways.tree.query(own, predicate="dwithin", distance=_REACH_M)
    found = np.union1d(within, ways.tree.query_nearest(centre))
    return np.array([i for i in found if ways.ids[i] != landmark_id], dtype=int)


def _one_per_street(street: NDArray[np.int_], distance: NDArray[np.float64]) -> NDArray[np.int_]:
    """Return the nearest piece of each street that does not run through the centroid."""
    order = np.argsort(distance, kind="stable")
    order = order[distance[order] > 1e-6]
    _, first = np.unique(street[order], return_index=True)
    return order[np.sort(first)][:_MOST]


def _seen(
    houses: _Houses,
    centre: shapely.Point,
    foot: NDArray[np.float64],
    landmark_id: str,
    within: str | None,
) -> NDArray[np.float64]:
    """Return 1 where no other building stands between the landmark and a street, shape (C,)."""
    starts = np.broadcast_to((centre.x, centre.y), foot.shape)
    sights = shapely.linestrings(np.stack([starts, foot], 1))
    seen = np.ones(len(foot))
    which, house = houses.tree.query(sights, predicate="crosses")
    for i, j in zip(which, house, strict=True):
        if houses.ids[j] not in (landmark_id, within):
            seen[i] = 0.0
    return seen


def _walls(
    own: shapely.Geometry, bearing: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return how square each direction is to the walls, and how narrow the side it looks from."""
    corners = shapely.get_coordinates(own)
    walls = np.diff(corners, axis=0)
    long = np.hypot(walls[:, 0], walls[:, 1])
    if len(corners) < 3 or not long.sum():
        return np.zeros(len(bearing)), np.zeros(len(bearing))
    turn = np.exp(4j * np.arctan2(walls[:, 1], walls[:, 0]))
    axis = np.angle((long * turn).sum()) / 4
    square = np.cos(4 * (bearing - axis))
    along = corners @ np.stack([np.cos(bearing), np.sin(bearing)])
    across = corners @ np.stack([-np.sin(bearing), np.cos(bearing)])
    return square, np.log(np.maximum(np.ptp(along, 0), 1) / np.maximum(np.ptp(across, 0), 1))


def _share(
    houses: _Houses, centre: shapely.Point, street: NDArray[np.int_], landmark_id: str
) -> NDArray[np.float64]:
    """Return the share of the buildings nearby that are nearest to each street, shape (C,)."""
    near = houses.centres.query(centre, predicate="dwithin", distance=_NEIGHBOURS_M)
    theirs = [houses.street[i] for i in near if houses.ids[i] != landmark_id]
    if not theirs:
        return np.full(len(street), 0.5)
    found: NDArray[np.float64] = (np.array(theirs)[None, :] == street[:, None]).mean(1)
    return found
