"""A map: its grid, its landmarks, and what can be asked of them."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from sloop_ppl.errors import InputError, MapError, UnknownName
from sloop_ppl.maps._cache import BoundedCache
from sloop_ppl.maps._proximity import NearestIndex
from sloop_ppl.maps._shapes import clip
from sloop_ppl.maps.fields import BYTES_PER_CELL, LandmarkFields, landmark_fields
from sloop_ppl.maps.frontage import Frontage, frontage, streets_of
from sloop_ppl.maps.grid import Grid
from sloop_ppl.maps.landmark import KINDS, PATH_KINDS, Landmark
from sloop_ppl.maps.rasterise import touched_cells

__all__ = ["FIELDS", "CityMap"]

T = TypeVar("T")

FIELDS = BoundedCache(budget_bytes=1 << 29)
"""Cells and fields of the landmarks in use, shared by maps of the same content: 512 MiB."""


@dataclass(frozen=True, eq=False)
class CityMap:
    """A city patch: landmarks on a grid. Immutable; what is derived from it is cached.

    Cells and fields are computed for a landmark when they are first asked for and kept by
    content in `FIELDS`, which forgets those used longest ago.

    Parameters
    ----------
    name
        What the map is called.
    grid
        Its cells and frame.
    landmarks
        Its landmarks, ids unique.
    attribution
        Whom the data belong to.
    properties
        Other top-level members of the map file.

    Raises
    ------
    MapError
        When two landmarks share an id, or a poi stands within an unknown landmark.

    Examples
    --------
    >>> from sloop_ppl.maps import load_map
    >>> city = load_map("cleveland")
    >>> city
    CityMap('cleveland', 41 x 41 cells of 5 m, 61 landmarks)
    >>> [place.id for place in city.find("the bar")]
    ['Ivy', 'BarleyHouse']
    >>> city.frontage("VelvetDog").street.id
    'West6thSt'
    """

    name: str
    grid: Grid
    landmarks: tuple[Landmark, ...]
    attribution: str = ""
    properties: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    _cache: dict[tuple[str, str], Any] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        by_id: dict[str, Landmark] = {}
        for landmark in self.landmarks:
            if landmark.id in by_id:
                raise MapError(
                    f"Map '{self.name}' has two features with id '{landmark.id}'; ids are unique",
                    feature=landmark.id,
                    field="id",
                )
            by_id[landmark.id] = landmark
        for landmark in self.landmarks:
            if landmark.within is not None and landmark.within not in by_id:
                raise MapError(
                    f"Feature '{landmark.id}' of map '{self.name}': field 'within' names "
                    f"'{landmark.within}', which is not on the map",
                    feature=landmark.id,
                    field="within",
                )
        self._cache["", "by_id"] = by_id

    def __repr__(self) -> str:
        rows, cols = self.grid.shape
        return (
            f"CityMap({self.name!r}, {rows} x {cols} cells of {self.grid.cell_m:g} m, "
            f"{len(self.landmarks)} landmarks)"
        )

    def _repr_html_(self) -> str:
        from sloop_ppl._html import beside, caption, html_table
        from sloop_ppl.maps._notebook import city_svg

        counts = html_table(list(self.counts().items()), ("kind", "landmarks"))
        return caption(repr(self)) + beside([city_svg(self, f"Map {self.name}"), counts])

    def __contains__(self, landmark_id: str) -> bool:
        return landmark_id in self._cache["", "by_id"]

    def landmark(self, landmark_id: str) -> Landmark:
        """Return the landmark with this id.

        Raises
        ------
        UnknownName
            When there is none; the message names the nearest.
        """
        by_id: dict[str, Landmark] = self._cache["", "by_id"]
        if landmark_id not in by_id:
            raise UnknownName(f"landmark of map {self.name}", landmark_id, by_id)
        return by_id[landmark_id]

    def of_kind(self, *kinds: str) -> tuple[Landmark, ...]:
        """Return the landmarks of the given kinds, in file order."""
        return self._kept(
            ("kinds", "\n".join(sorted(set(kinds)))),
            lambda: tuple(m for m in self.landmarks if m.kind in kinds),
        )

    def counts(self) -> dict[str, int]:
        """Return how many landmarks there are of each kind that occurs."""
        counted = {kind: len(self.of_kind(kind)) for kind in KINDS}
        return {kind: n for kind, n in counted.items() if n}

    def footprint(self, landmark_id: str) -> BaseGeometry:
        """Return what a landmark covers: a line widened, a poi as the building it stands in."""
        return self._cached("footprint", landmark_id, self._footprint)

    def centroid(self, landmark_id: str) -> tuple[float, float]:
        """Return x and y of the centroid of a landmark's footprint, metres."""
        centre = self.footprint(landmark_id).centroid
        return float(centre.x), float(centre.y)

    def cells(self, landmark_id: str) -> NDArray[np.bool_]:
        """Return the cells a landmark takes: at least one is True, shape (H, W)."""
        return self.fields(landmark_id).cells

    def fields(self, landmark_id: str) -> LandmarkFields:
        """Return distance and bearing of every cell as seen from a landmark."""
        footprint = self.footprint(landmark_id)
        content = self._cached("content", landmark_id, lambda _: _hash(footprint.wkb))
        return FIELDS.get(
            (self.grid, content),
            lambda: self._fields(footprint),
            # The dearest case, all fields asked for: entries grow after they were put in.
            cost_bytes=self.grid.size * BYTES_PER_CELL,
        )

    def nearest(
        self, x_m: float, y_m: float, among: Iterable[Landmark]
    ) -> tuple[Landmark, float] | None:
        """Return the landmark nearest to a point and its distance in metres; None if none is given.

        It is quickest when `among` is what `of_kind` or `landmarks` gave.
        """
        given = tuple(among)
        index = self._index(given)
        found = index.nearest(shapely.Point(x_m, y_m))
        return None if found is None else (given[found[0]], found[1])

    def landmarks_near(
        self, x_m: float, y_m: float, within_m: float = 50.0, kinds: Sequence[str] = ()
    ) -> list[tuple[Landmark, float]]:
        """Return the landmarks within a distance of a point, nearest first.

        Parameters
        ----------
        x_m, y_m
            The point, metres.
        within_m
            How far a footprint may be, metres, >= 0.
        kinds
            The kinds to look for; all of them when empty.

        Returns
        -------
        list
            Pairs of a landmark and its distance in metres, 0 when the point is on it.
        """
        if not within_m >= 0:
            raise InputError(f"within_m is {within_m}; expected a distance of 0 metres or more")
        among = self.of_kind(*kinds) if kinds else self.landmarks
        found = self._index(among).within(shapely.Point(x_m, y_m), within_m)
        return [(among[i], distance) for i, distance in found]

    def reaching_into(self, area: BaseGeometry) -> list[int]:
        """Return the positions in `landmarks` of those whose geometry meets an area, in order."""
        return [int(i) for i in self._index(self.landmarks, widened=False).touching(area)]

    def find(self, name: str, limit: int = 5) -> tuple[Landmark, ...]:
        """Return the landmarks a name may mean; see :func:`sloop_ppl.maps.find.find`."""
        from sloop_ppl.maps.find import find

        return find(self.landmarks, name, limit)

    def streets_of(self, building_id: str) -> tuple[Landmark, ...]:
        """Return the streets along a building; see :func:`sloop_ppl.maps.frontage.streets_of`."""
        return streets_of(self, building_id)

    def frontage(self, building_id: str) -> Frontage:
        """Return which way a building faces; see :func:`sloop_ppl.maps.frontage.frontage`."""
        return frontage(self, building_id)

    def window(self, center: tuple[float, float], side_m: float) -> CityMap:
        """Return a square piece of the map as a map of its own.

        Parameters
        ----------
        center
            x and y of the middle of the piece, metres.
        side_m
            Its side, metres, > 0. Where it reaches over the map's border it is cut there.

        Returns
        -------
        CityMap
            The landmarks that reach into the piece, cut at its border. Frame, cell size and ids
            stay: a place has the same coordinates on both. A poi keeps its `within` when that
            building is in the piece too.

        Raises
        ------
        InputError
            When `side_m` is not a positive number.
        OutsideMap
            When the centre is not on the map.

        Examples
        --------
        >>> from sloop_ppl.maps import load_map
        >>> load_map("cleveland").window((0, 0), 50).grid.shape
        (11, 11)
        """
        x, y = center
        if not (math.isfinite(side_m) and side_m > 0):
            raise InputError(f"side_m is {side_m}; expected a positive number of metres")
        grid, half = self.grid, side_m / 2
        grid.cell_at(x, y)  # refuses a centre that is not on the map
        west, south = max(x - half, grid.west_m), max(y - half, grid.south_m)
        east, north = min(x + half, grid.east_m), min(y + half, grid.north_m)
        inside = []
        for i in self.reaching_into(shapely.box(west, south, east, north)):
            geometry = clip(self.landmarks[i].geometry, (west, south, east, north))
            if geometry is not None:
                inside.append(replace(self.landmarks[i], geometry=geometry))
        ids = {m.id for m in inside}
        landmarks = tuple(m if m.within in ids else replace(m, within=None) for m in inside)
        smaller = Grid(west, south, east, north, grid.cell_m, grid.centre)
        return replace(self, grid=smaller, landmarks=landmarks, _cache={})

    def bearing_to_nearest_path(self, landmark_id: str) -> float | None:
        """Return the direction from a landmark's centroid to the nearest path, radians.

        Paths are features of kind street, service or pedestrian other than the landmark. None
        when the map has no other path, or when the path runs through the centroid.
        """
        x, y = self.centroid(landmark_id)
        point = shapely.Point(x, y)
        paths = self.of_kind(*PATH_KINDS)
        if self.landmark(landmark_id).kind in PATH_KINDS:
            paths = tuple(m for m in paths if m.id != landmark_id)
        path = self.nearest_line(point, paths)
        if path is None:
            return None
        _, (foot_x, foot_y) = shapely.get_coordinates(shapely.shortest_line(point, path.geometry))
        # Nearer than a micrometre there is no direction.
        if math.hypot(foot_x - x, foot_y - y) < 1e-6:
            return None
        return math.atan2(foot_y - y, foot_x - x)

    def nearest_line(self, to: BaseGeometry, among: tuple[Landmark, ...]) -> Landmark | None:
        """Return the landmark whose geometry, not widened, is nearest; the first of equals."""
        found = self._index(among, widened=False).nearest(to)
        return None if found is None else among[found[0]]

    def derived(self, what: str, make: Callable[[], T]) -> T:
        """Return what `make` computes from this map, computed once and kept under a name."""
        return self._kept(("derived", what), make)

    def with_grid(self, grid: Grid) -> CityMap:
        """Return the same landmarks on other cells."""
        return replace(self, grid=grid, _cache={})

    @property
    def digest(self) -> str:
        """Hash of name, grid and landmarks, by which saved results know their map."""
        return self._kept(("", "digest"), self._digest)

    def _digest(self) -> str:
        landmarks = [[m.id, m.kind, m.name, m.geometry.wkt] for m in self.landmarks]
        payload = json.dumps([self.name, self.grid.shape, self.grid.extent_m, landmarks])
        return _hash(payload.encode())[:16]

    def _cached(self, what: str, landmark_id: str, make: Callable[[Landmark], T]) -> T:
        return self._kept((what, landmark_id), lambda: make(self.landmark(landmark_id)))

    def _kept(self, key: tuple[str, str], make: Callable[[], T]) -> T:
        if key not in self._cache:
            self._cache[key] = make()
        value: T = self._cache[key]
        return value

    def _footprint(self, landmark: Landmark) -> BaseGeometry:
        if landmark.kind == "poi":
            if landmark.within is not None:
                return self.landmark(landmark.within).geometry
            buildings = self.of_kind("building")
            around = self._index(buildings, widened=False).containing(landmark.geometry)
            if len(around):
                return buildings[around[0]].geometry
        # At least a cell wide, else a narrow path would slip between the centres of cells.
        if landmark.geometry.geom_type in ("LineString", "MultiLineString"):
            width = max(landmark.width_m or 0.0, self.grid.cell_m)
            return landmark.geometry.buffer(width / 2)
        return landmark.geometry

    def _fields(self, footprint: BaseGeometry) -> LandmarkFields:
        if type(self.grid) is not Grid:  # loaded by who infers from coarse to fine alone
            from sloop_ppl.maps.uneven_grid import UnevenGrid, uneven_fields

            if isinstance(self.grid, UnevenGrid):
                return uneven_fields(self.grid, footprint)
        min_x, min_y, max_x, max_y = footprint.bounds
        centre = footprint.centroid
        return landmark_fields(
            self.grid,
            touched_cells(self.grid, footprint),
            (float(centre.x), float(centre.y)),
            # The longer side of the bounding box, the extent of a landmark in the likelihoods.
            max(max_x - min_x, max_y - min_y),
        )

    def _index(self, among: tuple[Landmark, ...], widened: bool = True) -> NearestIndex:
        """Return the spatial index of some landmarks, kept when they are all or all of some kinds.

        `widened` asks for what they cover, else it is their geometry.
        """
        # By identity: comparing tuples of thousands of landmarks would cost more than the search.
        key = ("index of footprints" if widened else "index", str(id(among)))
        if key in self._cache:
            kept: NearestIndex = self._cache[key]
            return kept
        index = NearestIndex([self.footprint(m.id) if widened else m.geometry for m in among])
        # An index is kept only for a tuple that the map keeps, too: the id of another may be used
        # again.
        known = among is self.landmarks or any(
            among is value
            for (what, _), value in self._cache.items()
            if what in ("kinds", "derived")
        )
        if known:
            self._cache[key] = index
        return index

    def __getstate__(self) -> dict[str, Any]:
        state = {k: v for k, v in self.__dict__.items() if k != "_cache"}
        return state | {"properties": dict(self.properties)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            object.__setattr__(self, name, value)
        object.__setattr__(self, "properties", MappingProxyType(self.properties))
        object.__setattr__(self, "_cache", {})
        self.__post_init__()


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
