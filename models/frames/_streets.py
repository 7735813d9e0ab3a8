"""List the streets a building may face, each with its direction and what speaks for it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from sloop_ppl.maps import CityMap
from sloop_ppl.maps.landmark import PATH_KINDS
from sloop_ppl.models.frames._strokes import spans

__all__ = ["FEATURES", "Choices", "choices_of", "facing_choices"]

FEATURES = (
    "nearest", "nearest named", "wall distance", "distance over nearest", "log distance",
    "street", "service", "pedestrian", "named", "width", "log length",
    "seen", "square to walls", "towards narrow side", "share of neighbours", "second",
)  # fmt: skip
"""What is told of each choice, in order; all about 0 to 1."""

_REACH_M = 80.0  # streets this far from a wall are choices; the address's is within 60 m of it
_MOST = 8  # choices of one building, the nearest
_NEIGHBOURS_M = 50.0  # buildings this near tell which street a row of houses faces


@dataclass(frozen=True, eq=False)
class Choices:
    """The streets a landmark may face.

    Parameters
    ----------
    bearing_rad
        Direction from the landmark's centroid to each street's nearest point, radians anticlockwise
        from east, shape (C,).
    features
        What is told of each, in the order of `FEATURES`, shape (C, F).
    distance_m
        Metres from the centroid to each, shape (C,).
    """

    bearing_rad: NDArray[np.float64]
    features: NDArray[np.float32]
    distance_m: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Ways:
    """All ways of a map: their geometry, its index, and which street each is a piece of."""

    geometry: NDArray[np.object_]
    tree: shapely.STRtree
    number: dict[str, int]
    street: NDArray[np.int_]
    rows: NDArray[np.float32]
    named: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Houses:
    """All buildings of a map: an index, and the named street nearest to each."""

    tree: shapely.STRtree
    centres: shapely.STRtree
    number: dict[str | None, int]
    street: NDArray[np.int_]


def facing_choices(city: CityMap, landmark_id: str) -> Choices:
    """Return the streets that a landmark may face, at most eight, nearest first.

    Parameters
    ----------
    landmark_id
        Id of what faces one of them.

    Returns
    -------
    Choices
        Pieces of one name are one street. The nearest way is always there, others within 80 m
        of the wall; none on a map without ways.
    """
    return choices_of(city, [landmark_id])[0]


def choices_of(city: CityMap, landmark_ids: Sequence[str]) -> list[Choices]:
    """Return what :func:`facing_choices` does of each of some landmarks, in their order.

    Parameters
    ----------
    city
        The map.
    landmark_ids
        Ids; one may come several times.

    Raises
    ------
    UnknownName
        For a landmark that is not on the map.
    """
    ways = city.derived("frame ways", lambda: _ways(city))
    houses = city.derived("frame houses", lambda: _houses(city, ways))
    own = np.array([city.footprint(i) for i in landmark_ids], dtype=object)
    centre = shapely.centroid(own)
    who, way = _near(ways, own, centre, landmark_ids)
    sight = shapely.shortest_line(centre[who], ways.geometry[way])
    ends = shapely.get_coordinates(sight).view(np.complex128).reshape(-1, 2)
    offset = ends[:, 1] - ends[:, 0]
    distance = np.hypot(offset.real, offset.imag)
    keep = _one_per_street(who, who * len(ways.street) + ways.street[way], distance)
    who, way, sight, distance = who[keep], way[keep], sight[keep], distance[keep]
    bearing = np.angle(offset[keep])
    first = np.searchsorted(who, who)
    rank = np.arange(len(who)) - first
    named = np.flatnonzero(ways.named[way])
    nearest_named = np.zeros(len(who), dtype=bool)
    nearest_named[named[np.unique(who[named], return_index=True)[1]]] = True
    features = np.column_stack([
        rank == 0,
        nearest_named,
        np.minimum(shapely.distance(own[who], ways.geometry[way]) / 40, 3),
        np.minimum(distance / np.maximum(distance[first], 1.0) - 1, 4) / 2,
        np.log(np.maximum(distance, 1)) / 4,
        ways.rows[way],
        _seen(city, houses, landmark_ids, who, sight),
        *_Walls.of(own).seen_from(who, bearing),
        _share(houses, landmark_ids, centre, who, ways.street[way]),
        rank == 1,
    ]).astype(np.float32)  # fmt: skip
    start = np.searchsorted(who, np.arange(len(own) + 1)).tolist()
    return [Choices(bearing[i:j], features[i:j], distance[i:j]) for i, j in pairwise(start)]


def _ways(city: CityMap) -> _Ways:
    ways = city.of_kind(*PATH_KINDS)
    geometry = np.array([way.geometry for way in ways], dtype=object)
    numbers: dict[str, int] = {}
    street = [numbers.setdefault(way.name or f"\n{way.id}", len(numbers)) for way in ways]
    length = np.bincount(street, shapely.length(geometry), len(numbers)) if ways else np.zeros(0)
    rows = [
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
        {way.id: i for i, way in enumerate(ways)},
        np.array(street, dtype=int),
        np.array(rows, dtype=np.float32).reshape(len(ways), 6),
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
        {house.id: i for i, house in enumerate(houses)},
        street,
    )


def _near(
    ways: _Ways,
    own: NDArray[np.object_],
    centre: NDArray[np.object_],
    landmark_ids: Sequence[str],
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return pairs of a landmark and a way within its reach, or the nearest whatever its distance.

    They are sorted; no landmark is paired with itself.
    """
    within = ways.tree.query(own, predicate="dwithin", distance=_REACH_M)
    found = np.concatenate([within, ways.tree.query_nearest(centre)], 1)
    who, way = np.divmod(np.unique(found[0] * len(ways.street) + found[1]), len(ways.street))
    other = way != np.array([ways.number.get(i, -1) for i in landmark_ids])[who]
    return who[other], way[other]


