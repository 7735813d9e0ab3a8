"""Tell which way a building faces: by its address, its main entrance, or the nearest street."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Protocol, TypeVar

import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps._symbols import folded
from sloop_ppl.maps.grid import Grid
from sloop_ppl.maps.landmark import PATH_KINDS, Landmark

__all__ = ["Facing", "Frontage", "frontage", "street_key", "streets_of"]

T = TypeVar("T")

# As far as a street may run from a wall and still be the street of the building: a front yard or a
# forecourt, less than a block.
_ALONG_M = 40.0
# Mapped walls and doors miss one another by up to this.
_ON_WALL_M = 0.5
# The abbreviations of the US Postal Service, without which "Main Street" is not "Main St".
_SHORTENED = {
    "street": "st", "avenue": "ave", "av": "ave", "boulevard": "blvd", "road": "rd",
    "drive": "dr", "place": "pl", "court": "ct", "lane": "ln", "square": "sq", "terrace": "ter",
    "parkway": "pkwy", "highway": "hwy", "north": "n", "south": "s", "east": "e", "west": "w",
    "northeast": "ne", "northwest": "nw", "southeast": "se", "southwest": "sw", "saint": "st",
}  # fmt: skip


class _City(Protocol):
    """What is asked of a `CityMap`, which imports this module."""

    @property
    def grid(self) -> Grid: ...
    @property
    def landmarks(self) -> tuple[Landmark, ...]: ...
    def landmark(self, landmark_id: str, /) -> Landmark: ...
    def of_kind(self, *kinds: str) -> tuple[Landmark, ...]: ...
    def footprint(self, landmark_id: str, /) -> BaseGeometry: ...
    def centroid(self, landmark_id: str, /) -> tuple[float, float]: ...
    def reaching_into(self, area: BaseGeometry, /) -> list[int]: ...
    def nearest(
        self, x_m: float, y_m: float, among: Iterable[Landmark], /
    ) -> tuple[Landmark, float] | None: ...
    def nearest_line(self, to: BaseGeometry, among: tuple[Landmark, ...], /) -> Landmark | None: ...
    def derived(self, what: str, make: Callable[[], T], /) -> T: ...


@dataclass(frozen=True)
class Facing:
    """One piece of evidence of which way a building faces.

    Parameters
    ----------
    source
        ``"address"``, ``"entrance"`` or ``"nearest"``.
    bearing_rad
        The direction, anticlockwise from east, in (-pi, pi]. By address and nearest street it leads
        from the building's centroid to the street's nearest point; by entrance it is the outward
        normal of the wall with the door.
    point_m
        x and y of that point on the street, or of the door, metres.
    street
        The street it faces; None by entrance when no street is near.
    """

    source: str
    bearing_rad: float
    point_m: tuple[float, float]
    street: Landmark | None


@dataclass(frozen=True)
class Frontage:
    """All that tells which way a building faces; each may be absent.

    Parameters
    ----------
    building
        The building.
    by_address
        Towards the street of its address.
    by_entrance
        Out of its main entrance.
    by_nearest
        Towards the nearest named street or path; any path where the map names none.
    """

    building: Landmark
    by_address: Facing | None
    by_entrance: Facing | None
    by_nearest: Facing | None

    @property
    def best(self) -> Facing | None:
        """The address if there is one, else the main entrance, else the nearest street."""
        return self.by_address or self.by_entrance or self.by_nearest

    @property
    def street(self) -> Landmark | None:
        """The street it fronts, by the best evidence."""
        return self.best.street if self.best else None

    @property
    def bearing_rad(self) -> float | None:
        """The direction it faces by the best evidence, anticlockwise from east, in (-pi, pi]."""
        return self.best.bearing_rad if self.best else None


def frontage(city: _City, building_id: str) -> Frontage:
    """Return which way a building faces.

    Parameters
    ----------
    building_id
        Id of a building, or of anything else that stands somewhere.

    Notes
    -----
    A name in ``addr:street`` means the street of that name or alias, whatever its abbreviations
    ("St" is "Street"). Of several main entrances the first one counts. The rule of the paper,
    which takes the nearest path whether it has a name or not, is
    :meth:`CityMap.bearing_to_nearest_path`.
    """
    building = city.landmark(building_id)
    return Frontage(
        building=building,
        by_address=_by_address(city, building),
        by_entrance=_by_entrance(city, building),
        by_nearest=_towards(
            city, building, city.derived("named paths", lambda: _named(city)), "nearest"
        ),
    )


def streets_of(city: _City, building_id: str, within_m: float = _ALONG_M) -> tuple[Landmark, ...]:
    """Return the named streets along a building, nearest first.

    Parameters
    ----------
    within_m
        How far a street may be from the building's wall, metres.

    Returns
    -------
    tuple of Landmark
        Named streets, service roads and pedestrian ways within reach that no other building
        stands in front of.
    """
    building = city.landmark(building_id)
    walls = city.footprint(building_id)
    reach = walls.buffer(within_m)
    found = []
    for i in city.reaching_into(reach):
        street = city.landmarks[i]
        if street.kind not in PATH_KINDS or street.name is None or street.id == building_id:
            continue
        # The shortest line of sight decides: who stands behind another building is not on the
        # street.
        sight = shapely.shortest_line(walls, street.geometry)
        if sight.length <= within_m and not _blocked(city, sight, building):
            found.append((sight.length, i, street))
    return tuple(street for _, _, street in sorted(found, key=lambda t: t[:2]))


def _blocked(city: _City, sight: shapely.LineString, building: Landmark) -> bool:
    for i in city.reaching_into(sight):
        other = city.landmarks[i]
        if other.kind != "building" or other.id in (building.id, building.within):
            continue
        if shapely.intersection(sight, other.geometry).length > _ON_WALL_M:
            return True
    return False


def _named(city: _City) -> tuple[Landmark, ...]:
    paths = city.of_kind(*PATH_KINDS)
    return tuple(m for m in paths if m.name) or paths


def _by_address(city: _City, building: Landmark) -> Facing | None:
    name = building.properties.get("addr:street")
    if not isinstance(name, str):
        return None
    streets = city.derived("streets by name", lambda: _streets_by_key(city))
    return _towards(city, building, streets.get(street_key(name), ()), "address")


def _streets_by_key(city: _City) -> dict[str, tuple[Landmark, ...]]:
    """Return the streets and squares of each name and alias; a name comes before an alias."""
    by_name: dict[str, tuple[Landmark, ...]] = {}
    by_alias: dict[str, tuple[Landmark, ...]] = {}
    for street in city.of_kind(*PATH_KINDS, "square"):
        if street.name:
            key = street_key(street.name)
            by_name[key] = (*by_name.get(key, ()), street)
        for key in {street_key(alias) for alias in street.aliases}:
            by_alias[key] = (*by_alias.get(key, ()), street)
    return by_alias | by_name


def _by_entrance(city: _City, building: Landmark) -> Facing | None:
    doors = building.properties.get("entrances")
    for door in doors if isinstance(doors, list | tuple) else ():
        if not isinstance(door, Mapping) or door.get("entrance") != "main":
            continue
        place = _local(city, door.get("lonlat"))
        bearing = None if place is None else _outward(building, shapely.Point(place))
        if place is None or bearing is None:
            continue
        streets = city.of_kind(*PATH_KINDS)
        near = city.nearest(*place, streets)
        street = near[0] if near and near[1] <= _ALONG_M else None
        return Facing("entrance", bearing, place, street)
    return None


def _local(city: _City, lonlat: Any) -> tuple[float, float] | None:
    if not isinstance(lonlat, list | tuple) or len(lonlat) != 2 or city.grid.centre is None:
        return None
    if not all(isinstance(v, int | float) and math.isfinite(v) for v in lonlat):
        return None
    x, y = city.grid.from_lonlat(*lonlat)
    return float(x), float(y)


def _towards(
    city: _City, building: Landmark, among: tuple[Landmark, ...], source: str
) -> Facing | None:
    is_path = building.kind in PATH_KINDS or building.kind == "square"
    others = tuple(m for m in among if m.id != building.id) if is_path else among
    centre = shapely.Point(city.centroid(building.id))
    street = city.nearest_line(centre, others)
    if street is None:
        return None
    foot = shapely.get_coordinates(shapely.shortest_line(centre, street.geometry))[1]
    east, north = foot[0] - centre.x, foot[1] - centre.y
    if math.hypot(east, north) < 1e-6:
        return None
    return Facing(source, math.atan2(north, east), (float(foot[0]), float(foot[1])), street)


def _outward(building: Landmark, door: shapely.Point) -> float | None:
    """Return the outward normal of the wall with the door; at a corner, between both walls'."""
    rings = shapely.get_parts(shapely.boundary(building.geometry))
    east = north = 0.0
    for ring in rings:
        corners = shapely.get_coordinates(ring)
        for start, end in pairwise(corners):
            wall = shapely.LineString([start, end])
            if wall.length < 1e-6 or wall.distance(door) > _ON_WALL_M:
                continue
            along = (end - start) / wall.length
            middle = wall.interpolate(wall.project(door))
            for side in (1.0, -1.0):
                # (dy, -dx) is the normal on the right of the wall; rings run either way, so both
                # are tried.
                normal = side * along[1], -side * along[0]
                # 5 cm off the wall: outside is where the building is not.
                step = shapely.Point(middle.x + 0.05 * normal[0], middle.y + 0.05 * normal[1])
                if not building.geometry.contains(step):
                    east, north = east + normal[0], north + normal[1]
                    break
    return None if math.hypot(east, north) < 1e-6 else math.atan2(north, east)


def street_key(name: str) -> str:
    """Return what all spellings of a street's name have in common: "Main Street" is "main st"."""
    return " ".join(_SHORTENED.get(word, word) for word in folded(name).split())
