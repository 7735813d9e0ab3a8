"""What a description says, as frozen values: targets, relations, and what was not understood."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from numbers import Real
from typing import Any, Literal, TypeAlias, cast, get_args

from sloop_ppl.errors import DescriptionError, UnknownName
from sloop_ppl.language.relations import RELATIONS, WHOLE_MAP
from sloop_ppl.language.street_parts import StreetPart

__all__ = [
    "HEARER",
    "NOT_ON_MAP",
    "SPEAKER",
    "Candidate",
    "Description",
    "Distance",
    "Reading",
    "RelationSpans",
    "SpatialRelation",
    "Status",
    "TargetObject",
    "Unresolved",
    "Viewpoint",
    "check_viewpoint",
]

Span = tuple[int, int]

HEARER = "Hearer"
"""Id of the place of who listens, as a ground ("north of you")."""

SPEAKER = "Me"
"""Id of the target that who speaks is ("I'm at the bank")."""

NOT_ON_MAP = "NotOnMap"
"""Ground of a relation none of whose candidates is on the map; ``null`` in JSON."""

Status: TypeAlias = Literal["asked", "retracted", "past", "route", "other", "unknown"]
"""Why a phrase is not among the relations: it was asked, taken back, held before, tells a way,
locates something else, or was not understood."""

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
class Candidate:
    """One place that a mention may refer to.

    Parameters
    ----------
    ground
        Id of a landmark or target; None for a place that is not on the map.
    probability
        Its share before anything else is known, in [0, 1]. Shares of one mention sum to one.

    Raises
    ------
    DescriptionError
        For another share.
    """

    ground: str | None
    probability: float

    def __post_init__(self) -> None:
        _check_share(self.probability, f"The probability of candidate '{self.ground}'")


@dataclass(frozen=True)
class Distance:
    """A said distance, or bounds on one.

    Parameters
    ----------
    low_m, high_m
        Bounds, metres; equal for "50 m", 0 to 50 for "within 50 m", 50 to infinity for "at least".
    vagueness
        Standard deviation of each bound as a share of it: small for "exactly 50 m", large for "a
        stone's throw".

    Raises
    ------
    DescriptionError
        When the bounds are negative, not numbers or the wrong way round.

    Examples
    --------
    >>> Distance(0, 50).stated_m is None, Distance(50, 50).stated_m
    (True, 50)
    """

    low_m: float
    high_m: float
    vagueness: float = 0.2

    def __post_init__(self) -> None:
        for name in ("low_m", "high_m", "vagueness"):
            _check_number(getattr(self, name), f"'{name}' of a distance")
        if not 0 <= self.low_m <= self.high_m or not self.low_m < math.inf:
            raise DescriptionError(
                f"Distance from {self.low_m} to {self.high_m} m; expected 0 <= low <= high, "
                "the lower one finite"
            )
        if not 0 < self.vagueness <= 2:
            raise DescriptionError(
                f"The vagueness of a distance is {self.vagueness}; expected a share in (0, 2]"
            )

    @property
    def stated_m(self) -> float | None:
        """The one number that was said, metres; None for bounds."""
        return self.low_m if self.low_m == self.high_m else None


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
        Probability of the readings that contain it, in [0, 1].
    spans
        Where it was read; None when it was not read from text.
    each
        True when it holds of each ground by itself: "not near a bank" denies every bank.
    candidates
        What each of the grounds may be: one tuple per ground. Empty for grounds that are certain,
        and for `each`.
    mentions
        A number per ground. Grounds of one number, in several relations of a description, are the
        same place: of "the bank" and "it" one bank is meant. Empty for grounds of their own.
    distance
        The distance as bounds; of one number unless given, where `distance_m` is.
    either
        Group and branch of an alternative: of "at A or behind B, near C" the first is (0, 0), the
        others are (0, 1). Within a branch all holds, of a group one branch.
    part
        Which part of its ground is meant, such as the north side of a street; None for all of it.

    Raises
    ------
    UnknownName
        When `relation` is not a canonical word.
    DescriptionError
        When `grounds` is empty, `candidates` or `mentions` do not belong to them, or a number is
        none, not finite or out of its range.

    Examples
    --------
    >>> bank = (Candidate("Chase", 0.6), Candidate("KeyBank", 0.3), Candidate(None, 0.1))
    >>> SpatialRelation("RedBike", "near", ("Chase",), candidates=(bank,)).is_certain
    False
    """

    figure: str
    relation: str
    grounds: tuple[str, ...]
    negated: bool = False
    distance_m: float | None = None
    confidence: float = 1.0
    spans: RelationSpans | None = None
    each: bool = False
    candidates: tuple[tuple[Candidate, ...], ...] = ()
    mentions: tuple[int, ...] = ()
    distance: Distance | None = None
    either: tuple[int, int] | None = None
    part: StreetPart | None = None

    def __post_init__(self) -> None:
        if self.relation not in RELATIONS:
            raise UnknownName("relation", self.relation, RELATIONS)
        if not self.grounds:
            raise DescriptionError(
                f"Relation '{self.relation}' of '{self.figure}' has no ground; "
                "expected at least one"
            )
        for name, given in (("candidates", self.candidates), ("mentions", self.mentions)):
            if given and len(given) != len(self.grounds):
                raise DescriptionError(
                    f"Relation '{self.relation}' of '{self.figure}' has {len(given)} {name} for "
                    f"{len(self.grounds)} grounds; expected one for each"
                )
        self._check_numbers()
        for ground, slot in zip(self.grounds, self.candidates, strict=False):
            _check_slot(self, ground, slot)
        if self.distance is None and self.distance_m is not None:
            object.__setattr__(self, "distance", Distance(self.distance_m, self.distance_m))
        elif self.distance is not None:
            object.__setattr__(self, "distance_m", self.distance.stated_m)

    def _check_numbers(self) -> None:
        what = f"Relation '{self.relation}' of '{self.figure}'"
        _check_share(self.confidence, f"{what}: its confidence")
        if self.distance_m is not None:
            _check_number(self.distance_m, f"{what}: its distance_m")
        branch = () if self.either is None else self.either[1:]
        for name, given in (("mentions", self.mentions), ("either", branch)):
            if not all(type(number) is int and number >= 0 for number in given):
                raise DescriptionError(
                    f"{what} has {name} {given!r}; expected whole numbers of at least 0"
                )
        if self.either is not None and len(self.either) != 2:
            raise DescriptionError(f"{what} has either {self.either!r}; expected group and branch")

    @property
    def is_certain(self) -> bool:
        """Whether each ground is one place for certain."""
        return all(len(slot) == 1 and slot[0].ground is not None for slot in self.candidates)

    def slot(self, index: int) -> tuple[Candidate, ...]:
        """Return what one of the grounds may be, the most probable first."""
        if self.candidates:
            return self.candidates[index]
        return (Candidate(self.grounds[index], 1.0),)

    @property
    def ground(self) -> str:
        """The first (for most relations the only) ground."""
        return self.grounds[0]


