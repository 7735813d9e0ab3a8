"""Read description files: what people said about placements of objects, with the truth."""

from __future__ import annotations

import functools
import os
from collections import Counter
from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from importlib.resources import files
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl._foreign import ForeignFault, parse_json, read_text
from sloop_ppl.errors import InputError, SloopError
from sloop_ppl.eval._cities import cities_of
from sloop_ppl.eval._gold import GoldEntry, entries_of, gold_entries, gold_relations
from sloop_ppl.eval._line_format import (
    AnnotationLine,
    Fault,
    FrameLine,
    HearerLine,
    Line,
    ObjectLine,
    PlaceLine,
    checked,
)
from sloop_ppl.eval._objects import declared_object
from sloop_ppl.language import (
    NOT_ON_MAP,
    WHOLE_MAP,
    Description,
    SpatialRelation,
    TargetObject,
    Viewpoint,
    check_viewpoint,
)
from sloop_ppl.maps import CityMap, Grid, SearchArea, load_map, search_area
from sloop_ppl.maps._given_point import are_degrees_of

__all__ = [
    "AnnotatedDescription",
    "FrameAnnotation",
    "Place",
    "bundled_examples",
    "read_descriptions",
    "read_sound_descriptions",
    "read_to_score",
]

FindMap = Callable[[str], CityMap]

# The grid that `col_from_west` and `row_from_north` count on, whatever the map's own cells are.
_COUNTED_CELL_M = 5.0
# How far `lonlat`, rounded to seven decimals, may lie from `east_m` and `north_m`.
_LONLAT_SLACK_M = 0.5
# How far a target may lie outside the area that is searched for it, which may be rounded too.
_AREA_SLACK_M = 0.5


@dataclass(frozen=True)
class Place:
    """Where a target truly is.

    Parameters
    ----------
    x_m, y_m
        Metres east and north of the map's centre.
    cell
        Its row (row 0 in the south) and column on the map's grid.
    area
        True for the cells that are searched for it, shape (H, W); None for all.
    """

    x_m: float
    y_m: float
    cell: tuple[int, int]
    area: NDArray[np.bool_] | None = field(default=None, compare=False, repr=False)

    def within(self, area: SearchArea, grid: Grid) -> Place:
        """Return the place as one of an area: in the nearest cell of it.

        A place by the border may lie in a cell whose centre is outside, which the area has not.
        """
        if area.cells[self.cell]:
            return replace(self, area=area.cells)
        apart = np.hypot(grid.x_m[None, :] - self.x_m, grid.y_m[:, None] - self.y_m)
        row, col = np.unravel_index(np.argmin(np.where(area.cells, apart, np.inf)), grid.shape)
        return replace(self, cell=(int(row), int(col)), area=area.cells)


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
    has_gold
        False when no one has annotated it: then nothing is known of what it says, and what is read
        in it can be scored by places alone.
    entries
        The gold with its alternatives, of which `relations` is what reaches a model; what
        `relations` says when there are none.
    phenomena
        What is peculiar in the text, such as ``"negation"``; scores are grouped by it.
    declared
        Objects that the line describes; those of `targets` without a description are described by
        their ids.
    source
        Name of the file it was read from, without its ending; empty for one made otherwise.
    city
        Name of the city that is left out with it in cross-validation: that of the map, or, where
        maps were cut from one city, of the file that all of them are in, else of the first of them.
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
    has_gold: bool = True
    entries: tuple[GoldEntry, ...] = ()
    phenomena: tuple[str, ...] = ()
    declared: tuple[TargetObject, ...] = ()
    source: str = field(default="", compare=False)
    city: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        if not self.city:
            object.__setattr__(self, "city", self.map)
        object.__setattr__(self, "targets", MappingProxyType(dict(self.targets)))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by value; a view of a mapping cannot be pickled."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        return AnnotatedDescription, (*({**values, "targets": dict(self.targets)}.values()),)

    @property
    def objects(self) -> tuple[TargetObject, ...]:
        """The declared objects in file order; empty means the default ones."""
        described = {target.id: target for target in self.declared}
        names = dict.fromkeys((*self.targets, *described))
        return tuple(described.get(name) or declared_object(name) for name in names)

    @property
    def gold(self) -> tuple[GoldEntry, ...]:
        """What a reader is scored against."""
        return self.entries or entries_of(self.relations)

    def search_area(self, grid: Grid) -> SearchArea | None:
        """Return the area that is searched, on the map's grid; None for the map."""
        return None if self.area_m is None else search_area(self.area_m, grid)

    def places(self, grid: Grid) -> dict[str, Place]:
        """Return where each target is, as a place of the area that is searched."""
        area = self.search_area(grid)
        return {
            target: place if area is None else place.within(area, grid)
            for target, place in self.targets.items()
        }

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
    paths: str | Path | Iterable[str | Path],
    find_map: FindMap | None = None,
    annotations: str | Path | Sequence[str | Path] | None = None,
) -> tuple[AnnotatedDescription, ...]:
    """Read one or several description files.

    Parameters
    ----------
    paths
        ``.jsonl`` files, one JSON object a line; blank lines are passed over.
    find_map
        Gives the map of a line by the name in its field ``map``; bundled names and paths when None.
    annotations
        A ``.jsonl`` file of ``id`` and ``relations``, or several: the gold of the lines with these
        ids, in place of any they have.

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
    descriptions, faults = read_sound_descriptions(paths, find_map, annotations)
    if faults:
        raise InputError("; ".join(faults))
    return descriptions


def read_sound_descriptions(
    paths: str | Path | Iterable[str | Path],
    find_map: FindMap | None = None,
    annotations: str | Path | Sequence[str | Path] | None = None,
) -> tuple[tuple[AnnotatedDescription, ...], tuple[str, ...]]:
    """Return the lines of description files that follow the format, and the faults of the others.

    Parameters
    ----------
    paths, find_map, annotations
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
    faults: list[str] = []
    notes: dict[str, dict[str, Any]] = {}
    for file in () if annotations is None else annotation_files(annotations):
        _read_annotations(file, notes, faults)
    names = _source_names(sources)
    descriptions: dict[str, AnnotatedDescription] = {}
    for source in sources:
        before = len(descriptions), len(faults)
        for number, line in _lines(source):
            try:
                data = _parse(line)
                note = notes.get(str(data.get("id")))
                annotated = _annotated(data if note is None else {**data, **note}, find)
                annotated = replace(annotated, source=names[source])
                _check_new(annotated.id, descriptions)
                descriptions[annotated.id] = annotated
            except Fault as fault:
                faults.append(f"{source}:{number}: field '{fault.field}' {fault.what}")
        if before == (len(descriptions), len(faults)):
            faults.append(f"{source} holds no description; expected one JSON object a line")
    if notes and not faults and not notes.keys() & descriptions.keys():
        faults.append(
            f"{', '.join(map(str, annotation_files(annotations or [])))} holds the ids of none of "
            f"these lines, but such as '{next(iter(notes))}'"
        )
    return _with_cities(descriptions.values(), find), tuple(faults)


