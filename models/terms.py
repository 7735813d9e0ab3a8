"""Ground one relation on a map: what a likelihood may know about it, cell by cell, as tensors."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import torch
from torch import Tensor

from sloop_ppl.language import FRAME_RELATIONS, RELATIONS, SpatialRelation
from sloop_ppl.maps import CityMap, LandmarkFields
from sloop_ppl.models.directions import COMPASS_RAD, FRAME_OFFSET_RAD
from sloop_ppl.models.distance import ground_distance_m

__all__ = ["RelationTerm", "ground_relations"]


@dataclass(frozen=True, eq=False)
class RelationTerm:
    """One relation to one ground, with the ground's fields flattened over cells.

    Shape legend: S cells, row 0 in the south, row by row.

    Parameters
    ----------
    relation : canonical relation word.
    relation_class : the class the word belongs to, such as ``"contact"``.
    ground : id of the landmark.
    city : the map.
    negated : True when the relation was denied.
    said_distance_m : the distance that was said, metres, or None.
    index : position of the relation this term comes from among those of its figure.
    """

    relation: str
    relation_class: str
    ground: str
    city: CityMap
    negated: bool = False
    said_distance_m: float | None = None
    index: int = 0

    @property
    def fields(self) -> LandmarkFields:
        """The ground's fields, shape (H, W)."""
        return self.city.fields(self.ground)

    @cached_property
    def distance_m(self) -> Tensor:
        """Metres to the ground's nearest cell (of 5 m, on finer grids), shape (S,)."""
        return torch.from_numpy(ground_distance_m(self.city, self.ground).reshape(-1))

    @cached_property
    def on_ground(self) -> Tensor:
        """True on the ground's cells, shape (S,)."""
        return torch.from_numpy(self.city.cells(self.ground).reshape(-1))

    @cached_property
    def bearing_rad(self) -> Tensor:
        """Direction from the ground's centroid, shape (S,)."""
        return torch.from_numpy(self.fields.bearing_rad.reshape(-1))

    @cached_property
    def nearest_bearing_rad(self) -> Tensor:
        """Direction from the ground's nearest cell, the centroid's on the ground, shape (S,)."""
        grid = self.city.grid
        rows, cols = self.fields.nearest
        north = grid.y_m[:, None] - grid.y_m[rows]
        east = grid.x_m[None, :] - grid.x_m[cols]
        on_ground = self.fields.distance_m == 0
        bearing = np.where(on_ground, self.fields.bearing_rad, np.arctan2(north, east))
        return torch.from_numpy(bearing.reshape(-1))

    @cached_property
    def at_centroid(self) -> Tensor:
        """True where a cell's centre is the ground's centroid, so has no direction, shape (S,)."""
        return torch.from_numpy(self.fields.from_centroid_m.reshape(-1) < 1e-6)

    @property
    def extent_m(self) -> float:
        """Longer side of the ground's bounding box, metres."""
        return self.fields.extent_m

    @property
    def is_line(self) -> bool:
        """Tell whether the ground is a line, such as a street."""
        return "LineString" in self.city.landmark(self.ground).geometry.geom_type

    @property
    def needs_frame(self) -> bool:
        """Tell whether the direction depends on which way the ground faces."""
        return self.relation_class in FRAME_RELATIONS

    @property
    def offset_rad(self) -> float:
        """Direction of the relation less the front of its ground (frame relations only)."""
        return FRAME_OFFSET_RAD[self.relation_class]

    @property
    def compass_rad(self) -> float | None:
        """Direction of a compass relation, None for the others."""
        return COMPASS_RAD.get(self.relation_class)

    @cached_property
    def line_normal_rad(self) -> float:
        """Direction of one of the two normals to a line, from its two ends, radians."""
        ends = self.city.landmark(self.ground).geometry
        parts = getattr(ends, "geoms", [ends])
        (x0, y0), (x1, y1) = parts[0].coords[0], parts[-1].coords[-1]
        return math.atan2(x0 - x1, y1 - y0)

    def as_relation(self, word: str) -> RelationTerm:
        """Return the same ground in another relation, asserted."""
        return replace(self, relation=word, relation_class=RELATIONS[word], negated=False)


def ground_relations(
    relations: tuple[SpatialRelation, ...], city: CityMap
) -> tuple[RelationTerm, ...]:
    """Return one term per relation and ground, in the order they were said.

    A relation to several grounds (between, at the corner of) becomes one term per ground, as in
    the published code.

    Raises
    ------
    UnknownName : when a ground is not on the map.
    """
    return tuple(
        RelationTerm(
            relation=relation.relation,
            relation_class=RELATIONS[relation.relation],
            ground=city.landmark(ground).id,
            city=city,
            negated=relation.negated,
            said_distance_m=relation.distance_m,
            index=index,
        )
        for index, relation in enumerate(relations)
        for ground in relation.grounds
    )