def _check_number(value: object, what: str) -> None:
    """Raise `DescriptionError` unless something is a number; infinity is one."""
    if isinstance(value, bool) or not isinstance(value, Real) or math.isnan(value):
        raise DescriptionError(f"{what} is {value!r}; expected a number")


def _check_share(value: float, what: str) -> None:
    """Raise `DescriptionError` unless something is a probability."""
    _check_number(value, what)
    if not 0 <= value <= 1:
        raise DescriptionError(f"{what} is {value!r}; expected a share in [0, 1]")


def _check_slot(relation: SpatialRelation, ground: str, slot: tuple[Candidate, ...]) -> None:
    """Raise `DescriptionError` unless the candidates of a ground are a distribution with it."""
    ids = [NOT_ON_MAP if c.ground is None else c.ground for c in slot]
    total = sum(c.probability for c in slot)
    proper = all(0 <= c.probability <= 1 for c in slot) and abs(total - 1) < 1e-6
    if not proper or len(set(ids)) < len(ids):
        raise DescriptionError(
            f"The candidates of ground '{ground}' of relation '{relation.relation}' sum to "
            f"{total:g}; expected shares of different places that sum to one"
        )
    if ground not in ids:
        raise DescriptionError(
            f"Ground '{ground}' of relation '{relation.relation}' is not among its candidates "
            f"({', '.join(ids)}); expected the most probable of them"
        )


@dataclass(frozen=True)
class Reading:
    """One way to understand a description.

    Parameters
    ----------
    probability
        Its probability before the map is asked, in [0, 1]; those of a description sum to one.
    relations
        What is asserted or denied; empty for "nothing of this was read right".

    Raises
    ------
    DescriptionError
        For a probability that is none.
    """

    probability: float
    relations: tuple[SpatialRelation, ...] = ()

    def __post_init__(self) -> None:
        _check_share(self.probability, "The probability of a reading")


