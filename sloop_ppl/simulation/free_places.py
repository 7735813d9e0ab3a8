"""Where in a city things can stand: in the open, with room, along the streets."""

from __future__ import annotations

import math

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.errors import InputError, OutsideMap
from sloop_ppl.maps import CityMap

__all__ = ["FreeGround", "Place", "checked_place", "nearest_free"]

Place = tuple[float, float]
"""x and y, metres."""

_RIM_M = 0.01
"""How far inside the map's border a place stays."""


def checked_place(city: CityMap, name: str, place: Place) -> Place:
    """Return where a target stands, or say why it cannot stand there."""
    try:
        x, y = (float(v) for v in place)
    except (TypeError, ValueError):
        x = y = math.nan
    if not (math.isfinite(x) and math.isfinite(y)):
        raise InputError(f"The place of '{name}' is {place!r}; expected x and y in metres")
    try:
        city.grid.cell_at(x, y)
    except OutsideMap as error:
        raise OutsideMap(f"Target '{name}': {error}") from None
    point = shapely.Point(x, y)
    for building in city.of_kind("building"):
        if building.geometry.contains(point):
            free_x, free_y = nearest_free(city, (x, y))
            raise InputError(
                f"Target '{name}' at ({x:g}, {y:g}) is inside {building.label}, where no camera "
                f"sees it; expected a place in the open, the nearest is ({free_x:.1f}, "
                f"{free_y:.1f})"
            )
    return x, y


def nearest_free(city: CityMap, place: Place, clearance_m: float = 1.0) -> Place:
    """Return the place nearest to one that is in no building nor nearer to one than `clearance_m`.

    Parameters
    ----------
    place
        x and y, metres.
    """
    built = _built(city).buffer(clearance_m)
    point = shapely.Point(place)
    west, south, east, north = city.grid.extent_m
    if not built.contains(point):
        return float(place[0]), float(place[1])
    within = shapely.box(west, south, east, north).buffer(-_RIM_M, join_style="mitre")
    border = built.boundary.intersection(within)
    if border.is_empty:
        return float(place[0]), float(place[1])
    _, foot = shapely.get_coordinates(shapely.shortest_line(point, border))
    # A millimetre further, so that rounding does not put it back inside.
    away = foot - np.array(place)
    foot = foot + away / max(float(np.hypot(*away)), 1e-9) * 1e-3
    return float(foot[0]), float(foot[1])


def _built(city: CityMap) -> BaseGeometry:
    return city.derived(
        "built-up area", lambda: shapely.union_all([b.geometry for b in city.of_kind("building")])
    )


class FreeGround:
    """Where on the ground there is room, and which way streets run."""

    def __init__(self, city: CityMap) -> None:
        self._city = city
        self._built = _built(city).buffer(1.2)
        kinds = city.of_kind("street", "service")
        self._lines = [m for m in kinds if "LineString" in m.geometry.geom_type]

    def heading(self, place: Place, rng: np.random.Generator) -> float:
        """Return a heading along the street nearest to a place, either way; any without streets."""
        either, anywhere = math.pi * int(rng.integers(2)), float(rng.uniform(0, 2 * math.pi))
        if not self._lines:
            return anywhere
        point = shapely.Point(place)
        geometries = [m.geometry for m in self._lines]
        line = geometries[int(np.argmin(shapely.distance(geometries, point)))]
        at = line.project(point)
        start, end = line.interpolate([max(at - 2.0, 0.0), min(at + 2.0, line.length)])
        return math.atan2(end.y - start.y, end.x - start.x) + either

    def roadside(self, count: int, taken: list[Place], rng: np.random.Generator) -> list[Place]:
        """Return up to so many places along the streets, apart from each other and from targets."""
        spots: list[Place] = []
        if not self._lines:
            return spots
        lengths = np.array([m.geometry.length for m in self._lines])
        for _ in range(count * 20):
            if len(spots) == count:
                break
            street = self._lines[int(rng.choice(len(lengths), p=lengths / lengths.sum()))]
            at, side = float(rng.uniform(0, street.geometry.length)), float(rng.choice([-1, 1]))
            a, b = street.geometry.interpolate([at, min(at + 1.0, street.geometry.length)])
            along = math.atan2(b.y - a.y, b.x - a.x)
            x, y = a.x - side * 3.0 * math.sin(along), a.y + side * 3.0 * math.cos(along)
            near = min((math.dist((x, y), t) for t in (*taken, *spots)), default=math.inf)
            room = not self._built.contains(shapely.Point(x, y))
            if near > 8.0 and room and self._city.grid.contains(x, y):
                spots.append((x, y))
        return spots
