"""Where streets meet, and in which directions they leave from there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps.street_axes import StreetAxis

__all__ = ["Arm", "Crossing", "find_crossings"]

# Points where the same two streets meet, this near to one another, are one crossing: a divided
# road is met twice, and a street may go on a few metres to the side.
_SAME_STREETS_M = 30.0
# Points where other streets meet, this near, belong to it too.
_SAME_PLACE_M = 10.0
# Two arms that turn by less are a street that changes its name, and no corner.
_BEND_RAD = math.radians(35.0)


@dataclass(frozen=True)
class Arm:
    """A direction in which a street leaves a crossing.

    Parameters
    ----------
    street
        Position of the street in `StreetNetwork.streets`.
    bearing_rad
        Direction away from the crossing, radians anticlockwise from east, in (-pi, pi].
    """

    street: int
    bearing_rad: float


@dataclass(frozen=True)
class Crossing:
    """A place where two or more streets meet.

    Parameters
    ----------
    point_m
        x and y of its middle, metres.
    streets
        Positions of the streets in `StreetNetwork.streets`, ascending.
    arms
        The directions in which they leave, anticlockwise from -pi. What is less than a few metres
        long, or beyond the border of the map, has no arm.
    bounds_blocks
        Whether two of its streets are such that blocks end at them.
    at_border
        Whether the border of the map is so near that arms may be missing.
    """

    point_m: tuple[float, float]
    streets: tuple[int, ...]
    arms: tuple[Arm, ...]
    bounds_blocks: bool = True
    at_border: bool = False

    @property
    def is_corner(self) -> bool:
        """Whether blocks have a corner here: not where a street only changes its name."""
        if not self.bounds_blocks:
            return False
        if len(self.arms) != 2:
            return len(self.arms) > 2 or self.at_border
        return abs(_turn(*(arm.bearing_rad for arm in self.arms))) < math.pi - _BEND_RAD

    def sector(self, bearing_rad: float) -> tuple[float, float]:
        """Return the sector between two arms that a bearing means, as "the SW corner" does.

        Parameters
        ----------
        bearing_rad
            The bearing as seen from the crossing, radians anticlockwise from east.

        Returns
        -------
        tuple
            Where it begins and where it ends, radians anticlockwise from east; the end is larger.

        Notes
        -----
        Of the sectors between neighbouring arms the one whose middle is nearest to the bearing is
        meant, so that streets that run askew have a south-west corner too. Of one wider than 150
        degrees, beyond the straight side of a T, only the 90 degrees about the bearing count.
        """
        bearings = sorted({arm.bearing_rad for arm in self.arms})
        if len(bearings) < 2:
            return bearing_rad - math.pi / 4, bearing_rad + math.pi / 4
        ends = [*bearings[1:], bearings[0] + 2 * math.pi]
        begin, end = min(
            zip(bearings, ends, strict=True),
            key=lambda sector: abs(_turn(bearing_rad, (sector[0] + sector[1]) / 2)),
        )
        if end - begin <= math.radians(150.0):
            return begin, end
        return bearing_rad - math.pi / 4, bearing_rad + math.pi / 4


def find_crossings(
    axes: Sequence[StreetAxis], extent_m: tuple[float, float, float, float]
) -> tuple[Crossing, ...]:
    """Return the crossings of the streets that have names or bound blocks, southernmost first.

    Parameters
    ----------
    axes
        The streets.
    extent_m
        West, south, east and north border of the map, metres.
    """
    known = [i for i, axis in enumerate(axes) if axis.named or axis.bounds_blocks]
    if not known:
        return ()
    lines = [axes[i].lines for i in known]
    places: list[tuple[NDArray[np.float64], set[int]]] = []
    one, other = shapely.STRtree(lines).query(lines, predicate="intersects")
    for i, j in sorted((int(i), int(j)) for i, j in zip(one, other, strict=True) if i < j):
        points = _points(shapely.intersection(lines[i], lines[j]))
        for group in _clusters(points, _SAME_STREETS_M):
            places.append((points[group].mean(axis=0), {known[i], known[j]}))  # noqa: PERF401
    if not places:
        return ()
    centres = np.array([point for point, _ in places])
    border = shapely.box(*extent_m).exterior
    found = []
    for group in _clusters(centres, _SAME_PLACE_M):
        streets = set().union(*(places[k][1] for k in group))
        found.append(_crossing(centres[group].mean(axis=0), sorted(streets), axes, border))
    return tuple(sorted(found, key=lambda c: (round(c.point_m[1], 6), round(c.point_m[0], 6))))


def _crossing(
    point: NDArray[np.float64],
    streets: Sequence[int],
    axes: Sequence[StreetAxis],
    border: BaseGeometry,
) -> Crossing:
    middle = shapely.Point(point)
    # Far enough that the arms of a divided road are told apart from its other carriageway.
    radius = 8.0 + max(axes[i].width_m for i in streets)
    arms = []
    for i in streets:
        for bearing in _bearings(axes[i], middle, radius):
            arms.append(Arm(i, bearing))  # noqa: PERF401
    return Crossing(
        point_m=(float(point[0]), float(point[1])),
        streets=tuple(streets),
        arms=tuple(sorted(arms, key=lambda arm: (arm.bearing_rad, arm.street))),
        bounds_blocks=sum(axes[i].bounds_blocks for i in streets) > 1,
        at_border=bool(shapely.distance(middle, border) < radius),
    )


def _bearings(axis: StreetAxis, middle: shapely.Point, radius: float) -> list[float]:
    """Return the bearings at which a street crosses a circle about a crossing."""
    ring = middle.buffer(radius, quad_segs=32).exterior
    # The carriageway of a divided road is one, with what lies between.
    arcs = shapely.get_parts(shapely.intersection(ring, axis.carriageway))
    arcs = shapely.multilinestrings([arc for arc in arcs if arc.geom_type == "LineString"])
    parts = [part for part in shapely.get_parts(shapely.line_merge(arcs)) if part.length > 0]
    points = shapely.get_coordinates(shapely.line_interpolate_point(parts, 0.5, normalized=True))
    return [math.atan2(y - middle.y, x - middle.x) for x, y in points]


def _turn(start: float, end: float) -> float:
    """Return the angle from one bearing to another, in (-pi, pi]."""
    return math.pi - (math.pi - (end - start)) % (2 * math.pi)


def _points(geometry: BaseGeometry) -> NDArray[np.float64]:
    """Return the points of an intersection of lines; what they have in common counts as its middle.

    Shape (n, 2).
    """
    parts = shapely.get_parts(geometry)
    is_line = shapely.get_dimensions(parts) == 1
    common = shapely.get_parts(shapely.line_merge(shapely.multilinestrings(parts[is_line])))
    middles = shapely.line_interpolate_point(common, 0.5, normalized=True)
    points: NDArray[np.float64] = shapely.get_coordinates([*parts[~is_line], *middles])
    return points


def _clusters(points: NDArray[np.float64], reach_m: float) -> list[list[int]]:
    """Return the groups of points that hang together by steps of at most `reach_m`."""
    if len(points) < 2:
        return [[0]] if len(points) else []
    places = shapely.points(points)
    pairs = shapely.STRtree(places).query(places, predicate="dwithin", distance=reach_m)
    label = list(range(len(points)))

    def root(i: int) -> int:
        while label[i] != i:
            i = label[i]
        return i

    for i, j in pairs.T.tolist():
        low, high = sorted((root(i), root(j)))
        label[high] = low
    groups: dict[int, list[int]] = {}
    for i in range(len(points)):
        groups.setdefault(root(i), []).append(i)
    return list(groups.values())
