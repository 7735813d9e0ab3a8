"""Gold relations as annotators write them: what is said, may be said, and must not be read."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import cast

from sloop_ppl.errors import SloopError
from sloop_ppl.eval._line_format import EntryLine, Fault, GoldStatus, GroundClass
from sloop_ppl.language import (
    DEFAULT_TARGETS,
    HEARER,
    RELATIONS,
    SPEAKER,
    WHOLE_MAP,
    Candidate,
    Distance,
    SpatialRelation,
    StreetPart,
)
from sloop_ppl.language.street_parts import StreetPartKind
from sloop_ppl.maps import CityMap

__all__ = ["READ_STATUSES", "GoldEntry", "entries_of", "gold_entries", "gold_relations"]

READ_STATUSES = ("asserted", "denied", "alternative")
"""Statuses of what a reader is to read; the others say nothing of where a target is."""


@dataclass(frozen=True)
class GoldEntry:
    """One figure in one relation to one ground, with what else would be as good a reading.

    Parameters
    ----------
    figure
        Id of the target that is located.
    relation
        Canonical relation word.
    ground
        Id of the landmark, or of another ground; None for a place that has no id, see `kind`.
    negated
        True for what is denied.
    group
        Shared by the entries of one relation with several grounds.
    also
        Other grounds that would be as good a reading.
    kind
        Words for a ground that is not named ("school").
    optional
        True for what a careful reader may leave out.
    status
        One of `READ_STATUSES` for what is to be read. What is asked, retracted, past or else must
        not be.
    either
        Group and branch of an alternative, as in :class:`sloop_ppl.language.SpatialRelation`.
    distance
        The distance that was said.
    ground_class
        What the ground is given by; annotations of meeting points have it.
    part
        Which part of its ground is meant, such as the north side of a street; None when the
        annotator does not say.
    """

    figure: str
    relation: str
    ground: str | None
    negated: bool = False
    group: int | str | None = None
    also: tuple[str, ...] = ()
    kind: str | None = None
    optional: bool = False
    status: GoldStatus = "asserted"
    either: tuple[int, int] | None = None
    distance: Distance | None = None
    ground_class: GroundClass | None = None
    part: StreetPart | None = None

    @property
    def is_read(self) -> bool:
        """Whether it is to be read."""
        return self.status in READ_STATUSES

    @property
    def accepted(self) -> frozenset[str]:
        """Ids of the grounds that are right."""
        return frozenset(self.also if self.ground is None else (self.ground, *self.also))


def gold_entries(
    lines: Sequence[EntryLine], figures: Collection[str] = (), city: CityMap | None = None
) -> tuple[GoldEntry, ...]:
    """Check the entries of a line against its objects and its map.

    Parameters
    ----------
    lines
        The entries, as they were read.
    figures
        Ids of the objects of the line; when there are none, any may be spoken of.
    city
        The map; None when the ids of grounds are taken as they are.

    Raises
    ------
    Fault
        For the first entry whose figure, relation, ground, status or distance cannot be.
    """
    return tuple(
        _entry(line, f"relations[{index}].", figures, city) for index, line in enumerate(lines)
    )


def _entry(line: EntryLine, path: str, figures: Collection[str], city: CityMap | None) -> GoldEntry:
    if figures and line.figure not in figures and line.figure != SPEAKER:
        raise Fault(
            f"{path}figure", f"is '{line.figure}'; expected one of {', '.join(sorted(figures))}"
        )
    if line.ground is None and not line.kind:
        raise Fault(
            f"{path}ground", "is missing; expected an id, or a 'kind' of place that has none"
        )
    targets = figures or tuple(target.id for target in DEFAULT_TARGETS)
    known = {WHOLE_MAP, HEARER, SPEAKER, *(name for name in targets if _is_free(name, city))}

    def check(ground: str, name: str) -> str:
        try:
            return ground if city is None or ground in known else city.landmark(ground).id
        except SloopError as error:
            raise Fault(f"{path}{name}", f"is not on the map: {error}") from error

    try:
        ground = None if line.ground is None else check(line.ground, "ground")
        also = tuple(check(one, f"also[{i}]") for i, one in enumerate(line.also))
        SpatialRelation(line.figure, line.relation, ("",))
    except SloopError as error:
        raise Fault(f"{path}relation", f"is '{line.relation}': {error}") from error
    status = _status(line, path)
    return GoldEntry(
        line.figure,
        line.relation,
        ground,
        line.negated or status == "denied",
        line.group,
        also,
        line.kind,
        line.optional,
        status,
        line.either,
        _distance(line, path),
        line.ground_class,
        _part(line, path),
    )


def _is_free(name: str, city: CityMap | None) -> bool:
    """Tell whether an id is none of a landmark, which would come first as a ground."""
    return city is None or name not in city


def _status(line: EntryLine, path: str) -> GoldStatus:
    if line.status is None:
        return "alternative" if line.either else "denied" if line.negated else "asserted"
    if line.status == "asserted" and line.negated:
        raise Fault(f"{path}status", "is 'asserted' of what is negated; expected 'denied'")
    if line.either and line.status != "alternative":
        raise Fault(
            f"{path}status", f"is '{line.status}' of one of several; expected 'alternative'"
        )
    return line.status


def _distance(line: EntryLine, path: str) -> Distance | None:
    stated = line.distance_m
    if stated is None:
        return None
    low, high = (stated, stated) if isinstance(stated, int | float) else stated
    try:
        return Distance(low or 0.0, math.inf if high is None else high)
    except SloopError as error:
        raise Fault(f"{path}distance_m", f"is {stated!r}: {error}") from error


def _part(line: EntryLine, path: str) -> StreetPart | None:
    given = line.part
    if given is None:
        return None
    bearing_rad = None if given.bearing_deg is None else math.radians(given.bearing_deg)
    try:
        return StreetPart(cast(StreetPartKind, given.kind), bearing_rad, given.number)
    except SloopError as error:
        raise Fault(f"{path}part", f"cannot be: {error}") from error


def entries_of(relations: Iterable[SpatialRelation]) -> tuple[GoldEntry, ...]:
    """Return relations as gold, one entry per ground: all are to be read, and nothing else."""
    return tuple(
        GoldEntry(
            relation.figure,
            relation.relation,
            ground,
            relation.negated,
            None if len(relation.grounds) == 1 else index,
            status="alternative"
            if relation.either
            else "denied"
            if relation.negated
            else "asserted",
            either=relation.either,
            distance=relation.distance,
            part=relation.part,
        )
        for index, relation in enumerate(relations)
        for ground in relation.grounds
    )


def gold_relations(entries: Sequence[GoldEntry]) -> tuple[SpatialRelation, ...]:
    """Merge the entries of each group; a merged relation stands where its first entry stood.

    Parameters
    ----------
    entries
        Those of one line.

    Returns
    -------
    tuple of SpatialRelation
        What is asserted, denied or an alternative of places that have an id. Alternatives that do
        not say so are each a branch of one group.

    Raises
    ------
    Fault
        When the entries of a group differ in figure, relation, negation or status.
    """
    merged: dict[object, SpatialRelation] = {}
    first: dict[object, GoldEntry] = {}
    nowhere: set[object] = set()
    branches: dict[str, dict[object, int]] = {}
    for index, entry in enumerate(entries):
        key = _group_key(entry, index)
        shared = first.setdefault(key, entry)
        if _alike(shared) != _alike(entry):
            raise Fault(
                f"relations[{index}].group",
                f"is {entry.group!r}, which holds '{shared.figure} {shared.relation}'; expected "
                "the same figure, relation and negation throughout a group",
            )
        if not entry.is_read:
            continue
        if entry.ground is None:  # no belief can be made of it
            nowhere.add(key)
            continue
        either = entry.either
        if entry.status == "alternative" and either is None:
            either = _branch(branches, entry.figure, key)
        known = merged.get(key)
        if known is None:
            merged[key] = SpatialRelation(
                entry.figure,
                entry.relation,
                (entry.ground,),
                entry.negated,
                distance=entry.distance,
                either=either,
                candidates=(_candidates(entry),),
                part=entry.part,
            )
        elif entry.part not in (None, known.part):
            raise Fault(
                f"relations[{index}].part",
                f"is not that of '{shared.figure} {shared.relation}'; expected one part throughout "
                "a group, given in its first entry",
            )
        elif entry.ground not in known.grounds:
            merged[key] = replace(
                known,
                grounds=(*known.grounds, entry.ground),
                candidates=(*known.candidates, _candidates(entry)),
            )
    return tuple(_certain(one) for key, one in merged.items() if key not in nowhere)


def _candidates(entry: GoldEntry) -> tuple[Candidate, ...]:
    """Return the places that an entry accepts, each as likely: annotators took either."""
    places = dict.fromkeys((entry.ground, *entry.also))
    return tuple(Candidate(place, 1 / len(places)) for place in places)


def _certain(relation: SpatialRelation) -> SpatialRelation:
    """Return a relation without candidates where each ground is one place for certain."""
    return replace(relation, candidates=()) if relation.is_certain else relation


def _branch(branches: dict[str, dict[object, int]], figure: str, key: object) -> tuple[int, int]:
    """Return the group of a figure's alternatives (below 0, so that none is met) and the branch."""
    number = list(branches).index(figure) if figure in branches else len(branches)
    known = branches.setdefault(figure, {})
    return -1 - number, known.setdefault(key, len(known))


def _alike(entry: GoldEntry) -> tuple[object, ...]:
    return entry.figure, entry.relation, entry.negated, entry.status


def _group_key(entry: GoldEntry, index: int) -> object:
    """Return what the entries of one relation share; nothing is between one thing."""
    if entry.group is not None:
        return "group", entry.group
    if RELATIONS[entry.relation].grounds == "several":
        return (entry.either, *_alike(entry))
    return "alone", index
