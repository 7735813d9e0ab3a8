"""Which of the relations that were read are which of the gold, where several would be right."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Generic, TypeVar

from sloop_ppl.eval._gold import GoldEntry
from sloop_ppl.language import NOT_ON_MAP, Description, StreetPart

__all__ = ["Match", "ReadEntry", "Wanted", "is_right", "kinds_agree", "match", "read_entries"]

Key = TypeVar("Key")

_NOT_NOUNS = frozenset(
    {
        "a", "an", "and", "at", "by", "from", "here", "his", "her", "in", "it", "its", "my", "near",
        "of", "on", "one", "or", "our", "place", "s", "some", "that", "the", "their", "there",
        "they", "this", "to", "where", "which", "with", "you", "your",
    }
)  # fmt: skip
_OPENS_A_PHRASE = re.compile(r"\b(?:at|by|for|from|in|near|of|on|to|with|called|named)\b")


@dataclass(frozen=True)
class ReadEntry:
    """One figure in one relation to one ground, as it was read.

    Parameters
    ----------
    figure, relation, ground, negated, status
        As in :class:`sloop_ppl.eval._gold.GoldEntry`.
    words
        Words of the text that name the ground; empty when they are unknown.
    candidates
        Ids of all places that the ground may be.
    sources
        Numbers of the relations it was read as.
    every
        Those of `sources` that hold of each of several grounds ("not near a bank").
    part
        The part of its ground that is meant.
    """

    figure: str
    relation: str
    ground: str
    negated: bool = False
    status: str = "asserted"
    words: frozenset[str] = frozenset()
    candidates: frozenset[str] = frozenset()
    sources: frozenset[int] = frozenset()
    every: frozenset[int] = frozenset()
    part: StreetPart | None = None


@dataclass(frozen=True)
class Wanted(Generic[Key]):
    """A gold entry as it is counted: what of its relation has to be right, and its ground."""

    key: Key
    entry: GoldEntry


@dataclass(frozen=True)
class Match(Generic[Key]):
    """What of one description was read right.

    Parameters
    ----------
    right
        What was read -> the required entry that it is.
    missed
        Required entries that were not read.
    wrong
        What was read and is none of the gold.
    passed
        What was read and counts as neither: optional entries, and further grounds of a denied kind.
    """

    right: Mapping[ReadEntry, GoldEntry] = field(default_factory=dict)
    missed: tuple[GoldEntry, ...] = ()
    wrong: tuple[ReadEntry, ...] = ()
    passed: tuple[ReadEntry, ...] = ()


def read_entries(description: Description) -> tuple[ReadEntry, ...]:
    """Return the relations of a description, one entry per ground, in their order."""
    found = []
    for number, relation in enumerate(description.relations):
        for slot, ground in enumerate(relation.grounds):
            words: Iterable[str] = ()
            if relation.spans is not None:
                words = _nouns(description.text[slice(*relation.spans.grounds[slot])])
            source = frozenset({number})
            found.append(
                ReadEntry(
                    relation.figure,
                    relation.relation,
                    ground,
                    relation.negated,
                    "alternative"
                    if relation.either
                    else "denied"
                    if relation.negated
                    else "asserted",
                    frozenset(words),
                    frozenset(c.ground for c in relation.slot(slot) if c.ground is not None),
                    source,
                    source if relation.each else frozenset(),
                    relation.part,
                )
            )
    return tuple(found)


def is_right(entry: GoldEntry, read: ReadEntry) -> bool:
    """Say whether what was read has the ground that an entry wants.

    Notes
    -----
    A ground that has an id is right by id. One that has none is right when it was read as not on
    the map, or as whatever the map has of the kind: the words for it hold the head noun of `kind`;
    and where nothing is on the map, one word of `kind`, or no noun at all ("it"). Of an unnamed
    kind that is on the map one right candidate is enough: which one is meant the text may not say.
    """
    if read.ground in entry.accepted:
        return True
    if entry.kind is None:
        return False
    if entry.ground is not None:
        return bool(entry.accepted & read.candidates)
    kind = _nouns(entry.kind)
    if read.ground == NOT_ON_MAP and (not read.words or read.words & set(kind)):
        return True
    return _head(entry.kind) in read.words


def match(
    gold: Sequence[GoldEntry],
    read: Sequence[ReadEntry],
    gold_key: Callable[[GoldEntry], Key],
    read_key: Callable[[ReadEntry], Key],
) -> Match[Key]:
    """Assign what was read to the gold, one to one, so that as much as possible is right.

    Parameters
    ----------
    gold
        What is to be read of one description; optional entries may be.
    read
        What was read. Entries alike in key and ground are one.
    gold_key, read_key
        What of an entry, beside its ground, has to be the same.

    Returns
    -------
    Match
        As many required entries as can be are right, and after that as few as can be wrong.

    Notes
    -----
    Entries are taken in turn, required ones first, and each is assigned along an augmenting path
    (Kuhn 1955). What once is assigned stays so; the sets that can be assigned together are the
    independent sets of a transversal matroid, so that taking the required ones first is optimal.
    """
    wanted = _merged_gold(gold, gold_key)
    merged = _merged_read(read, read_key)
    choices = [
        [j for j, (key, one) in enumerate(merged) if key == want.key and is_right(want.entry, one)]
        for want in wanted
    ]
    holder: dict[int, int] = {}  # what was read -> what it is

    def assign(i: int, tried: set[int]) -> bool:
        for j in choices[i]:
            if j not in tried:
                tried.add(j)
                if j not in holder or assign(holder[j], tried):
                    holder[j] = i
                    return True
        return False

    for i in sorted(range(len(wanted)), key=lambda i: wanted[i].entry.optional):
        assign(i, set())
    found = [one for _, one in merged]
    every = {
        (source, holder[j]) for j, one in enumerate(found) if j in holder for source in one.every
    }
    excused = {
        j
        for j, one in enumerate(found)
        if j not in holder and any(j in choices[i] and source in one.every for source, i in every)
    }
    optional = {j for j, i in holder.items() if wanted[i].entry.optional}
    right = {found[j]: wanted[i].entry for j, i in sorted(holder.items()) if j not in optional}
    held = set(holder.values())
    return Match(
        right,
        tuple(w.entry for i, w in enumerate(wanted) if i not in held and not w.entry.optional),
        tuple(one for j, one in enumerate(found) if j not in holder and j not in excused),
        tuple(one for j, one in enumerate(found) if j in optional | excused),
    )


def kinds_agree(one: str | None, other: str | None) -> bool:
    """Say whether two phrases are of one kind of place: alike in the head noun."""
    return one is not None and other is not None and _head(one) == _head(other) is not None


def _merged_gold(gold: Sequence[GoldEntry], key: Callable[[GoldEntry], Key]) -> list[Wanted[Key]]:
    """Return the gold with entries alike in key and ground as one, required if one of them is."""
    found: dict[object, Wanted[Key]] = {}
    for entry in gold:
        kind = entry.kind if entry.ground is None else None
        alike = key(entry), entry.accepted, kind
        known = found.get(alike)
        optional = entry.optional and (known is None or known.entry.optional)
        found[alike] = Wanted(
            key(entry), replace(known.entry if known else entry, optional=optional)
        )
    return list(found.values())


def _merged_read(
    read: Sequence[ReadEntry], key: Callable[[ReadEntry], Key]
) -> list[tuple[Key, ReadEntry]]:
    """Return what was read with entries alike in key and ground as one.

    Of places that are not on the map those named by the same words are alike.
    """
    found: dict[object, tuple[Key, ReadEntry]] = {}
    for one in read:
        alike = key(one), one.ground, one.words if one.ground == NOT_ON_MAP else None
        known = found.get(alike)
        if known is not None:
            first = known[1]
            one = replace(
                first,
                words=first.words | one.words,
                candidates=first.candidates | one.candidates,
                sources=first.sources | one.sources,
                every=first.every | one.every,
                part=first.part or one.part,
            )
        found[alike] = key(one), one
    return list(found.values())


def _nouns(text: str) -> list[str]:
    """Return the words of a phrase that can name a place, in the singular as far as 's' tells."""
    words = re.findall(r"[a-z0-9]+", text.lower().replace("'", ""))
    return [_singular(word) for word in words if word not in _NOT_NOUNS]


def _singular(word: str) -> str:
    if re.search(r"(?:ch|sh|ss|x)es$", word):
        return word[:-2]
    return word[:-1] if len(word) > 3 and word.endswith("s") and not word.endswith("ss") else word


def _head(kind: str) -> str | None:
    """Return the last noun before any "of" and the like: "corner" of "corner of the block"."""
    before = _nouns(_OPENS_A_PHRASE.split(kind.lower())[0])
    nouns = before or _nouns(kind)
    return nouns[-1] if nouns else None
