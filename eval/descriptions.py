"""Read description files: what people said about placements of objects, with the truth."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from importlib.resources import files
from pathlib import Path
from types import MappingProxyType
from typing import Any

from sloop_ppl.errors import InputError, SloopError
from sloop_ppl.eval._objects import declared_object
from sloop_ppl.eval._records import Fault, Record
from sloop_ppl.language import (
    DEFAULT_TARGETS,
    HEARER,
    RELATIONS,
    WHOLE_MAP,
    Description,
    SpatialRelation,
    TargetObject,
    Viewpoint,
    check_viewpoint,
)
from sloop_ppl.maps import CityMap, Grid, load_map

__all__ = [
    "AnnotatedDescription",
    "FrameAnnotation",
    "Place",
    "bundled_examples",
    "read_descriptions",
    "read_sound_descriptions",
]

FindMap = Callable[[str], CityMap]

# The grid that `col_from_west` and `row_from_north` count on, whatever the map's own cells are.
_COUNTED_CELL_M = 5.0
# How far `lonlat`, rounded to seven decimals, may lie from `east_m` and `north_m`.
_LONLAT_SLACK_M = 0.5


@dataclass(frozen=True)
class Place:
    """Where a target truly is.

    Parameters
    ----------
    x_m, y_m
        Metres east and north of the map's centre.
    cell
        Its row (row 0 in the south) and column on the map's grid.
    """

    x_m: float
    y_m: float
    cell: tuple[int, int]


@dataclass(frozen=True)
class FrameAnnotation:
    """Which way an annotator saw a ground face.

    Parameters
    ----------
    ground
        Id of the ground.
    relation
        The relation it was asked for.
    front_deg
        Direction of the front, degrees anticlockwise from east.
    annotator
        Who said so, or None.
    """

    ground: str
    relation: str
    front_deg: float
    annotator: str | None = None


@dataclass(frozen=True)
class AnnotatedDescription:
    """One line of a description file: a text, what it says, and where the targets are.

    Parameters
    ----------
    id
        Name of the line, unique among the lines read together.
    map
        Name of the map.
    configuration
        Name of the placement of the objects, shared by all who described it.
    text
        What was said.
    targets
        Id of each declared object -> where it is; empty when the line declares none.
    relations
        The gold relations; the entries of a group are one relation.
    speaker
        Who said it, or None.
    frames
        Annotated frames of reference.
    viewpoint
        Where the speaker looked from; the relations are those meant from there. See
        :class:`sloop_ppl.language.Description`.
    hearer
        Where who listens was, (x_m, y_m), which may be outside the map; None when unknown.
    area_m
        West, south, east and north border of the area that is searched, metres; None for the map.
    """

    id: str
    map: str
    configuration: str
    text: str
    targets: Mapping[str, Place] = field(default_factory=lambda: MappingProxyType({}))
    relations: tuple[SpatialRelation, ...] = ()
    speaker: str | None = None
    frames: tuple[FrameAnnotation, ...] = ()
    viewpoint: Viewpoint = "map"
    hearer: tuple[float, float] | None = None
    area_m: tuple[float, float, float, float] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "targets", MappingProxyType(dict(self.targets)))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by value; a view of a mapping cannot be pickled."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        return AnnotatedDescription, (*({**values, "targets": dict(self.targets)}.values()),)

    @property
    def objects(self) -> tuple[TargetObject, ...]:
        """The declared objects in file order; empty means the default ones."""
        return tuple(declared_object(name) for name in self.targets)

    def description(self, city: CityMap) -> Description:
        """Return what is said on a map according to the gold relations."""
        return Description(
            self.text,
            city.name,
            self.objects,
            self.relations,
            viewpoint=self.viewpoint,
            hearer=self.hearer,
        )

    def about(self, target_id: str) -> tuple[SpatialRelation, ...]:
        """Return the gold relations of one target, in file order."""
        return tuple(r for r in self.relations if r.figure == target_id)


def read_descriptions(
    paths: str | Path | Iterable[str | Path], find_map: FindMap | None = None
) -> tuple[AnnotatedDescription, ...]:
    """Read one or several description files.

    Parameters
    ----------
    paths
        ``.jsonl`` files, one JSON object a line; blank lines are passed over.
    find_map
        Gives the map of a line by the name in its field ``map``; bundled names and paths when None.

    Returns
    -------
    tuple of AnnotatedDescription
        In file order.

    Raises
    ------
    InputError
        When a file cannot be read, or for any line that does not follow the format: the message
        lists the fault of every such line with file, line number and field.

    Notes
    -----
    Entries of one relation share a ``group``. The published data give none, so the entries
    ``between`` of one figure that have no group are one relation too: nothing is between one thing.

    Examples
    --------
    >>> from sloop_ppl.eval import bundled_examples
    >>> annotated = bundled_examples()[0]
    >>> annotated.map, annotated.targets["RedBike"].cell, annotated.relations[1].grounds
    ('austin', (34, 19), ('ClaudiaTaylorJohnsonHall', 'ChaseBankTower'))
    """
    descriptions, faults = read_sound_descriptions(paths, find_map)
    if faults:
        raise InputError("; ".join(faults))
    return descriptions


def read_sound_descriptions(
    paths: str | Path | Iterable[str | Path], find_map: FindMap | None = None
) -> tuple[tuple[AnnotatedDescription, ...], tuple[str, ...]]:
    """Return the lines of description files that follow the format, and the faults of the others.

    Parameters
    ----------
    paths, find_map
        As in `read_descriptions`.

    Returns
    -------
    tuple
        The descriptions in file order, and a fault for each line or file that has one: file, line
        number, field, what was found and what was expected.

    Raises
    ------
    InputError
        When a file cannot be read.
    """
    sources = [paths] if isinstance(paths, str | Path) else list(paths)
    find = functools.cache(find_map or load_map)
    descriptions: dict[str, AnnotatedDescription] = {}
    faults: list[str] = []
    for source in sources:
        before = len(descriptions), len(faults)
        for number, line in _lines(source):
            try:
                annotated = _annotated(_parse(line), find)
                _check_new(annotated.id, descriptions)
                descriptions[annotated.id] = annotated
            except Fault as fault:
                faults.append(f"{source}:{number}: field '{fault.field}' {fault.what}")
        if before == (len(descriptions), len(faults)):
            faults.append(f"{source} holds no description; expected one JSON object a line")
    return tuple(descriptions.values()), tuple(faults)


def bundled_examples() -> tuple[AnnotatedDescription, ...]:
    """Return the example descriptions of the bundled cities that ship with the package."""
    return read_descriptions(Path(str(files("sloop_ppl"))) / "data" / "examples.jsonl")


def _check_new(description_id: str, known: Container[str]) -> None:
    if description_id in known:
        raise Fault("id", f"repeats '{description_id}'; expected one line for each id")


def _lines(source: str | Path) -> Iterator[tuple[int, str]]:
    try:
        text = Path(source).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"Description file '{source}' cannot be read: {error}") from error
    for number, line in enumerate(text.split("\n"), start=1):
        if line.strip():
            yield number, line


def _parse(line: str) -> Record:
    try:
        data = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise Fault("line", f"is not JSON: {error}") from error
    if not isinstance(data, dict):
        raise Fault("line", f"is a {type(data).__name__}; expected a JSON object")
    return Record(data)


def _annotated(record: Record, find: FindMap) -> AnnotatedDescription:
    description_id, text = record.text("id"), record.text("text")
    name = record.text("map")
    try:
        city = find(name)
    except SloopError as error:
        raise Fault("map", f"names no map that can be used: {error}") from error
    targets = {n: _place(p, city.grid) for n, p in record.members("targets")}
    try:
        viewpoint = check_viewpoint(record.text("viewpoint", "map"))
    except SloopError as error:
        raise record.fault("viewpoint", f"is none: {error}") from error
    gold = _relations(record.entries("relations"), targets, city)
    return AnnotatedDescription(
        id=description_id,
        map=name,
        configuration=record.text("configuration", description_id),
        text=text,
        targets=targets,
        relations=Description(text, name, (), gold, viewpoint=viewpoint).relations,
        speaker=record.optional_text("speaker"),
        frames=tuple(_frame(e, city) for e in record.entries("frames", required=False)),
        viewpoint=viewpoint,
        hearer=_hearer(record),
        area_m=_area(record, city.grid),
    )


def _hearer(record: Record) -> tuple[float, float] | None:
    """Return where who listens was, which is checked to be two finite numbers, nothing else."""
    place = record.optional_record("hearer")
    return None if place is None else (place.number("east_m"), place.number("north_m"))


def _area(record: Record, grid: Grid) -> tuple[float, float, float, float] | None:
    """Return the borders of the area that is searched, some of which is on the map."""
    borders = record.optional_numbers("area_m", 4)
    if borders is None:
        return None
    west, south, east, north = borders
    if not (west < east and south < north):
        raise record.fault(
            "area_m", f"is {list(borders)}; expected west < east and south < north, metres"
        )
    inside = (
        west <= grid.east_m,
        grid.west_m <= east,
        south <= grid.north_m,
        grid.south_m <= north,
    )
    if not all(inside):
        raise record.fault("area_m", f"is {list(borders)}, none of which is on the map")
    return west, south, east, north


def _place(record: Record, grid: Grid) -> Place:
    x, y = record.number("east_m"), record.number("north_m")
    try:
        cell = grid.cell_at(x, y)
    except SloopError as error:
        raise Fault(record.path.rstrip("."), f"is not on the map: {error}") from error
    if "lonlat" in record:
        near_x, near_y = grid.from_lonlat(*record.pair("lonlat"))
        # Written so that a coordinate which does not project (nan, inf) is a fault.
        if not max(abs(near_x - x), abs(near_y - y)) <= _LONLAT_SLACK_M:
            raise record.fault(
                "lonlat",
                f"is ({float(near_x):.1f}, {float(near_y):.1f}) m on this map; expected the place "
                f"that 'east_m' and 'north_m' give, ({x:g}, {y:g})",
            )
    counted = Grid(*grid.extent_m, cell_m=_COUNTED_CELL_M)
    row, col = counted.cell_at(x, y)
    for name, expected in (("col_from_west", col), ("row_from_north", counted.row_from_north(row))):
        if name in record and record.number(name) != expected:
            raise record.fault(
                name,
                f"is {record.number(name):g}; expected {expected}, the 5 m cell at ({x:g}, {y:g})",
            )
    return Place(x, y, cell)


def _relations(
    entries: Iterable[Record], targets: Mapping[str, Place], city: CityMap
) -> tuple[SpatialRelation, ...]:
    """Merge the entries of each group; a merged relation stands where its first entry stood."""
    merged: dict[object, SpatialRelation] = {}
    known = {*targets, *(() if targets else (target.id for target in DEFAULT_TARGETS))}
    for index, entry in enumerate(entries):
        figure, word = entry.text("figure"), entry.text("relation")
        if targets and figure not in targets:
            raise entry.fault("figure", f"is '{figure}'; expected one of {', '.join(targets)}")
        ground, negated = _ground(entry, city, known), entry.flag("negated")
        try:
            relation = SpatialRelation(figure, word, (ground,), negated)
        except SloopError as error:
            raise entry.fault("relation", f"is '{word}': {error}") from error
        group = entry.group()
        key: object = ("group", group)
        if group is None:
            several = RELATIONS[word].grounds == "several"
            key = (word, figure, negated) if several else ("alone", index)
        first = merged.setdefault(key, relation)
        if (first.figure, first.relation, first.negated) != (figure, word, negated):
            raise entry.fault(
                "group",
                f"is {group!r}, which holds '{first.figure} {first.relation}'; expected the same "
                "figure, relation and negation throughout a group",
            )
        if ground not in first.grounds:
            merged[key] = SpatialRelation(figure, word, (*first.grounds, ground), negated)
    return tuple(merged.values())


def _ground(entry: Record, city: CityMap, targets: Container[str] = ()) -> str:
    """Return the id of a ground: the map, who listens, a landmark, or another target."""
    ground = entry.text("ground")
    if ground in (WHOLE_MAP, HEARER) or (ground in targets and ground not in city):
        return ground
    try:
        return city.landmark(ground).id
    except SloopError as error:
        raise entry.fault("ground", f"is not on the map: {error}") from error


def _frame(entry: Record, city: CityMap) -> FrameAnnotation:
    return FrameAnnotation(
        _ground(entry, city),
        entry.text("relation"),
        entry.number("front_deg"),
        entry.optional_text("annotator"),
    )
