"""Two annotations of the same texts: how far they agree, and the gold they make together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from sloop_ppl.eval._gold import GoldEntry
from sloop_ppl.eval._matching import kinds_agree
from sloop_ppl.language import RELATIONS

__all__ = ["Agreement", "agreement", "merged"]

Annotations = Mapping[str, Sequence[GoldEntry]]
Pair = tuple[GoldEntry, GoldEntry]


@dataclass(frozen=True)
class Agreement:
    """How many entries of two annotators are the same.

    Parameters
    ----------
    first, second
        Number of entries of each.
    both
        Number of pairs that are the same.
    """

    first: int
    second: int
    both: int

    @property
    def f1(self) -> float:
        """Twice the pairs by all entries; 1 where neither has any."""
        every = self.first + self.second
        return 2 * self.both / every if every else 1.0

    @property
    def of_first(self) -> float:
        """Share of the first annotator's entries that the second has too."""
        return self.both / self.first if self.first else 1.0

    @property
    def of_second(self) -> float:
        """Share of the second annotator's entries that the first has too."""
        return self.both / self.second if self.second else 1.0


def agreement(
    first: Annotations, second: Annotations, *, required: bool = False
) -> dict[str, Agreement]:
    """Compare two annotations text by text.

    Parameters
    ----------
    first, second
        Id of a text -> what the annotator takes it to say.
    required
        Whether only entries that are not optional count.

    Returns
    -------
    dict
        Class of ground, in the order in which they come, and ``"all"`` -> agreement. Entries are
        the same in figure, class of relation, negation, and ground (or kind of ground); to be the
        same in one class of ground, both annotators have to give them that class.
    """
    left = [e for key in first for e in first[key] if not (required and e.optional)]
    right = [e for key in second for e in second[key] if not (required and e.optional)]
    pairs = [
        (a, b)
        for key in first
        for a, b in _pairs(first[key], second.get(key, ()))
        if not (required and (a.optional or b.optional))
    ]
    classes: set[str] = {e.ground_class for e in (*left, *right) if e.ground_class}
    found = {
        name: Agreement(
            sum(e.ground_class == name for e in left),
            sum(e.ground_class == name for e in right),
            sum(a.ground_class == b.ground_class == name for a, b in pairs),
        )
        for name in sorted(classes)
    }
    return {**found, "all": Agreement(len(left), len(right), len(pairs))}


def merged(first: Annotations, second: Annotations) -> dict[str, tuple[GoldEntry, ...]]:
    """Return the gold of two annotations.

    Parameters
    ----------
    first, second
        Id of a text -> what the annotator takes it to say.

    Returns
    -------
    dict
        Id of each text that both annotated -> its gold. What both took is required, unless one
        calls it optional, and accepts the grounds of either; the word is the first annotator's.
        What one took alone is optional. Entries of a relation with several grounds share a group.
    """
    return {key: _regrouped(_merged(first[key], second[key])) for key in first if key in second}


def _merged(first: Sequence[GoldEntry], second: Sequence[GoldEntry]) -> list[tuple[str, GoldEntry]]:
    """Return the gold of one text, each entry with the annotator whose groups it has."""
    partner = {id(a): b for a, b in _pairs(first, second)}
    taken = {id(b) for b in partner.values()}
    shared = [
        ("first", _both(a, partner[id(a)]) if id(a) in partner else replace(a, optional=True))
        for a in first
    ]
    alone = [("second", replace(b, optional=True)) for b in second if id(b) not in taken]
    return shared + alone


def _both(a: GoldEntry, b: GoldEntry) -> GoldEntry:
    """Return one entry that accepts what either annotator would."""
    ground = a.ground if b.ground is not None else None
    accepted = [e for e in (a.ground, *a.also, b.ground, *b.also) if e not in (None, ground)]
    return replace(
        a,
        ground=ground,
        also=tuple(dict.fromkeys(filter(None, accepted))),
        kind=a.kind or b.kind,
        optional=a.optional or b.optional,
        distance=a.distance or b.distance,
    )


def _regrouped(entries: Sequence[tuple[str, GoldEntry]]) -> tuple[GoldEntry, ...]:
    """Give the groups new numbers; one of which a single entry is left is none."""
    members: dict[object, list[GoldEntry]] = {}
    for owner, entry in entries:
        if entry.group is not None:
            members.setdefault((owner, entry.group), []).append(entry)
    kept = [key for key, group in members.items() if len(group) > 1]
    return tuple(
        replace(
            entry,
            group=kept.index((owner, entry.group)) if (owner, entry.group) in kept else None,
        )
        for owner, entry in entries
    )


def _pairs(first: Sequence[GoldEntry], second: Sequence[GoldEntry]) -> list[Pair]:
    """Pair entries that say the same; the same word before another of its class."""
    left, pairs = list(first), []
    right = list(second)
    for exact in (True, False):
        for a in list(left):
            b = next(
                (b for b in right if _same(a, b) and (a.relation == b.relation or not exact)), None
            )
            if b is not None:
                pairs.append((a, b))
                left = [e for e in left if e is not a]
                right = [e for e in right if e is not b]
    return pairs


def _same(a: GoldEntry, b: GoldEntry) -> bool:
    classes = {RELATIONS[e.relation].relation_class for e in (a, b)}
    if a.figure != b.figure or len(classes) > 1 or a.negated != b.negated:
        return False
    if a.accepted & b.accepted:
        return True
    unnamed = a.ground is None or b.ground is None
    return unnamed and kinds_agree(a.kind, b.kind)
