"""Ground one relation on a map: what a likelihood may know about it, cell by cell, as tensors."""

from __future__ import annotations

import itertools
import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from shapely import Point
from shapely.geometry.base import BaseGeometry
from torch import Tensor

from sloop_ppl.errors import DescriptionError, InputError
from sloop_ppl.language import (
    HEARER,
    NOT_ON_MAP,
    RELATIONS,
    SPEAKER,
    WHOLE_MAP,
    Distance,
    Relation,
    SpatialRelation,
    StreetPart,
)
from sloop_ppl.maps import CityMap, LandmarkFields, StreetTables, street_tables
from sloop_ppl.models._choices import Choice, Phrasing
from sloop_ppl.models._reference_regions import (
    ReferenceRegion,
    distance_from,
    ground_distance_m,
    is_hearer,
    is_map,
    point_fields,
    reference_region_of,
    shape_fields,
    with_points,
)
from sloop_ppl.models._vocabulary import speaker_words

__all__ = [
    "GroundedRelation",
    "as_vocabulary_word",
    "ground_phrasing",
    "ground_relations",
    "with_hearer",
    "word_options",
]


_ALIKE = math.cos(math.radians(50.0))
"""Cosine of the angle up to which a compass word and the side it is said of are one direction."""


@dataclass(frozen=True, eq=False)
class GroundedRelation:
    """One relation to its ground or grounds, with their fields flattened over cells.

    It is one term of a description's likelihood, the `term` of ``log_g(term, direction_rad)``.

    Shape legend: S cells, row 0 in the south, row by row.

    Parameters
    ----------
    relation
        Canonical relation word.
    grounds
        Ids of the landmarks, at least one; ``"Map"`` for the map itself.
    city
        The map.
    negated
        True when the relation was denied.
    stated_distance_m
        The distance that was said, metres, or None.
    index
        Position of the relation this term comes from among those of its figure.
    figure
        Id of the target it is about.
    joint
        True when between, across, along and several grounds have a meaning of their own.
    each
        True when it is one of several terms of one phrase, which is said of each ground.
    cells
        The cells that the fields are of, in this order, repeats allowed, shape (S,); None for all
        cells of the map. See `at`.
    latents
        Values of latents that the model declares, by name; see :class:`sloop_ppl.models.Latent`.
    description
        Position of the text it comes from among those of its speaker.
    choices
        What the description leaves open that its meaning depends on; see
        `sloop_ppl.models._choices`.
    holds_when
        Name of a reading or branch -> the values under which it is said; else it is silent.
    slots
        Per ground, the name of the latent that says which place it is, None for a certain one;
        empty when all are.
    denied
        Per ground, the places that are all denied ("not near a bank"); empty when there is one.
    is_silent
        True when it says nothing: it is not said, or of a place that is not on the map.
    distance_bounds
        The distance that was said, as bounds ("within 50 m", "at least 20 m") with their vagueness;
        None when none was said. Equal ones are one number, `stated_distance_m`.
    points
        Ground that is a point and no landmark, such as the place of who listens -> its (x, y),
        metres, which may be outside the map.
    """

    relation: str
    grounds: tuple[str, ...]
    city: CityMap
    negated: bool = False
    stated_distance_m: float | None = None
    index: int = 0
    joint: bool = False
    each: bool = False
    cells: NDArray[np.intp] | None = None
    figure: str = ""
    latents: Mapping[str, Any] = field(default_factory=dict)
    description: int = 0
    choices: tuple[Choice, ...] = ()
    holds_when: Mapping[str, frozenset[int]] = field(default_factory=dict)
    slots: tuple[str | None, ...] = ()
    denied: tuple[tuple[str, ...], ...] = ()
    is_silent: bool = False
    distance_bounds: Distance | None = None
    points: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    part: StreetPart | None = None

    @property
    def n_cells(self) -> int:
        """How many cells the fields are of: S, all of the map's or those of `at`."""
        return self.city.grid.size if self.cells is None else len(self.cells)

    @property
    def ground(self) -> str:
        """The first (for most relations the only) ground."""
        return self.grounds[0]

    @property
    def is_map(self) -> bool:
        """Tell whether the ground is the map itself, which has sides but no frame."""
        return is_map(self.city, self.ground)

    @property
    def is_point(self) -> bool:
        """Tell whether it measures from one point that is no landmark and has no known front."""
        return self.ground in self.points and len(self.grounds) == 1

    @cached_property
    def record(self) -> Relation:
        """What the word means of this ground; left of the map is its west.

        A compass word that says which part it is means to be there: "on the north side of Forbes".
        """
        record = RELATIONS[self.relation]
        if record.of_map and self.is_map:
            return RELATIONS[record.of_map]
        return RELATIONS["at"] if self._names_its_part(record) else record

    def _names_its_part(self, record: Relation) -> bool:
        """Tell "on the north side of" from "north of the end of", which is north of a place."""
        part = self.part
        if part is None or part.bearing_rad is None or record.bearing_rad is None:
            return False
        return self.has_part and math.cos(record.bearing_rad - part.bearing_rad) > _ALIKE

    @property
    def has_part(self) -> bool:
        """Tell whether a part of a street is meant that the map has."""
        region = self._region_of_part
        return region is not None and region.is_part

    @cached_property
    def _region_of_part(self) -> ReferenceRegion | None:
        if self.part is None or not self.joint or self.is_map or self.is_point:
            return None
        record = RELATIONS[self.relation]
        if record.needs_frame:  # front and behind are sides of a ground, not of its parts
            return None
        return reference_region_of(
            self.relation, record, self.grounds, self.city, self.joint, self.part
        )

    @property
    def is_own_place(self) -> bool:
        """Tell whether a speaker locates themselves by it: "I am at the bank"."""
        return self.figure == SPEAKER

    @property
    def relation_class(self) -> str:
        """The class the word belongs to, such as ``"contact"``; see `record`."""
        return self.record.relation_class

    @property
    def width(self) -> str:
        """Which of its widths a likelihood takes, such as ``"contact"`` or ``"directed"``."""
        # A side of the map is a region of its own, in no direction from anything.
        width = self.record.width or "proximity"
        return "proximity" if width == "directed" and self.is_map else width

    @cached_property
    def reference_region(self) -> ReferenceRegion | None:
        """What the relation measures from; None when that is simply its ground."""
        if self.is_point:
            return None
        if self.has_part:
            return self._region_of_part
        placed = {ground: self.points[ground] for ground in self.grounds if ground in self.points}
        city = with_points(self.city, placed)
        return reference_region_of(self.relation, self.record, self.grounds, city, self.joint)

    @property
    def fields(self) -> LandmarkFields:
        """The fields of what the relation measures from, shape (H, W)."""
        if self.reference_region is not None:
            return shape_fields(self.reference_region.shape, self.city.grid)
        if self.is_point:
            return point_fields(self.points[self.ground], self.city.grid)
        return self.city.fields(self.ground)

    @cached_property
    def distance_m(self) -> Tensor:
        """Metres to the ground's nearest cell (of 5 m, on finer grids), shape (S,).

        For a corner it is the distance to the farther ground, for between, across, along and the
        map's sides that to the region they mean, for a point that to the point itself.
        """
        reference_region, city = self.reference_region, self.city
        if reference_region is None:
            table = self._distance_to(self.ground)
        elif reference_region.grounds:
            table = np.maximum.reduce([self._distance_to(g) for g in reference_region.grounds])
        else:
            shape = reference_region.shape
            table = distance_from(city.grid, lambda grid: shape_fields(shape, grid))
        return self._at_cells(table)

    def _distance_to(self, ground: str) -> NDArray[np.float64]:
        """Return the distance from each cell to one of the grounds, shape (H, W)."""
        if ground in self.points:
            return point_fields(self.points[ground], self.city.grid).from_centroid_m
        return ground_distance_m(self.city, ground)

    @cached_property
    def off_m(self) -> Tensor:
        """Metres between a cell's distance and the one that is meant, shape (S,).

        It is `distance_m` itself unless a distance was said: "20 m from the bank" means the ring,
        "within 20 m" all that is inside. A likelihood that falls off with this reads said distances
        by itself.
        """
        if self.has_bounds:
            return self.below_m + self.above_m
        if self.stated_distance_m is None:
            return self.distance_m
        return (self.distance_m - self.stated_distance_m).abs()

    @cached_property
    def off_street_m(self) -> Tensor:
        """Metres to the carriageway of a street, 0 on it; `off_m` of anything else, shape (S,).

        Of a said distance, and of what the map's network of streets has not, it is `off_m`, too.
        """
        if self._street is None or self.has_bounds or self.stated_distance_m is not None:
            return self.off_m
        return self._at_cells(self._street.carriageway_m)

    @cached_property
    def _street(self) -> StreetTables | None:
        """How each cell lies to the street that is the ground; None where it has no axis.

        The axis is that of the whole street, of all its landmarks. Models that ground each phrase
        on one ground measure from its cells, as the published code does.
        """
        if not self.joint or not self.is_line or self.reference_region is not None:
            return None
        tables = street_tables(self.city, self.ground)
        return tables if np.isfinite(tables.axis_m).all() else None

    @property
    def has_bounds(self) -> bool:
        """Tell whether bounds on the distance were said, and not one number."""
        return self.distance_bounds is not None and self.distance_bounds.stated_m is None

    @property
    def below_m(self) -> Tensor:
        """Metres by which a cell is nearer than the lower bound of a said distance, shape (S,)."""
        low = 0.0 if self.distance_bounds is None else self.distance_bounds.low_m
        return (low - self.distance_m).clamp_min(0.0)

    @property
    def above_m(self) -> Tensor:
        """Metres by which a cell is farther than the upper bound of a said distance, shape (S,)."""
        high = math.inf if self.distance_bounds is None else self.distance_bounds.high_m
        return (self.distance_m - high).clamp_min(0.0)

    @cached_property
    def on_ground(self) -> Tensor:
        """True on the cells the relation measures from, shape (S,)."""
        return self._at_cells(self.fields.cells)

    @cached_property
    def bearing_rad(self) -> Tensor:
        """Direction from the ground's centroid, shape (S,)."""
        return self._at_cells(self.fields.bearing_rad)

    @cached_property
    def nearest_bearing_rad(self) -> Tensor:
        """Direction from the ground's nearest cell, the centroid's on the ground, shape (S,)."""
        if self.is_point:
            return self.bearing_rad
        grid = self.city.grid
        rows, cols = self.fields.nearest
        north = grid.y_m[:, None] - grid.y_m[rows]
        east = grid.x_m[None, :] - grid.x_m[cols]
        on_ground = self.fields.cells
        bearing = np.where(on_ground, self.fields.bearing_rad, np.arctan2(north, east))
        return self._at_cells(bearing)

    @cached_property
    def outward_rad(self) -> Tensor:
        """Direction from the nearest cell of a line, the centroid of anything else, shape (S,).

        A street has no middle that one is north of; a building has.
        """
        if self._street is not None:
            east, north = self._street.offset_m
            return self._at_cells(np.arctan2(north, east))
        along = self.form == "line" and self.reference_region is None
        return self.nearest_bearing_rad if along else self.bearing_rad

    @cached_property
    def has_direction(self) -> Tensor:
        """False where `outward_rad` says nothing: on a line, at a centroid, shape (S,)."""
        if self._street is not None:
            return self._at_cells(self._street.carriageway_m > 0)
        if self.form == "line" and self.reference_region is None:
            return ~self.on_ground
        return ~self.at_centroid

    @cached_property
    def at_centroid(self) -> Tensor:
        """True where a cell's centre is the ground's centroid, so has no direction, shape (S,)."""
        return self._at_cells(self.fields.from_centroid_m < 1e-6)

    @property
    def extent_m(self) -> float:
        """Longer side of the ground's bounding box, metres."""
        return self.fields.extent_m

    @property
    def is_line(self) -> bool:
        """Tell whether the ground is a line, such as a street."""
        if self.is_map or self.ground in self.points:
            return False
        return "LineString" in self.city.landmark(self.ground).geometry.geom_type

    @property
    def form(self) -> Literal["point", "line", "area"]:
        """What the ground is on the map; a poi has the shape of the building it stands in."""
        if self.is_line:
            return "line"
        if self.ground in self.points:
            return "point"
        dull = self.is_map or self.city.footprint(self.ground).area > 0
        return "area" if dull else "point"

    @property
    def outline(self) -> BaseGeometry:
        """What the relation measures from, as a shape on the map, metres."""
        if self.is_point:
            return Point(self.points[self.ground])
        return (
            self.city.footprint(self.ground)
            if self.reference_region is None
            else self.reference_region.shape
        )

    @property
    def kind(self) -> str:
        """Kind of the ground, such as ``"building"``, ``"map"`` or ``"point"``."""
        if self.ground in self.points:
            return "point"
        return "map" if self.is_map else self.city.landmark(self.ground).kind

    @property
    def needs_frame(self) -> bool:
        """Tell whether the direction depends on which way the ground faces."""
        return self.record.needs_frame

    @property
    def offset_rad(self) -> float:
        """Direction of the relation less the front of its ground (frame relations only)."""
        offset = self.record.offset_rad
        if offset is None:
            raise InputError(f"Relation '{self.relation}' has no frame; expected a frame word")
        return offset

    @property
    def compass_rad(self) -> float | None:
        """Direction of a compass relation, None for the others and for the map's own sides."""
        return None if self.is_map else self.record.bearing_rad

    def directions(self, frame_angles_rad: Tensor | None) -> Tensor | None:
        """Return the directions the relation points in.

        Parameters
        ----------
        frame_angles_rad
            Directions its ground may face, radians, shape (B,).

        Returns
        -------
        Tensor or None
            One for each front for a frame word, shape (B,); the one of a compass word, shape (1,);
            None for a relation without direction.
        """
        if self.needs_frame:
            return None if frame_angles_rad is None else frame_angles_rad + self.offset_rad
        if self.compass_rad is None:
            return None
        return torch.tensor([self.compass_rad], dtype=torch.float64)

    @property
    def meaning(self) -> Hashable:
        """What two relations of one map have in common when they say the same of every cell."""
        return (
            self.relation,
            self.grounds,
            self.negated,
            self.stated_distance_m,
            self.distance_bounds,
            self.joint,
            tuple(self.points.get(ground) for ground in self.grounds),
            tuple(sorted(self.latents.items())),
            self.denied,
            self.is_silent,
            self.part,
            self.is_own_place,
        )

    @cached_property
    def line_normal_rad(self) -> float:
        """Direction of one of the two normals to a line, radians.

        The line's axis is the mean of its pieces' directions, each weighed by its length and
        taken modulo half a turn (by doubling angles), so bends and loops count as they run.
        """
        geometry = self.city.landmark(self.ground).geometry
        lines = [np.asarray(part.coords) for part in getattr(geometry, "geoms", [geometry])]
        pieces = np.concatenate([np.diff(line, axis=0) for line in lines])
        doubled = 2 * np.arctan2(pieces[:, 1], pieces[:, 0])
        weight = np.hypot(pieces[:, 0], pieces[:, 1])
        axis = math.atan2(weight @ np.sin(doubled), weight @ np.cos(doubled)) / 2
        return axis + math.pi / 2

    @cached_property
    def place_m(self) -> Tensor:
        """Centre of each cell, (x, y) metres, shape (S, 2)."""
        x, y = np.meshgrid(self.city.grid.x_m, self.city.grid.y_m)
        return torch.stack([self._at_cells(x), self._at_cells(y)], -1)

    def at(self, cells: NDArray[np.intp]) -> GroundedRelation:
        """Return the same relation with fields of some cells only, shape (S,) for S of them.

        Parameters
        ----------
        cells
            Indices into the map's cells, row by row; repeats are allowed.
        """
        return replace(self, cells=cells)

    def chosen(self, name: str, value: Any) -> GroundedRelation:
        """Return the same relation under a value of a latent of its description; see `choices`."""
        if name in self.holds_when:
            return self if value in self.holds_when[name] else replace(self, is_silent=True)
        if value == NOT_ON_MAP or not self._is_place(value):
            return replace(self, is_silent=True)
        grounds = tuple(
            value if slot == name else ground
            for ground, slot in zip(self.grounds, self.slots, strict=True)
        )
        # No place lies between a ground and itself, so such a pair tells nothing.
        is_pair = len(set(grounds)) == len(grounds)
        return replace(self, grounds=grounds, is_silent=self.is_silent or not is_pair)

    def _is_place(self, ground: str) -> bool:
        """Tell whether a ground has a place of its own; another target has none that is known."""
        return ground in self.city or is_map(self.city, ground) or ground in self.points

    def belongs_to(self, name: str, value: int) -> bool:
        """Tell whether the relation belongs to a reading, or a branch, of this name."""
        return name not in self.holds_when or value in self.holds_when[name]

    @property
    def is_main(self) -> bool:
        """Tell whether it belongs to the most probable reading."""
        return all(self.belongs_to(c.name, 0) for c in self.choices if c.kind == "reading")

    @property
    def has_open_ground(self) -> bool:
        """Tell whether it is not certain which place it is about."""
        return any(self.slots) or any(self.denied)

    @property
    def each_denied(self) -> tuple[GroundedRelation, ...]:
        """The relation to each of the places, or pairs of places, that are denied."""
        if not any(self.denied):
            return (self,)
        options = [d or (g,) for d, g in zip(self.denied, self.grounds, strict=True)]
        return tuple(
            replace(self, grounds=grounds, denied=())
            for grounds in itertools.product(*options)
            if len(set(grounds)) == len(grounds)
        )

    def with_latent(self, name: str, value: Any) -> GroundedRelation:
        """Return the same relation under a value of a latent; see `latents`."""
        return replace(self, latents={**self.latents, name: value})

    def _at_cells(self, table: NDArray[Any]) -> Tensor:
        """Return a table over the map, (H, W), at the cells that this term is about, (S,)."""
        flat = table.reshape(-1)
        return torch.from_numpy(flat if self.cells is None else flat[self.cells])

    def as_relation(self, word: str) -> GroundedRelation:
        """Return the same grounds in another relation, asserted."""
        return replace(
            self,
            relation=word,
            negated=False,
            stated_distance_m=None,
            distance_bounds=None,
            part=None,
        )


