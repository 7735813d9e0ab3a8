"""Relations whose ground is another target: they say how two targets lie apart, not where."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from sloop_ppl.language import NOT_ON_MAP, RELATIONS, Description, SpatialRelation
from sloop_ppl.maps import CityMap
from sloop_ppl.models._choices import Choice, Phrasing

__all__ = ["SplitPhrasing", "TargetPhrasing", "split_by_targets", "split_phrasing", "target_ids"]

_OF_EACH = "near"
"""What a word that takes several grounds means of each of them, where one may be anywhere."""


def target_ids(
    descriptions: Sequence[Description], city: CityMap, others: Collection[str] = ()
) -> frozenset[str]:
    """Return the ids that are targets as grounds; a landmark of the same id comes first.

    Parameters
    ----------
    descriptions
        What was said.
    city
        The map.
    others
        Ids of targets that were spoken of before.
    """
    known = {target.id for description in descriptions for target in description.targets}
    return frozenset(name for name in (*known, *others) if name not in city)


def split_by_targets(
    relation: SpatialRelation, targets: Collection[str]
) -> tuple[SpatialRelation | None, tuple[SpatialRelation, ...]]:
    """Return the part of a relation that is to places, and one relation for each target in it.

    Parameters
    ----------
    relation
        The relation.
    targets
        Ids of targets.

    Returns
    -------
    tuple
        The relation to those of its grounds that are no targets, None when all are; the relation to
        each target. "Between the bank and the red bike" is near the bank and near the bike: the
        region between depends on where the bike is, which a table over cells cannot hold.
    """
    kept = [i for i, ground in enumerate(relation.grounds) if ground not in targets]
    if len(kept) == len(relation.grounds):
        return relation, ()
    several = RELATIONS[relation.relation].grounds == "several"
    word = _OF_EACH if several and len(relation.grounds) > 1 else relation.relation
    pairs = tuple(
        replace(relation, relation=word, grounds=(ground,), candidates=(), mentions=())
        for ground in dict.fromkeys(relation.grounds)
        if ground in targets
    )
    if not kept:
        return None, pairs
    rest = replace(
        relation,
        relation=relation.relation if len(kept) > 1 else word,
        grounds=tuple(relation.grounds[i] for i in kept),
        candidates=tuple(relation.candidates[i] for i in kept if relation.candidates),
        mentions=tuple(relation.mentions[i] for i in kept if relation.mentions),
    )
    return rest, pairs


@dataclass(frozen=True, eq=False)
class TargetPhrasing:
    """One relation to another target.

    Parameters
    ----------
    relation
        The relation; its one ground is a target.
    choices
        What the description leaves open that it depends on.
    holds_when
        Name of a choice -> the values under which it is said.
    """

    relation: SpatialRelation
    choices: tuple[Choice, ...]
    holds_when: Mapping[str, frozenset[Any]]


@dataclass(frozen=True, eq=False)
class SplitPhrasing:
    """One relation of a description: what it says of places, and of other targets.

    Parameters
    ----------
    index
        Position of the relation among those of its figure; -1 when another reading alone has it.
    of_places
        The relation as far as its grounds are, or may be, places; None when none may be.
    to_targets
        The relation to each target that is a ground, or may be.
    """

    index: int
    of_places: Phrasing | None
    to_targets: tuple[TargetPhrasing, ...]


def split_phrasing(phrasing: Phrasing, targets: Collection[str], index: int) -> SplitPhrasing:
    """Return what a relation says of places, and what of how two targets lie apart.

    Parameters
    ----------
    phrasing
        The relation with its choices.
    targets
        Ids of targets.
    index
        Its number.

    Notes
    -----
    A mention that may be a place or a target is one choice: under a place the relation is a table
    over cells, under a target that is silent and the relation to the target is said. Where a
    relation takes several grounds, an uncertain one is never a target.
    """
    relation = phrasing.relation
    places = {place for slot in phrasing.denied for place in slot}
    places |= {value for slot in phrasing.slots if slot for value in slot.support}
    if not targets or not (places | set(relation.grounds)) & set(targets):
        return SplitPhrasing(index, phrasing, ())
    gates = tuple(choice for choice in phrasing.choices if choice.kind != "ground")
    if not any(phrasing.slots) and not any(phrasing.denied):
        rest, pairs = split_by_targets(relation, targets)
        count = 0 if rest is None else len(rest.grounds)
        of_places = None
        if rest is not None:
            none: list[Any] = [None] * count
            of_places = replace(phrasing, relation=rest, slots=none, denied=[()] * count)
        found = [TargetPhrasing(pair, gates, phrasing.holds_when) for pair in pairs]
        return SplitPhrasing(index, of_places, tuple(found))
    if len(relation.grounds) > 1:
        return SplitPhrasing(index, _of_places(phrasing, targets), ())
    slot, denied = phrasing.slots[0], phrasing.denied[0]
    found = []
    for target in dict.fromkeys((*denied, *(slot.support if slot else ()))):
        if target in targets:
            pair = replace(relation, grounds=(target,), candidates=(), mentions=())
            open_to, when = gates, dict(phrasing.holds_when)
            if slot is not None:
                open_to, when = (*gates, slot), {**when, slot.name: frozenset({target})}
            found.append(TargetPhrasing(pair, open_to, when))
    if denied and not any(place not in targets for place in denied):
        return SplitPhrasing(index, None, tuple(found))
    return SplitPhrasing(index, _of_places(phrasing, targets), tuple(found))


def _of_places(phrasing: Phrasing, targets: Collection[str]) -> Phrasing:
    """Return a phrasing of which no ground is fixed to be a target, nor denied to be one."""
    denied = [tuple(place for place in slot if place not in targets) for slot in phrasing.denied]
    grounds = []
    for ground, slot in zip(phrasing.relation.grounds, denied, strict=True):
        other = slot[0] if slot else NOT_ON_MAP
        grounds.append(other if ground in targets else ground)
    relation = replace(phrasing.relation, grounds=tuple(grounds), candidates=(), mentions=())
    return replace(phrasing, relation=relation, denied=denied)