@dataclass(frozen=True)
class Unresolved:
    """A phrase that says nothing of where a target is, or was not understood.

    Parameters
    ----------
    text
        The words.
    span
        Where they stand, half-open character range.
    candidates
        Ids of the landmarks that come nearest, best first.
    status
        Why it is not among the relations.

    Examples
    --------
    >>> import sloop_ppl as sloop
    >>> said = sloop.parse("The bike is at Rumor. Has anyone seen it at Ivy?", "cleveland")
    >>> [(phrase.text, phrase.status) for phrase in said.unresolved]
    [('at Ivy', 'asked')]
    """

    text: str
    span: Span
    candidates: tuple[str, ...] = ()
    status: Status = "unknown"


@dataclass(frozen=True, repr=False)
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
        What it says about them, in the most probable reading.
    unresolved
        All else: what was not understood, and what does not say where a target is.
    speaker
        Who says it; None for a person of whom nothing else is known. What one speaker says in
        several texts is one longer description; several speakers are independent.
    viewpoint
        ``"map"`` for who looks at a map, whose up is north, as all did in the paper; ``"ground"``
        for who stands in the city. Then up, down, above, below, under and top are no compass words:
        each relation is put as what it means there (`Relation.from_ground` of its record), so that
        "under the bridge" is at it and "up the street" near it, in no direction that is known.
        Sides of the map itself ("the top of the map") stay what they are.
    readings
        Ways to understand it, the most probable that says anything first; the one of `relations`
        for certain unless given.
    hearer
        Where who listens is, (x_m, y_m), which may be outside the map; None when no one knows.

    Raises
    ------
    UnknownName
        For another viewpoint.
    DescriptionError
        When the probabilities of `readings` do not sum to one, or `hearer` is no place.

    Examples
    --------
    >>> import sloop_ppl as sloop
    >>> said = sloop.parse("The red bike is near Ivy, not behind it.", "cleveland")
    >>> [(r.figure, r.relation, r.ground, r.negated) for r in said.relations]
    [('RedBike', 'near', 'Ivy', False), ('RedBike', 'behind', 'Ivy', True)]
    >>> [target.id for target in said.targets]
    ['RedBike']
    """

    text: str
    map: str
    targets: tuple[TargetObject, ...]
    relations: tuple[SpatialRelation, ...]
    unresolved: tuple[Unresolved, ...] = ()
    speaker: str | None = None
    viewpoint: Viewpoint = "map"
    readings: tuple[Reading, ...] = ()
    hearer: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        check_viewpoint(self.viewpoint)
        if self.hearer is not None:
            object.__setattr__(self, "hearer", _checked_place(self.hearer))
        total = sum(reading.probability for reading in self.readings)
        if self.readings and not abs(total - 1) < 1e-6:
            raise DescriptionError(
                f"The probabilities of the readings sum to {total:g}; expected one"
            )
        if self.viewpoint == "ground":
            object.__setattr__(self, "relations", _all_from_ground(self.relations))
            seen = tuple(
                replace(reading, relations=_all_from_ground(reading.relations))
                for reading in self.readings
            )
            object.__setattr__(self, "readings", seen)

    def __repr__(self) -> str:
        phrases = "; ".join(
            f"{r.figure} {'not ' if r.negated else ''}{r.relation} {', '.join(r.grounds)}"
            for r in self.relations
        )
        text = self.text if len(self.text) <= 60 else f"{self.text[:57]}..."
        return f"Description({text!r} on {self.map!r}: {phrases or 'no relation'})"

    def _repr_html_(self) -> str:
        from sloop_ppl._html import caption, html_table

        head = ("figure", "relation", "ground", "denied", "confidence")
        rows = [
            (r.figure, r.relation, ", ".join(r.grounds), "yes" if r.negated else "", r.confidence)
            for r in self.relations
        ]
        aside = [(u.text, u.status) for u in self.unresolved]
        parts = [caption(self.text or "(no text)"), html_table(rows, head)]
        parts += [html_table(aside, ("set aside", "status"))] if aside else []
        return "".join(parts)

    @property
    def is_certain(self) -> bool:
        """Whether there is one reading, without alternatives, and every ground is one place."""
        return len(self.readings) < 2 and all(
            relation.is_certain and relation.either is None for relation in self.relations
        )

    def all_readings(self) -> tuple[Reading, ...]:
        """Return the readings, the one of `relations` for certain when none were given."""
        return self.readings or (Reading(1.0, self.relations),)

    def about(self, target_id: str) -> tuple[SpatialRelation, ...]:
        """Return the relations whose figure is this target, in the order they were said."""
        return tuple(r for r in self.relations if r.figure == target_id)

    def placed(self, hearer: tuple[float, float] | None) -> Description:
        """Return it as said to someone at a place, (x_m, y_m).

        What is told from the hearer's place says nothing while no one knows it: without one, those
        relations stand among `unresolved`.
        """
        if hearer is not None:
            return replace(self, hearer=hearer)
        placed = [r for r in self.relations if HEARER in r.grounds and r.spans is not None]
        if not placed:
            return self
        spans = {
            (min(r.spans.relation[0], r.spans.grounds[0][0]), r.spans.grounds[-1][1])
            for r in placed
            if r.spans is not None
        }
        loose = tuple(Unresolved(self.text[slice(*s)], s, status="other") for s in sorted(spans))
        unresolved = sorted((*self.unresolved, *loose), key=lambda u: u.span)
        return replace(
            self,
            relations=tuple(r for r in self.relations if r not in placed),
            unresolved=tuple(unresolved),
            readings=tuple(
                replace(h, relations=tuple(r for r in h.relations if HEARER not in r.grounds))
                for h in self.readings
            ),
        )

    def to_json(self) -> dict[str, Any]:
        """Return the value that ``sloop parse --json`` prints: one relation entry per ground."""
        return {
            "text": self.text,
            "map": self.map,
            "targets": [t.id for t in self.targets],
            "relations": _entries(self.relations),
            "readings": [
                {"p": round(reading.probability, 6), "relations": _entries(reading.relations)}
                for reading in self.all_readings()
            ],
            "unresolved": [
                {
                    "text": u.text,
                    "span": list(u.span),
                    "candidates": list(u.candidates),
                    "status": u.status,
                }
                for u in self.unresolved
            ],
        }


def _checked_place(place: Any) -> tuple[float, float]:
    """Return the place of who listens as two floats.

    Raises
    ------
    DescriptionError
        When it is not two finite numbers.
    """
    try:
        x, y = (float(number) for number in place)
    except (TypeError, ValueError):
        x = y = math.nan
    if not (math.isfinite(x) and math.isfinite(y)):
        raise DescriptionError(
            f"The place 'hearer' is {place!r}; expected two finite numbers, (x_m, y_m) in metres"
        )
    return x, y


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


def _all_from_ground(relations: tuple[SpatialRelation, ...]) -> tuple[SpatialRelation, ...]:
    return tuple(_from_ground(relation) for relation in relations)


def _from_ground(relation: SpatialRelation) -> SpatialRelation:
    """Return a relation as who stands on the ground means it."""
    record = RELATIONS[relation.relation]
    counterpart = record.from_ground
    if counterpart is None or WHOLE_MAP in relation.grounds:
        return relation
    part = relation.part
    if part is not None and part.bearing_rad is not None and record.directions:
        # The "upper" of "the upper left corner" is no north to who stands there.
        part = None if part.kind == "side" else replace(part, bearing_rad=None)
    return replace(relation, relation=counterpart, part=part)


def _distance_entry(distance: Distance | None) -> list[float | None] | None:
    """Return bounds as JSON has them: None for no upper one."""
    if distance is None:
        return None
    return [distance.low_m, distance.high_m if distance.high_m < math.inf else None]


def _part_entry(part: StreetPart | None) -> dict[str, Any]:
    """Return the entry of a part, nothing for all of a ground."""
    if part is None:
        return {}
    bearing = part.bearing_rad
    bearing_deg = None if bearing is None else round(math.degrees(bearing), 6)
    return {"part": {"kind": part.kind, "bearing_deg": bearing_deg, "number": part.number}}


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
                    "ground": None if ground == NOT_ON_MAP else ground,
                    "group": group,
                    "negated": relation.negated,
                    "status": "denied" if relation.negated else "asserted",
                    "either": None if relation.either is None else list(relation.either),
                    "distance_m": relation.distance_m,
                    "distance": _distance_entry(relation.distance),
                    "candidates": [
                        {"ground": c.ground, "p": round(c.probability, 6)} for c in relation.slot(i)
                    ],
                    "spans": None
                    if spans is None
                    else {
                        "figure": list(spans.figure),
                        "relation": list(spans.relation),
                        "ground": list(spans.grounds[i]),
                    },
                    "confidence": relation.confidence,
                    **_part_entry(relation.part),
                }
            )
    return entries