def ground_relations(
    relations: tuple[SpatialRelation, ...], city: CityMap, joint: bool = False
) -> tuple[GroundedRelation, ...]:
    """Return the terms of the relations, in the order they were said.

    Parameters
    ----------
    relations
        What was said of one figure.
    city
        The map.
    joint
        True for one term per relation, which gives between, corners, across and along their own
        meaning; False for one term per relation and ground, as in the published code.

    Raises
    ------
    UnknownName
        When a ground is not on the map.

    Notes
    -----
    The ground ``"Map"`` is the map itself unless a landmark has that id: "the top left of the
    map". It has sides, of which left is west and front is north, and no frame. Who listens has no
    place yet; see `with_hearer`.
    """
    return tuple(
        term
        for index, relation in enumerate(relations)
        for term in ground_phrasing(_certain(relation, index), index, city, joint=joint)
    )


def ground_phrasing(
    phrasing: Phrasing, index: int, city: CityMap, *, joint: bool
) -> tuple[GroundedRelation, ...]:
    """Return the terms of one relation, with what has to be chosen before they have a meaning.

    Parameters
    ----------
    phrasing
        The relation and its choices.
    index
        Position of the relation among those of its figure.
    city, joint
        See `ground_relations`.

    Raises
    ------
    UnknownName
        When a ground, or a candidate of one, is not on the map.
    """
    relation, count = phrasing.relation, len(phrasing.relation.grounds)
    slots = [None if slot is None else slot.name for slot in phrasing.slots] or [None] * count
    denied = phrasing.denied or [()] * count
    for ground in (c.ground for slot in relation.candidates for c in slot if c.ground is not None):
        _ground_id(ground, city)
    grounds = [_ground_id(ground, city) for ground in relation.grounds]
    places = [_Place(*place) for place in zip(grounds, slots, map(tuple, denied), strict=True)]
    terms = []
    for together in _split(places, city, joint and not relation.each):
        names = [place.slot for place in together]
        terms.append(
            GroundedRelation(
                relation=relation.relation,
                grounds=tuple(place.ground for place in together),
                city=city,
                negated=relation.negated,
                stated_distance_m=relation.distance_m,
                index=index,
                joint=joint,
                figure=relation.figure,
                each=relation.each,
                choices=tuple(c for c in phrasing.choices if c.kind != "ground" or c.name in names),
                holds_when=dict(phrasing.holds_when),
                slots=tuple(names) if any(names) else (),
                denied=tuple(p.denied for p in together) if any(denied) else (),
                is_silent=phrasing.is_silent,
                distance_bounds=relation.distance,
                part=relation.part,
            )
        )
    return tuple(terms)