def read_to_score(
    files: Sequence[str | Path],
    learn_from: Sequence[str | Path],
    find_map: FindMap | None = None,
    annotations: str | Path | Sequence[str | Path] | None = None,
) -> tuple[tuple[AnnotatedDescription, ...], tuple[AnnotatedDescription, ...], tuple[str, ...]]:
    """Return the lines of some files, those of files to learn from, and the faults of all.

    Parameters
    ----------
    files
        What is scored.
    learn_from
        What a fit may learn from beside it; files that are scored too count once.
    find_map, annotations
        As in `read_descriptions`; annotations may be of lines of either.
    """
    scored = {os.path.realpath(file) for file in files}
    others = [file for file in learn_from if os.path.realpath(file) not in scored]
    names = _source_names([*files, *others])
    found, faults = read_sound_descriptions([*files, *others], find_map, annotations)
    own = {names[file] for file in files}
    return (
        tuple(one for one in found if one.source in own),
        tuple(one for one in found if one.source not in own),
        faults,
    )


def _with_cities(
    descriptions: Collection[AnnotatedDescription], find: FindMap
) -> tuple[AnnotatedDescription, ...]:
    """Return lines that know their cities."""
    sources: dict[str, set[str]] = {}
    for one in descriptions:
        sources.setdefault(one.map, set()).add(one.source)
    cities = cities_of(sources, {name: find(name).grid.centre for name in sources})
    return tuple(replace(one, city=cities[one.map]) for one in descriptions)


def _source_names(sources: Iterable[str | Path]) -> dict[str | Path, str]:
    """Return file -> its name without the ending, with its folder where two have one name."""
    stems = {source: Path(source).stem for source in sources}
    shared = {stem for stem, count in Counter(stems.values()).items() if count > 1}
    return {
        source: str(Path(source).with_suffix("")) if stem in shared else stem
        for source, stem in stems.items()
    }


