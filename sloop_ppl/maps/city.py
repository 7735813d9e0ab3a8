"""A map: its grid, its landmarks, and what can be asked of them."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from sloop_ppl.errors import MapError, UnknownName
from sloop_ppl.maps.fields import LandmarkFields, landmark_fields
from sloop_ppl.maps.grid import Grid
from sloop_ppl.maps.landmark import KINDS, PATH_KINDS, Landmark
from sloop_ppl.maps.rasterise import touched_cells

__all__ = ["CityMap"]

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class CityMap:
    """A city patch: landmarks on a grid. Immutable; what is derived from it is cached.

    Parameters
    ----------
    name : what the map is called.
    grid : its cells and frame.
    landmarks : its landmarks, ids unique.
    attribution : whom the data belong to.
    properties : other top-level members of the map file.

    Raises
    ------
    MapError : when two landmarks share an id, or a poi stands within an unknown landmark.
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

    def __contains__(self, landmark_id: str) -> bool:
        return landmark_id in self._cache["", "by_id"]

    def landmark(self, landmark_id: str) -> Landmark:
        """Return the landmark with this id.

        Raises
        ------
        UnknownName : when there is none; the message names the nearest.
        """
        by_id: dict[str, Landmark] = self._cache["", "by_id"]
        if landmark_id not in by_id:
            raise UnknownName(f"landmark of map {self.name}", landmark_id, by_id)
        return by_id[landmark_id]

    def of_kind(self, *kinds: str) -> tuple[Landmark, ...]:
        """Return the landmarks of the given kinds, in file order."""
        return tuple(m for m in self.landmarks if m.kind in kinds)

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
        return self._cached(
            "cells", landmark_id, lambda m: touched_cells(self.grid, self.footprint(m.id))
        )

    def fields(self, landmark_id: str) -> LandmarkFields:
        """Return distance and bearing of every cell as seen from a landmark."""
        return self._cached("fields", landmark_id, self._fields)

    def nearest(
        self, x_m: float, y_m: float, among: Iterable[Landmark]
    ) -> tuple[Landmark, float] | None:
        """Return the landmark nearest to a point and its distance in metres; None if none is given."""
        point = shapely.Point(x_m, y_m)
        measured = [(self.footprint(m.id).distance(point), i, m) for i, m in enumerate(among)]
        if not measured:
            return None
        distance, _, landmark = min(measured, key=lambda t: t[:2])
        return landmark, float(distance)

    def bearing_to_nearest_path(self, landmark_id: str) -> float | None:
        """Return the direction from a landmark's centroid to the nearest path, radians.

        Paths are features of kind street, service or pedestrian other than the landmark. None
        when the map has no other path, or when the path runs through the centroid.
        """
        x, y = self.centroid(landmark_id)
        paths = [m for m in self.of_kind(*PATH_KINDS) if m.id != landmark_id]
        point = shapely.Point(x, y)
        lines = [m.geometry for m in paths]
        if not lines:
            return None
        line = lines[int(np.argmin(shapely.distance(lines, point)))]
        (_, _), (foot_x, foot_y) = shapely.get_coordinates(shapely.shortest_line(point, line))
        if math.hypot(foot_x - x, foot_y - y) < 1e-6:
            return None
        return math.atan2(foot_y - y, foot_x - x)

    def with_grid(self, grid: Grid) -> CityMap:
        """Return the same landmarks on other cells."""
        return replace(self, grid=grid, _cache={})

    @property
    def digest(self) -> str:
        """Hash of name, grid and landmarks, by which saved results know their map."""
        if ("", "digest") not in self._cache:
            told = json.dumps(
                [
                    self.name,
                    self.grid.shape,
                    self.grid.extent_m,
                    [[m.id, m.kind, m.name, m.geometry.wkt] for m in self.landmarks],
                ]
            )
            self._cache["", "digest"] = hashlib.sha256(told.encode()).hexdigest()[:16]
        digest: str = self._cache["", "digest"]
        return digest

    def _cached(self, what: str, landmark_id: str, make: Callable[[Landmark], T]) -> T:
        key = what, landmark_id
        if key not in self._cache:
            self._cache[key] = make(self.landmark(landmark_id))
        value: T = self._cache[key]
        return value

    def _footprint(self, landmark: Landmark) -> BaseGeometry:
        if landmark.kind == "poi" and landmark.geometry.geom_type == "Point":
            if landmark.within is not None:
                return self.landmark(landmark.within).geometry
            for building in self.of_kind("building"):
                if building.geometry.contains(landmark.geometry):
                    return building.geometry
        if landmark.geometry.geom_type in ("LineString", "MultiLineString"):
            width = max(landmark.width_m or 0.0, self.grid.cell_m)
            return landmark.geometry.buffer(width / 2)
        return landmark.geometry

    def _fields(self, landmark: Landmark) -> LandmarkFields:
        min_x, min_y, max_x, max_y = self.footprint(landmark.id).bounds
        return landmark_fields(
            self.grid,
            self.cells(landmark.id),
            self.centroid(landmark.id),
            max(max_x - min_x, max_y - min_y),
        )
