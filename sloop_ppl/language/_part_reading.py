"""Give the parts of streets that a text names to the relations that were read from it."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

from sloop_ppl.language._part_mentions import PartMention, find_parts
from sloop_ppl.language.attachment_record import Attached
from sloop_ppl.language.figures import FigureMention
from sloop_ppl.language.grounds import Ground
from sloop_ppl.language.linking import LandmarkMention
from sloop_ppl.language.relations import RELATIONS
from sloop_ppl.language.street_parts import StreetPart
from sloop_ppl.language.values import NOT_ON_MAP

__all__ = ["NamedText", "Slot", "read_parts"]

Slot = tuple[int, str, int]
"""A relation that was read: number of its phrase, canonical word, first word of its grounds."""

_TOUCHING = 2
"""Words between a part and the street after it, of "mid-block on A"."""

_RECENT = 4
"""Streets of a sentence before a part that it may be of."""

_MOST = 32
"""Relations to one mention of a place that are looked at, so that time stays linear."""


@dataclass(frozen=True)
class NamedText:
    """What was recognised in a text, as far as parts depend on it.

    Parameters
    ----------
    norms
        Its words, spelling mended.
    names
        The names of places in it.
    figures
        The objects in it.
    stops
        The words at which its sentences end, in order.
    ways
        First words of the names that stand for streets.
    way_ids
        Ids of the streets of the map.
    """

    norms: Sequence[str]
    names: Sequence[LandmarkMention]
    figures: Sequence[FigureMention]
    stops: Sequence[int]
    ways: Collection[int]
    way_ids: Collection[str]


def read_parts(phrases: Sequence[Attached], text: NamedText) -> dict[Slot, StreetPart]:
    """Return the part of each relation that has one; linear in the text.

    A part goes to a relation of the street that it is said to be of, first to that which was read
    from its words, of these to that with a direction. Where no street stands next to it, it goes to
    the street before or after it in its sentence, or in the sentence before when that is about the
    same objects. A relation has one part at most.

    Parameters
    ----------
    phrases
        What was read, asserted or denied.
    text
        What was recognised.
    """
    return _Assignment(phrases, text).parts


@dataclass(frozen=True)
class _Holder:
    """A relation that may have a part."""

    slot: Slot
    one: Attached
    grounds: tuple[Ground, ...]
    is_way: bool

    @property
    def is_directed(self) -> bool:
        record = RELATIONS[self.slot[1]]
        return record.is_compass or record.needs_frame

    @property
    def is_crossing(self) -> bool:
        several = RELATIONS[self.slot[1]].grounds == "several"
        return self.is_way and len(self.grounds) > 1 and self.one.phrase.joint and not several

    def rank(self, mention: PartMention) -> tuple[bool, ...]:
        """Return what tells which of several relations of one street a part is meant of."""
        phrase = self.one.phrase
        covered = phrase.cue[0] < mention.last and mention.first < phrase.cue[1]
        return not covered, phrase.negated and not covered, not self.is_directed


class _Assignment:
    """The relations of a text, and the parts that they have so far."""

    def __init__(self, phrases: Sequence[Attached], text: NamedText) -> None:
        self.text = text
        self.parts: dict[Slot, StreetPart] = {}
        self.holders = list(self._holders(phrases))
        self.at_word: dict[int, list[_Holder]] = {}  # first word of a ground -> its relations
        self.by_cue: dict[int, list[_Holder]] = {}  # word of a cue -> the same
        for holder in self.holders:
            for ground in holder.grounds:
                known = self.at_word.setdefault(ground.first, [])
                if len(known) < _MOST:
                    known.append(holder)
            for word in range(*holder.one.phrase.cue):
                self.by_cue.setdefault(word, []).append(holder)
        self.figures_at = [m.first for m in text.figures]
        self.lying = {  # first word of a street -> relations that it alone is the ground of
            first: alone
            for first, holders in self.at_word.items()
            if first in text.ways
            and (alone := [h for h in holders if len(h.grounds) == 1 and not h.is_directed])
        }
        names = sorted(text.names, key=lambda m: m.first)
        self.streets = [m for m in names if m.first in self.lying]
        self.streets_at = [m.first for m in self.streets]
        self.names_at = [m.first for m in names if not self._is_bound(m.first)]
        for mention in self._in_turn():
            self._place(mention)
        self._crossings()
        self._numbers()

    def _holders(self, phrases: Sequence[Attached]) -> Iterable[_Holder]:
        for k, one in enumerate(phrases):
            phrase = one.phrase
            if phrase.each:
                continue
            groups = [phrase.grounds] if phrase.joint else [(g,) for g in phrase.grounds]
            for relation in phrase.relations:
                for grounds in groups:
                    ids = [g.ids[0] for g in grounds]
                    ways = [i in self.text.way_ids for i in ids]
                    is_way = any(ways) and all(
                        way or i == NOT_ON_MAP for i, way in zip(ids, ways, strict=True)
                    )
                    yield _Holder((k, relation, grounds[0].first), one, grounds, is_way)

    def _in_turn(self) -> list[PartMention]:
        """Return the parts, those whose relation is plain before those that look for one."""
        found = find_parts(self.text.norms, self.text.names, self.text.ways)
        return sorted(found, key=lambda m: not (m.places or self._covering(m)))

    def _covering(self, mention: PartMention) -> list[_Holder]:
        """Return the relations that were read from the words of a part."""
        words = range(mention.first, mention.last)
        return list({h.slot: h for w in words for h in self.by_cue.get(w, ())}.values())

    def _place(self, mention: PartMention) -> None:
        """Give a part to a relation, if there is one that it can be of."""
        covering = self._covering(mention)
        if mention.part.kind == "block":
            near = [h for h in covering if h.slot[1] == "near"] or self._at(mention)
            for holder in near:
                if holder.slot[1] == "near":
                    self.parts.setdefault(holder.slot, mention.part)
            return
        if mention.places:
            self._give(mention, self._at(mention))
            return
        if any(self._is_bound(h.grounds[0].first) for h in covering):
            covering = []  # "on C between A and B, on the north side": of C, though B was last
        ways = [h for h in covering if h.is_way]
        if mention.denied:  # "not near the corner" denies the corner, and not its street
            for holder in ways:
                self.parts.setdefault(holder.slot, StreetPart("corner"))
        elif (ways and self._give(mention, ways)) or (covering and mention.moves != "any"):
            return
        for street in self._streets_for(mention):
            if self._give(mention, self.lying[street.first]):
                return

    def _is_bound(self, first: int) -> bool:
        """Whether a name is one of those that something is said to be between."""
        return any(
            RELATIONS[h.slot[1]].grounds == "several" and len(h.grounds) > 1
            for h in self.at_word.get(first, ())
        )

    def _at(self, mention: PartMention) -> list[_Holder]:
        """Return the relations to the places next to a part that its sentence says."""
        sentence = self._sentence(mention.first)
        return [
            holder
            for place in mention.places
            for holder in self.at_word.get(place, ())
            if self._sentence(holder.one.phrase.cue[0]) == sentence
        ]

    def _sentence(self, word: int) -> int:
        return bisect_right(self.text.stops, word)

    def _give(self, mention: PartMention, holders: Sequence[_Holder]) -> bool:
        """Give a part to the relation that it fits best; tell whether one could have it."""
        free = [h for h in holders if h.slot not in self.parts and h.is_way]
        if not free:
            return False
        best = min(free, key=lambda h: h.rank(mention))
        self.parts[best.slot] = mention.part
        return True

    def _streets_for(self, mention: PartMention) -> Iterable[LandmarkMention]:
        """Return the streets that a part without one may be of, the most probable first."""
        if not mention.moves:
            return
        stops = self.text.stops
        sentence = self._sentence(mention.first)
        begin = stops[sentence - 1] if sentence else 0
        end = stops[sentence] if sentence < len(stops) else len(self.text.norms)
        at = bisect_left(self.streets_at, mention.first)
        since = max(bisect_left(self.streets_at, begin), at - _RECENT)
        before = max(self.streets[since:at], key=lambda m: (self._is_on(m), m.first), default=None)
        after = self.streets[at] if at < len(self.streets) and self.streets_at[at] < end else None
        if mention.moves == "back":
            after = None
            last = bisect_left(self.names_at, mention.first)
            if before is not None and self.names_at[last - 1 : last] != [before.first]:
                return
        touching = after is not None and after.first - mention.last <= _TOUCHING
        if after is not None and touching and (before is None or self._is_on(after)):
            yield after
        for street in (before, after):
            if street is not None and not self._figure_between(street, mention):
                yield street
        yield from (street for street in (before, after) if street is not None)
        if before is None and after is None and at and sentence:
            earlier = self.streets[at - 1]
            first = stops[sentence - 2] if sentence > 1 else 0
            if earlier.first >= first and self._same_objects(earlier, begin, end):
                yield earlier

    def _is_on(self, street: LandmarkMention) -> bool:
        """Whether something is said to be on a street, rather than near it."""
        return any(
            RELATIONS[h.slot[1]].relation_class == "contact" for h in self.lying[street.first]
        )

    def _figure_between(self, street: LandmarkMention, mention: PartMention) -> bool:
        first, last = sorted((street.first, mention.first))
        return bisect_left(self.figures_at, first) < bisect_left(self.figures_at, last)

    def _same_objects(self, street: LandmarkMention, begin: int, end: int) -> bool:
        """Whether a sentence names no object but those at a street of the sentence before."""
        located = {f for h in self.lying[street.first] for f in h.one.figures}
        first, last = bisect_left(self.figures_at, begin), bisect_left(self.figures_at, end)
        return all(located & set(m.candidates) for m in self.text.figures[first:last])

    def _crossings(self) -> None:
        """Give each crossing of streets that was read its corner."""
        known = {slot[0] for slot in self.parts}
        for holder in self.holders:
            if holder.is_crossing and holder.slot[0] not in known:
                self.parts[holder.slot] = StreetPart("corner")
                known.add(holder.slot[0])

    def _numbers(self) -> None:
        """Give the street of "4400 A", whose house the map does not have, the number."""
        for name in self.text.names:
            if name.number is None:
                continue
            for holder in self.at_word.get(name.first, ()):
                alone = holder.is_way and len(holder.grounds) == 1
                if alone and holder.slot not in self.parts:
                    self.parts[holder.slot] = StreetPart("number", number=name.number)
                    break
