"""What a description leaves open, as discrete latents: its readings, branches and referents."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeAlias

from sloop_ppl.language import NOT_ON_MAP, Candidate, Description, SpatialRelation

__all__ = ["Choice", "ChoiceKind", "Phrasing", "phrasings_of"]

ChoiceKind: TypeAlias = Literal["reading", "branch", "ground"]
"""Which way a text was meant, which side of an "or" holds, which place a mention refers to."""


@dataclass(frozen=True)
class Choice:
    """One discrete latent of a description.

    Parameters
    ----------
    name
        Name of its site: ``reading``, ``either_g``, ``ground_k``; with ``/text_d`` for a speaker's
        d-th later text.
    support
        Positions of readings, numbers of branches, or ids of places (``NotOnMap`` for none).
    prior
        Probability of each, summing to one.
    kind
        What is chosen.
    """

    name: str
    support: tuple[Any, ...]
    prior: tuple[float, ...]
    kind: ChoiceKind


@dataclass(frozen=True, eq=False)
class Phrasing:
    """One relation of a description, with what has to be chosen before it has a meaning.

    Parameters
    ----------
    relation
        What was said.
    position
        Its position among ``description.about(figure)``; None when another reading alone has it.
    readings
        Positions of the readings that contain it.
    branches
        Branches of the group of alternatives it belongs to; empty for one that belongs to none.
    holds_when
        Name of a reading or branch -> the values under which it is said.
    slots
        Per ground, the choice of the place it refers to; None for a certain one.
    denied
        Per ground, all the places that are denied; empty for one that is not chosen so.
    choices
        Every choice it depends on.
    is_silent
        True when one of its grounds is not on the map for certain.
    """

    relation: SpatialRelation
    position: int | None
    readings: set[int]
    branches: tuple[int, ...] = ()
    holds_when: dict[str, frozenset[int]] = field(default_factory=dict)
    slots: list[Choice | None] = field(default_factory=list)
    denied: list[tuple[str, ...]] = field(default_factory=list)
    choices: list[Choice] = field(default_factory=list)
    is_silent: bool = False


def phrasings_of(
    description: Description, *, sum_readings: bool, sum_grounds: bool, text: int = 0
) -> tuple[Phrasing, ...]:
    """Return every relation of every reading once, with the choices between them.

    Parameters
    ----------
    description
        What was said.
    sum_readings, sum_grounds
        False to take the most probable reading (and the first branch), or the most probable
        ground of each mention, for certain.
    text
        Position of the description among those of its speaker.

    Returns
    -------
    tuple of Phrasing
        Those of ``description.relations`` first, in their order.

    Notes
    -----
    A mention that several phrases of a reading refer to is one choice. A denied phrase denies all
    candidates of its mention, unless an asserted phrase refers to the same one: then it is that
    place that is denied.
    """
    suffix = f"/text_{text}" if text else ""
    readings = [(1.0, description.relations)]
    if sum_readings and len(description.readings) > 1:
        first, *others = description.readings
        readings = [(first.probability, description.relations)]
        readings += [(other.probability, other.relations) for other in others]
        readings = [one for one in readings if one[0] > 0] or readings[:1]
    found = _merged([relations for _, relations in readings], first_only=not sum_readings)
    if len(readings) > 1:
        total = sum(p for p, _ in readings)
        prior = tuple(p / total for p, _ in readings)
        which = Choice(f"reading{suffix}", tuple(range(len(readings))), prior, "reading")
        for one in found:
            if len(one.readings) < len(readings):
                one.holds_when[which.name] = frozenset(one.readings)
                one.choices.append(which)
    _choose_branches(found, suffix)
    found = [_with_places(one, sum_grounds=sum_grounds) for one in found]
    _choose_grounds(found, suffix)
    return tuple(found)


def _merged(readings: Sequence[tuple[SpatialRelation, ...]], *, first_only: bool) -> list[Phrasing]:
    """Return the relations of all readings, those that several have in common once."""
    counts: dict[str, int] = defaultdict(int)
    found: list[Phrasing] = []
    keys: list[Any] = []
    for h, relations in enumerate(readings):
        branches = _branches(relations)
        taken: set[int] = set()
        for relation in relations:
            position = counts[relation.figure] if h == 0 else None
            counts[relation.figure] += h == 0
            group = () if relation.either is None else branches[relation.either[0]]
            if first_only and relation.either is not None:
                if relation.either[1] != group[0]:
                    continue
                group = ()
            # Spans and confidence say where it was read, not what it says.
            key = (replace(relation, confidence=1.0, spans=None), group)
            same = (i for i, other in enumerate(keys) if i not in taken and other == key)
            at = next(same, None) if h else None
            if at is None:
                at = len(found)
                found.append(Phrasing(relation, position, set(), group))
                keys.append(key)
            taken.add(at)
            found[at].readings.add(h)
    return found


def _branches(relations: Collection[SpatialRelation]) -> dict[int, tuple[int, ...]]:
    """Return group of an alternative -> its branches."""
    groups: dict[int, set[int]] = defaultdict(set)
    for relation in relations:
        if relation.either is not None:
            groups[relation.either[0]].add(relation.either[1])
    return {group: tuple(sorted(branches)) for group, branches in groups.items()}


def _choose_branches(found: Sequence[Phrasing], suffix: str) -> None:
    """Make each group of alternatives one choice with equal weights.

    Readings whose groups of one number have the same branches share the choice: one reading holds.
    """
    groups: dict[tuple[int, tuple[int, ...]], Choice] = {}
    for one in found:
        if one.relation.either is None or len(one.branches) < 2:
            continue
        group, branch = one.relation.either
        key = group, one.branches
        if key not in groups:
            taken = {choice.name for choice in groups.values()}
            number = group
            while f"either_{number}{suffix}" in taken:
                number += 1
            share = 1 / len(one.branches)
            prior = (share,) * len(one.branches)
            groups[key] = Choice(f"either_{number}{suffix}", one.branches, prior, "branch")
        one.holds_when[groups[key].name] = frozenset({branch})
        one.choices.append(groups[key])


def _with_places(one: Phrasing, *, sum_grounds: bool) -> Phrasing:
    """Fix what is certain of a phrase's grounds; silence it where one is on no map."""
    relation = one.relation
    slots: list[tuple[Candidate, ...]] = []
    grounds: list[str] = []
    for i, ground in enumerate(relation.grounds):
        slot = tuple(c for c in relation.slot(i) if c.probability > 0)
        if not sum_grounds or not slot:
            slot = (Candidate(ground, 1.0),)
        slot = tuple(replace(c, ground=None) if c.ground == NOT_ON_MAP else c for c in slot)
        places = [c.ground for c in slot if c.ground is not None]
        grounds.append(ground if ground in places else next(iter(places), NOT_ON_MAP))
        slots.append(slot)
    is_silent = NOT_ON_MAP in grounds
    if is_silent:
        slots = [slot[:1] for slot in slots]
        grounds = [slot[0].ground or NOT_ON_MAP for slot in slots]
        slots = [(replace(slot[0], probability=1.0),) for slot in slots]
    return replace(
        one,
        relation=replace(relation, grounds=tuple(grounds), candidates=tuple(slots)),
        slots=[None] * len(grounds),
        denied=[()] * len(grounds),
        is_silent=is_silent,
    )


