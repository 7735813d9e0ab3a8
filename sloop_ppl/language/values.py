"""What a description says, as frozen values: targets, relations, and what was not understood."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal, TypeAlias, cast, get_args

from sloop_ppl.errors import DescriptionError, UnknownName
from sloop_ppl.language.relations import RELATIONS, WHOLE_MAP

__all__ = [
    "Description",
    "RelationSpans",
    "SpatialRelation",
    "TargetObject",
    "Unresolved",
    "Viewpoint",
    "check_viewpoint",
]

Span = tuple[int, int]

Viewpoint: TypeAlias = Literal["map", "ground"]
"""Where who speaks looks from: at a map from above, or at a city from the ground in it."""


@dataclass(frozen=True)
class TargetObject:
    """Something that is searched for.

    Parameters
    ----------
    id
        CamelCase symbol, such as ``"GreenToyota"``.
    names
        What people call it, such as ``("green toyota", "green car")``.
    colour
        Its colour, if it has a telling one.
    kind
        What sort of thing it is, such as ``"car"``.
    """

    id: str
    names: tuple[str, ...] = ()
    colour: str | None = None
    kind: str | None = None


@dataclass(frozen=True)
class RelationSpans:
    """Where in the text a relation was read: half-open character ranges."""

    figure: Span
    relation: Span
    grounds: tuple[Span, ...]


@dataclass(frozen=True)
class SpatialRelation:
    """One figure in one relation to one or several grounds.

    Parameters
    ----------
    figure
        Id of the target that is located.
    relation
        Canonical relation word.
    grounds
        Ids of the landmarks it is located by, at least one; several for "between A and B" and "at
        the corner of A and B".
    negated
        True for "not behind the bank".
    distance_m
        The distance that was said, metres, or None.
    confidence
        How sure the parser is, in [0, 1].
    spans
        Where it was read; None when it was not read from text.
    each
        True when it holds of each ground by itself: "not near a bank" denies every bank.

    Raises
    ------
    UnknownName
        When `relation` is not a canonical word.
    DescriptionError
        When `grounds` is empty.
    """

    figure: str
    relation: str
    grounds: tuple[str, ...]
    negated: bool = False
    distance_m: float | None = None
    confidence: float = 1.0
    spans: RelationSpans | None = None
    each: bool = False

    def __post_init__(self) -> None:
        if self.relation not in RELATIONS:
            raise UnknownName("relation", self.relation, RELATIONS)
        if not self.grounds:
            raise DescriptionError(
                f"Relation '{self.relation}' of '{self.figure}' has no ground; "
                "expected at least one"
            )

    @property
    def ground(self) -> str:
        """The first (for most relations the only) ground."""
        return self.grounds[0]


@dataclass(frozen=True)
class Unresolved:
    """A name or a cue that found no home.

    Parameters
    ----------
    text
        The words.
    span
        Where they stand, half-open character range.
    candidates
        Ids of the landmarks that come nearest, best first.
    """

    text: str
    span: Span
    candidates: tuple[str, ...] = ()


@dataclass(frozen=True)
class Description:
    """What one text says about where targets are on one map.

    Parameters
    ----------
    text
        The words.
    map
        Name of the map its grounds are on.
    targets
        The objects it speaks of.
    relations
        What it says about them.
    unresolved
        What was not understood.
    speaker
        Who says it; None for a person of whom nothing else is known. What one speaker says in
        several texts is one longer description; several speakers are independent.
    viewpoint
        ``"map"`` for who looks at a map, whose up is north, as all did in the paper; ``"ground"``
        for who stands in the city. Then up, down, above, below, under and top are no compass words:
        each relation is put as what it means there (`Relation.from_ground` of its record), so that
        "under the bridge" is at it and "up the street" near it, in no direction that is known.
        Sides of the map itself ("the top of the map") stay what they are.

    Raises
    ------
    UnknownName
        For another viewpoint.
    """

    text: str
    map: str
    targets: tuple[TargetObject, ...]
    relations: tuple[SpatialRelation, ...]
    unresolved: tuple[Unresolved, ...] = ()
    speaker: str | None = None
    viewpoint: Viewpoint = "map"

    def __post_init__(self) -> None:
        check_viewpoint(self.viewpoint)
        if self.viewpoint == "ground":
            seen = tuple(_from_ground(relation) for relation in self.relations)
            object.__setattr__(self, "relations", seen)

    def about(self, target_id: str) -> tuple[SpatialRelation, ...]:
        """Return the relations whose figure is this target, in the order they were said."""
        return tuple(r for r in self.relations if r.figure == target_id)

    def to_json(self) -> dict[str, Any]:
        """Return the value that ``sloop parse --json`` prints: one relation entry per ground."""
        return {
            "text": self.text,
            "map": self.map,
            "targets": [t.id for t in self.targets],
            "relations": _entries(self.relations),
            "unresolved": [
                {"text": u.text, "span": list(u.span), "candidates": list(u.candidates)}
                for u in self.unresolved
            ],
        }


def check_viewpoint(name: str) -> Viewpoint:
    """Return a name as a viewpoint.

    Raises
    ------
    UnknownName
        When it is none.
    """
    if name not in get_args(Viewpoint):
        raise UnknownName("viewpoint", name, get_args(Viewpoint))
    return cast(Viewpoint, name)


def _from_ground(relation: SpatialRelation) -> SpatialRelation:
    """Return a relation as who stands on the ground means it."""
    counterpart = RELATIONS[relation.relation].from_ground
    if counterpart is None or WHOLE_MAP in relation.grounds:
        return relation
    return replace(relation, relation=counterpart)


def _entries(relations: tuple[SpatialRelation, ...]) -> list[dict[str, Any]]:
    """Return one entry per ground; the entries of one relation share a `group` number."""
    entries: list[dict[str, Any]] = []
    groups = 0
    for relation in relations:
        group = None
        if len(relation.grounds) > 1:
            group, groups = groups, groups + 1
        for i, ground in enumerate(relation.grounds):
            spans = relation.spans
            entries.append(
                {
                    "figure": relation.figure,
                    "relation": relation.relation,
                    "ground": ground,
                    "group": group,
                    "negated": relation.negated,
                    "distance_m": relation.distance_m,
                    "spans": None
                    if spans is None
                    else {
                        "figure": list(spans.figure),
                        "relation": list(spans.relation),
                        "ground": list(spans.grounds[i]),
                    },
                    "confidence": relation.confidence,
                }
            )
    return entries