def bundled_examples() -> tuple[AnnotatedDescription, ...]:
    """Return the example descriptions of the bundled cities that ship with the package.

    Examples
    --------
    >>> examples = bundled_examples()
    >>> len(examples), examples[0].map
    (32, 'austin')
    """
    return read_descriptions(Path(str(files("sloop_ppl"))) / "data" / "examples.jsonl")


def _check_new(description_id: str, known: Container[str]) -> None:
    if description_id in known:
        raise Fault("id", f"repeats '{description_id}'; expected one line for each id")


def annotation_files(
    annotations: str | Path | Sequence[str | Path],
) -> tuple[str | Path, ...]:
    """Return the files of annotations that are given as one path or as several."""
    return (annotations,) if isinstance(annotations, str | Path) else tuple(annotations)


def _read_annotations(
    source: str | Path, found: dict[str, dict[str, Any]], faults: list[str]
) -> None:
    """Add id -> the fields that a file of annotations gives a line, and its faults."""
    before = len(found), len(faults)
    for number, line in _lines(source):
        try:
            data = _parse(line)
            known = checked(data, AnnotationLine)
            _check_new(known.id, found)
            found[known.id] = {"relations": data["relations"]}
        except Fault as fault:
            faults.append(f"{source}:{number}: field '{fault.field}' {fault.what}")
    if before == (len(found), len(faults)):
        faults.append(f"{source} holds no annotation; expected one JSON object a line")


def _lines(source: str | Path) -> Iterator[tuple[int, str]]:
    text = read_text(source, "Description file")
    for number, line in enumerate(text.split("\n"), start=1):
        if line.strip():
            yield number, line


def _parse(line: str) -> dict[str, Any]:
    try:
        data = parse_json(line, finite=False)
    except ForeignFault as error:
        raise Fault("line", f"is not JSON: {error}") from error
    if not isinstance(data, dict):
        raise Fault("line", f"is a {type(data).__name__}; expected a JSON object")
    return data


def _annotated(data: Mapping[str, Any], find: FindMap) -> AnnotatedDescription:
    line = checked(data, Line)
    try:
        city = find(line.map)
    except SloopError as error:
        raise Fault("map", f"names no map that can be used: {error}") from error
    targets = {
        name: _place(checked(place, PlaceLine, f"targets.{name}"), f"targets.{name}", city.grid)
        for name, place in (line.targets or {}).items()
    }
    try:
        viewpoint = check_viewpoint(line.viewpoint)
    except SloopError as error:
        raise Fault("viewpoint", f"is none: {error}") from error
    declared = _declared(line.objects or [])
    figures = dict.fromkeys((*targets, *(target.id for target in declared)))
    gold = gold_entries(line.relations or [], figures, city)
    return AnnotatedDescription(
        id=line.id,
        map=line.map,
        configuration=line.configuration or line.id,
        text=line.text,
        targets=targets,
        relations=_as_meant(gold_relations(gold), viewpoint),
        speaker=line.speaker,
        frames=tuple(_frame(f, f"frames[{i}]", city) for i, f in enumerate(line.frames or [])),
        viewpoint=viewpoint,
        has_gold=line.relations is not None,
        entries=_entries_as_meant(gold, viewpoint),
        phenomena=tuple(line.phenomena),
        declared=declared,
        area_m=_area(line, city.grid, targets),
        hearer=None if line.hearer is None else _point(line.hearer, "hearer", city.grid),
    )


def _as_meant(
    relations: tuple[SpatialRelation, ...], viewpoint: Viewpoint
) -> tuple[SpatialRelation, ...]:
    """Return relations as who looks from there means them."""
    return Description("", "", (), relations, viewpoint=viewpoint).relations


def _entries_as_meant(
    entries: tuple[GoldEntry, ...], viewpoint: Viewpoint
) -> tuple[GoldEntry, ...]:
    alone = tuple(
        SpatialRelation(
            entry.figure, entry.relation, (entry.ground or NOT_ON_MAP,), part=entry.part
        )
        for entry in entries
    )
    return tuple(
        replace(entry, relation=meant.relation, part=meant.part)
        for entry, meant in zip(entries, _as_meant(alone, viewpoint), strict=True)
    )