def _choose_grounds(found: Sequence[Phrasing], suffix: str) -> None:
    """Make each mention whose place is open one choice, or deny all its places."""
    open_slots = [
        (one, i) for one in found for i, slot in enumerate(one.relation.candidates) if len(slot) > 1
    ]
    numbered: dict[int, list[tuple[Phrasing, int]]] = defaultdict(list)
    for one, i in open_slots:
        if one.relation.mentions:
            numbered[one.relation.mentions[i]].append((one, i))
    groups: list[tuple[int | None, list[tuple[Phrasing, int]]]] = []
    for one, i in open_slots:
        number = one.relation.mentions[i] if one.relation.mentions else None
        if number is None:
            groups.append((None, [(one, i)]))
        elif numbered[number][0] == (one, i) or not _meet(numbered[number]):
            together = numbered[number] if _meet(numbered[number]) else [(one, i)]
            groups.append((number, together))
    used: set[int] = set()
    following = max((n for n in numbered), default=-1) + 1
    for number, members in groups:
        if all(one.relation.negated for one, _ in members):
            for one, i in members:
                slot = one.relation.candidates[i]
                one.denied[i] = tuple(c.ground for c in slot if c.ground is not None)
            continue
        if number is None or number in used:
            number, following = following, following + 1
        used.add(number)
        first, at = members[0]
        slot = first.relation.candidates[at]
        total = sum(c.probability for c in slot)
        choice = Choice(
            f"ground_{number}{suffix}",
            tuple(NOT_ON_MAP if c.ground is None else c.ground for c in slot),
            tuple(c.probability / total for c in slot),
            "ground",
        )
        for one, i in members:
            one.slots[i] = choice
            if choice not in one.choices:
                one.choices.append(choice)


def _meet(members: Sequence[tuple[Phrasing, int]]) -> bool:
    """Tell whether two grounds of one number are said together in some reading."""
    return any(
        one.readings & other.readings
        for n, (one, _) in enumerate(members)
        for other, _ in members[n + 1 :]
    )