def _certain(relation: SpatialRelation, index: int) -> Phrasing:
    """Return a relation to its most probable grounds."""
    return Phrasing(relation, index, {0}, is_silent=NOT_ON_MAP in relation.grounds)


class _Place(NamedTuple):
    """A ground of a phrase, the latent that says which it is, and all that are denied."""

    ground: str
    slot: str | None
    denied: tuple[str, ...]


def with_hearer(
    terms: tuple[GroundedRelation, ...], hearer: tuple[float, float] | None
) -> tuple[GroundedRelation, ...]:
    """Return terms that know where who listens is, so that it may be their ground.

    Parameters
    ----------
    terms
        The terms of one description.
    hearer
        The place, (x, y) in metres, inside the map or outside; None when unknown.

    Raises
    ------
    DescriptionError
        When a ground is who listens, and the place is unknown.
    """
    if hearer is not None:
        return tuple(
            replace(term, points={**term.points, HEARER: hearer})
            if is_hearer(term.city, HEARER)
            else term
            for term in terms
        )
    for term in terms:
        open_places = {g for c in term.choices if c.kind == "ground" for g in c.support}
        grounds = open_places.union(term.grounds, *term.denied)
        if any(is_hearer(term.city, ground) for ground in grounds):
            raise DescriptionError(
                f"Relation '{term.relation}' of '{term.figure}' is to who listens, and the field "
                "'hearer' of the description is not set; expected a place in metres: "
                "hearer=(x_m, y_m) in Python, --hearer X,Y, or the field 'hearer' of a line"
            )
    return terms