def _declared(objects: Iterable[ObjectLine]) -> tuple[TargetObject, ...]:
    found: dict[str, TargetObject] = {}
    for index, one in enumerate(objects):
        if one.id in found:
            raise Fault(f"objects[{index}].id", f"repeats '{one.id}'; expected each object once")
        names = tuple(one.names) or declared_object(one.id).names
        found[one.id] = TargetObject(one.id, names, one.colour, one.kind)
    return tuple(found.values())


def _area(
    line: Line, grid: Grid, targets: Mapping[str, Place]
) -> tuple[float, float, float, float] | None:
    """Return the borders of the area that is searched, some of which is on the map."""
    borders = line.area_m
    if borders is None:
        return None
    west, south, east, north = borders
    if not (west < east and south < north):
        raise Fault("area_m", f"is {list(borders)}; expected west < east and south < north, metres")
    inside = (
        west <= grid.east_m,
        grid.west_m <= east,
        south <= grid.north_m,
        grid.south_m <= north,
    )
    if not all(inside):
        raise Fault("area_m", f"is {list(borders)}, none of which is on the map")
    try:
        search_area(borders, grid)
    except SloopError as error:
        raise Fault("area_m", f"is {list(borders)}, which cannot be searched: {error}") from error
    for name, place in targets.items():
        off = max(west - place.x_m, place.x_m - east, south - place.y_m, place.y_m - north)
        if off > _AREA_SLACK_M:
            raise Fault(
                f"targets.{name}",
                f"is at ({place.x_m:g}, {place.y_m:g}); expected a place in 'area_m', "
                f"{list(borders)}",
            )
    return west, south, east, north


def _point(line: PlaceLine | HearerLine, path: str, grid: Grid) -> tuple[float, float]:
    """Return x and y, metres, of a place that is given in metres, in degrees or in both."""
    x, y = line.east_m, line.north_m
    degrees = None if line.lonlat is None else _metres_of(line.lonlat, path, grid)
    if degrees is not None and x is None and y is None:
        return degrees
    if x is None or y is None:
        lacking = "east_m" if x is None else "north_m"
        raise Fault(f"{path}.{lacking}", "is missing; expected a finite number, or 'lonlat' alone")
    # Written so that a coordinate which does not project (nan, inf) is a fault.
    if degrees and not max(abs(degrees[0] - x), abs(degrees[1] - y)) <= _LONLAT_SLACK_M:
        raise Fault(
            f"{path}.lonlat",
            f"is ({degrees[0]:.1f}, {degrees[1]:.1f}) m on this map; expected the place "
            f"that 'east_m' and 'north_m' give, ({x:g}, {y:g})",
        )
    if degrees is None and are_degrees_of(grid, x, y):
        raise Fault(
            path,
            f"has east_m {x:.10g} and north_m {y:.10g}, which are degrees of this map; expected "
            "metres from its centre, or 'lonlat': [longitude, latitude]",
        )
    return x, y


def _metres_of(lonlat: tuple[float, float], path: str, grid: Grid) -> tuple[float, float]:
    lon, lat = lonlat
    try:
        x, y = grid.from_lonlat(lon, lat)
    except SloopError as error:
        raise Fault(f"{path}.lonlat", f"cannot be placed: {error}") from error
    return float(x), float(y)


def _place(line: PlaceLine, path: str, grid: Grid) -> Place:
    x, y = _point(line, path, grid)
    try:
        cell = grid.cell_at(x, y)
    except SloopError as error:
        if line.lonlat is not None and grid.contains(*_metres_of(line.lonlat[::-1], path, grid)):
            raise Fault(
                f"{path}.lonlat", f"is {list(line.lonlat)}; expected longitude, then latitude"
            ) from error
        raise Fault(path, f"is not on the map: {error}") from error
    counted = Grid(*grid.extent_m, cell_m=_COUNTED_CELL_M)
    row, col = counted.cell_at(x, y)
    for name, found, expected in (
        ("col_from_west", line.col_from_west, col),
        ("row_from_north", line.row_from_north, counted.row_from_north(row)),
    ):
        if found is not None and found != expected:
            raise Fault(
                f"{path}.{name}",
                f"is {found:g}; expected {expected}, the 5 m cell at ({x:g}, {y:g})",
            )
    return Place(x, y, cell)


def _frame(line: FrameLine, path: str, city: CityMap) -> FrameAnnotation:
    try:
        ground = line.ground if line.ground == WHOLE_MAP else city.landmark(line.ground).id
    except SloopError as error:
        raise Fault(f"{path}.ground", f"is not on the map: {error}") from error
    return FrameAnnotation(ground, line.relation, line.front_deg, line.annotator)