def _one_per_street(
    who: NDArray[np.intp], whose: NDArray[np.intp], distance: NDArray[np.float64]
) -> NDArray[np.intp]:
    """Return the pairs to keep, by landmark and then nearest first.

    Of those with the same number, a landmark's street, it is the nearest piece that does not run
    through the centroid.
    """
    order = np.lexsort((distance, who))
    order = order[distance[order] > 1e-6]
    _, first = np.unique(whose[order], return_index=True)
    order = order[np.sort(first)]
    rank = np.arange(len(order)) - np.searchsorted(who[order], who[order])
    return order[rank < _MOST]


def _seen(
    city: CityMap,
    houses: _Houses,
    landmark_ids: Sequence[str],
    who: NDArray[np.intp],
    sight: NDArray[np.object_],
) -> NDArray[np.float64]:
    """Return 1 where no other building stands between the landmark and a street, shape (C,)."""
    own = np.array([houses.number.get(i, -1) for i in landmark_ids])
    holder = np.array([houses.number.get(city.landmark(i).within, -1) for i in landmark_ids])
    which, house = houses.tree.query(sight, predicate="intersects")
    other = (house != own[who[which]]) & (house != holder[who[which]])
    which, house = which[other], house[other]
    seen = np.ones(len(who))
    while len(which):  # one house a sight at a time: the first mostly hides the street
        at, first = np.unique(which, return_index=True)
        seen[at[shapely.crosses(sight[at], houses.tree.geometries[house[first]])]] = 0.0
        left = seen[which] > 0
        left[first] = False
        which, house = which[left], house[left]
    return seen


def _share(
    houses: _Houses,
    landmark_ids: Sequence[str],
    centre: NDArray[np.object_],
    who: NDArray[np.intp],
    street: NDArray[np.int_],
) -> NDArray[np.float64]:
    """Return the share of the buildings nearby that are nearest to each street, shape (C,)."""
    near, house = houses.centres.query(centre, predicate="dwithin", distance=_NEIGHBOURS_M)
    other = house != np.array([houses.number.get(i, -1) for i in landmark_ids])[near]
    near, theirs = near[other], houses.street[house[other]]
    streets = max(street.max(initial=0), houses.street.max(initial=0)) + 2
    given = np.sort(near * streets + theirs + 1)  # a house without a street has -1
    asked = who * streets + street + 1
    count = np.searchsorted(given, asked, "right") - np.searchsorted(given, asked)
    total = np.bincount(near, minlength=len(centre))[who]
    return np.where(total > 0, count / np.maximum(total, 1), 0.5)


@dataclass(frozen=True, eq=False)
class _Walls:
    """The corners of N footprints, and the axis that the walls of each follow.

    Parameters
    ----------
    corners
        x + iy of all corners in turn, metres, shape (P,).
    corner
        First corner of each footprint, and their number, shape (N + 1,).
    axis_rad
        The direction that most of its walls have, or are square to, shape (N,). The step from one
        ring or part to the next counts as a wall, as the shipped networks learnt it.
    walled
        False for what has no walls, such as a point, shape (N,).
    """

    corners: NDArray[np.complex128]
    corner: NDArray[np.intp]
    axis_rad: NDArray[np.float64]
    walled: NDArray[np.bool_]

    @classmethod
    def of(cls, footprints: NDArray[np.object_]) -> _Walls:
        """Return the walls of some footprints."""
        xy, owner = shapely.get_coordinates(footprints, return_index=True)
        corners, count = xy.view(np.complex128)[:, 0], len(footprints)
        same = owner[1:] == owner[:-1]
        wall, walls = (corners[1:] - corners[:-1])[same], owner[1:][same]
        long = np.abs(wall)
        turn = long * np.exp(4j * np.angle(wall))
        sums = (np.bincount(walls, one, count) for one in (long, turn.real, turn.imag))
        length, east, north = sums
        corner = np.searchsorted(owner, np.arange(count + 1))
        walled = (corner[1:] - corner[:-1] >= 3) & (length > 0)
        return cls(corners, corner, np.arctan2(north, east) / 4, walled)

    def seen_from(
        self, which: NDArray[np.intp], bearing_rad: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return how square a direction is to the walls, and how narrow the side it looks from.

        Parameters
        ----------
        which
            The footprint that each direction is of, shape (C,).
        bearing_rad
            The directions, shape (C,).

        Returns
        -------
        tuple of numpy.ndarray
            From -1 to 1, and the log of depth over width, shape (C,) each; 0 without walls.
        """
        corners, start = spans(self.corner, which)
        seen = self.corners[corners] * np.repeat(np.exp(-1j * bearing_rad), start[1:] - start[:-1])
        deep, wide = (_extent(one, start[:-1]) for one in (seen.real, seen.imag))
        square = np.cos(4 * (bearing_rad - self.axis_rad[which]))
        narrow = np.log(np.maximum(deep, 1) / np.maximum(wide, 1))
        walled = self.walled[which]
        return np.where(walled, square, 0.0), np.where(walled, narrow, 0.0)


def _extent(values: NDArray[np.float64], start: NDArray[np.intp]) -> NDArray[np.float64]:
    extent: NDArray[np.float64] = np.maximum.reduceat(values, start) - np.minimum.reduceat(
        values, start
    )
    return extent