def word_options(term: GroundedRelation) -> tuple[tuple[GroundedRelation, ...], int]:
    """Return all that could have been said of a term's grounds, and the index of what was.

    Notes
    -----
    Words of one class are one choice: "beside" is chosen when "near" is. A meaning outside the
    vocabulary counts as one more word.
    """
    options = tuple(term.as_relation(word) for word in speaker_words())
    same = [i for i, o in enumerate(options) if o.relation_class == term.relation_class]
    if same:
        return options, same[-1]
    return (*options, replace(term, negated=False)), len(options)


def as_vocabulary_word(term: GroundedRelation) -> GroundedRelation:
    """Return a relation as the word of the speaker's vocabulary that it counts as."""
    options, chosen = word_options(term)
    return replace(options[chosen], negated=term.negated)


def _split(places: list[_Place], city: CityMap, joint: bool) -> list[tuple[_Place, ...]]:
    """Return which grounds make up each term; the map never joins others."""
    if not joint:
        return [(place,) for place in places]
    placed = tuple(dict.fromkeys(place for place in places if not is_map(city, place.ground)))
    whole = (_Place(WHOLE_MAP, None, ()),)
    if not placed:
        return [whole]
    return [placed, whole] if any(is_map(city, p.ground) for p in places) else [placed]


def _ground_id(ground: str, city: CityMap) -> str:
    if ground == NOT_ON_MAP or is_map(city, ground) or is_hearer(city, ground):
        return ground
    return city.landmark(ground).id
