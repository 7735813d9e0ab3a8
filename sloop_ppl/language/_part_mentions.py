"""Find the words that name a part of a street, a crossing or a block."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

from sloop_ppl.language.lexicon import lexicon
from sloop_ppl.language.linking import LandmarkMention
from sloop_ppl.language.relations import RELATIONS
from sloop_ppl.language.street_parts import StreetPart, StreetPartKind

__all__ = ["PartMention", "find_parts"]

Moves: TypeAlias = Literal["", "back", "any"]

_SIDES = frozenset(("side", "sidewalk", "pavement", "kerb", "curb"))
_CORNERS = frozenset(("corner", "intersection", "junction", "crossing", "crossroads"))
_WAYS = frozenset(("street", "road", "avenue", "lane", "boulevard", "alley", "st", "rd", "ave"))
_LETTERS: Final = {"n": "north", "s": "south", "e": "east", "w": "west"}
_MIDDLES = frozenset(("middle", "centre", "center", "midpoint"))
_HALFWAY = frozenset(("halfway", "midway"))
_ALONG = frozenset(("up", "down", "along", "through"))
_LAST = frozenset(("dead", "very", "far", "closed", "furthest", "farthest"))
_ARTICLES = frozenset(
    ("the", "a", "an", "this", "that", "its", "it's", "their", "one", "any", "either")
)
_NEAR = frozenset(("at", "on", "near", "by", "in", "to", "towards", "toward", "off", "beside",
                   "from", "of", "just", "right", "nearby"))  # fmt: skip
_JOINS = frozenset(("of", "with", "at", "by", "and", "&", "+", "on", "between", "in", "where"))
_TURNS = frozenset(("around", "round", "turn", "turned", "turns", "turning", "rounded", "cut"))
_DENIES = frozenset(("not", "isn't", "aren't", "never", "nowhere", "away", "wasn't"))
_GO_ON = ("be", "and", "or", "but", "sub", "which", "where", "det", "possessive", "pronouns", "of",
          "to", "from", "neg", "only", "subjects", "robot")  # fmt: skip
_PARITY: Final = {"odd": 1, "even": 2}
_NUMBERED = frozenset(("numbered", "number", "numbers", "house", "houses", "addresses", "address"))
_HAVING = frozenset(("with", "where", "having", "for", "has"))
_LOOKS = 8
"""Words that a part may reach to either side of its noun."""


@dataclass(frozen=True)
class PartMention:
    """Words that name a part.

    Parameters
    ----------
    part
        What they name.
    first, last
        Half-open range of words.
    places
        First words of the places that it is said to be a part of.
    moves
        Where the street may stand when no place is named next to it and no relation was read from
        its words: nowhere, ``"back"`` as the place named last, or ``"any"`` where in its sentence
        or in the one before.
    denied
        Whether it is what remains where corners are denied: "not at a corner".
    """

    part: StreetPart
    first: int
    last: int
    places: tuple[int, ...] = ()
    moves: Moves = ""
    denied: bool = False


def find_parts(
    norms: Sequence[str], places: Sequence[LandmarkMention], ways: Collection[int]
) -> list[PartMention]:
    """Return the parts that a text names, in order; linear in the words.

    Parameters
    ----------
    norms
        Its words, spelling mended.
    places
        The names in it.
    ways
        First words of those that name streets.
    """
    return _Finder(norms, places, ways).parts()


class _Finder:
    """The words of one text, each name as one word."""

    def __init__(
        self, norms: Sequence[str], places: Sequence[LandmarkMention], ways: Collection[int]
    ) -> None:
        self.ways = ways
        self.words: list[str] = []
        self.starts: list[int] = []  # first word of each, in the text
        self.ends: list[int] = []
        self.owners: set[int] = set()  # names that end in 's
        self.named: dict[int, int] = {}  # position here -> first word of the name
        short, known = lexicon().short, {m.first: m for m in places}
        i = 0
        while i < len(norms):
            mention = known.get(i)
            last = i + 1 if mention is None else mention.last
            if mention is not None:
                self.named[len(self.words)] = i
                if norms[last - 1].endswith("'s") or norms[last : last + 1] == ["'"]:
                    self.owners.add(len(self.words))
            self.words.append("" if mention else short.get(norms[i], norms[i]))
            self.starts.append(i)
            self.ends.append(last)
            i = last

    def parts(self) -> list[PartMention]:
        """Return what is named, the later of two that share words left out."""
        found: list[PartMention] = []
        for at, word in enumerate(self.words):
            read = None
            if word in _SIDES:
                read = self._side(at)
            elif word in _CORNERS or word == "corners":
                read = self._corner(at)
            elif word == "end":
                read = self._end(at)
            elif word == "block":
                read = self._block(at)
            elif word == "midblock":
                read = self._made(StreetPart("mid-block"), at, at + 1, moves="any")
            elif word == "one" and found and at:
                self._that_one(at, found)
            if read is not None and not (found and read.first < found[-1].last):
                found.append(read)
        return found

    def _made(
        self,
        part: StreetPart,
        first: int,
        last: int,
        places: Sequence[int] = (),
        *,
        moves: Moves = "",
        denied: bool = False,
    ) -> PartMention:
        words = tuple(self.named[k] for k in places)
        first, last = self.starts[first], self.ends[last - 1]
        return PartMention(part, first, last, words, moves, denied)

    def _word(self, at: int) -> str:
        return self.words[at] if 0 <= at < len(self.words) else "."

    def _is_way(self, at: int) -> bool:
        return at in self.named and self.named[at] in self.ways

    def _goes_on(self, at: int) -> bool:
        """Whether a phrase may end before a word: no noun follows ("side entrance")."""
        word = self._word(at)
        if at in self.named or not word.isalpha():
            return True
        known = lexicon()
        return word in known.longest_cues or not known.classes.get(word, frozenset()).isdisjoint(
            _GO_ON
        )

    def _bearing(self, at: int) -> tuple[float | None, int]:
        """Return the direction that ends before a word, and its first word.

        Left and right are sides of the map only next to its upper or lower part.
        """
        known = lexicon().directions
        first, sides = at, []
        while first > max(0, at - _LOOKS):
            word = self._word(first - 1)
            side = known.get(word) or _LETTERS.get(word)
            if side is None and word not in ("-", "."):
                break
            if side is None and not (known.get(self._word(first - 2)) or self._letter(first - 2)):
                break
            first -= 1
            sides += [side] if side else []
        records = [RELATIONS[side] for side in sides]
        upright = any(r.is_compass for r in records)
        angles = []
        for record in records:
            if record.needs_frame and upright and record.of_map:
                record = RELATIONS[record.of_map]
            if record.bearing_rad is not None:
                angles.append(record.bearing_rad)
        east, north = sum(map(math.cos, angles)), sum(map(math.sin, angles))
        if not sides:
            return None, at
        return (math.atan2(north, east) if math.hypot(east, north) > 0.5 else None), first

    def _letter(self, at: int) -> bool:
        return self._word(at) in _LETTERS

    def _of(self, at: int) -> tuple[str, int, int]:
        """Return what follows "of": a ``name``, ``way``, ``block``, ``it``, ``other`` or nothing.

        The second is where it stands, the third the word after it.
        """
        if self._word(at) != "of":
            return "", at, at
        onward = at + 1
        while self._word(onward) in _ARTICLES and onward < at + 3:
            onward += 1
        if onward in self.named:
            return "name", onward, onward + 1
        word = self._word(onward)
        kind = "way" if word in _WAYS else word if word in ("block", "it") else "other"
        return kind, onward, onward + 1

    def _governed(self, part: StreetPart, first: int, last: int, bare: Moves) -> PartMention | None:
        """Return a part of what follows "of" or stands before with 's; else of nothing by name."""
        kind, at, after = self._of(last)
        if kind == "name":
            return self._made(part, first, after, (at,)) if self._is_way(at) else None
        if kind in ("other", "block"):
            return None
        if kind in ("way", "it"):
            return self._made(part, first, after, moves="any" if kind == "way" else "")
        if first - 1 in self.owners:
            return self._made(part, first, last, (first - 1,)) if self._is_way(first - 1) else None
        return self._made(part, first, last, moves=bare) if self._goes_on(last) else None

    def _side(self, at: int) -> PartMention | None:
        """Read "the north side of A", "A's north side", "the odd(-numbered) side"."""
        parity, first = self._parity_before(at)
        if parity:
            return self._governed(StreetPart("side", None, parity), first, at + 1, "any")
        bearing, first = self._bearing(at)
        if bearing is not None:
            return self._governed(StreetPart("side", bearing), first, at + 1, "back")
        kind, where, after = self._of(at + 1)
        parity, last = self._parity_after(after)
        if not parity or kind in ("other", "block", "it"):
            return None
        places = (where,) if kind == "name" and self._is_way(where) else ()
        if kind == "name" and not places:
            return None
        part = StreetPart("side", None, parity)
        return self._made(part, at, last, places, moves="" if places else "any")

    def _parity_before(self, at: int) -> tuple[int, int]:
        first = at
        while first > at - 3 and self._word(first - 1) in (*_NUMBERED, "-"):
            first -= 1
        parity = _PARITY.get(self._word(first - 1), 0)
        return parity, first - 1 if parity else at

    def _parity_after(self, at: int) -> tuple[int, int]:
        if self._word(at) not in _HAVING:
            return 0, at
        onward = at + 1
        while self._word(onward) in _ARTICLES or self._word(onward) == "all":
            onward += 1
        parity = _PARITY.get(self._word(onward), 0)
        last = onward + 1
        while self._word(last) in _NUMBERED:
            last += 1
        return (parity, last) if last > onward + 1 else (0, at)

    def _corner(self, at: int) -> PartMention | None:
        """Read "the SW corner of A", "near the corner", "not at a corner"."""
        bearing, first = self._bearing(at)
        lead = first - 1
        while self._word(lead) in _ARTICLES:
            lead -= 1
        if self._word(lead) in _TURNS or self._word(at + 1) == "from":
            return None
        kind, where, after = self._of(at + 1)
        if kind == "block":
            of_block: StreetPartKind = "corner" if bearing is None else "block-corner"
            return self._made(StreetPart(of_block, bearing), first, after, moves="any")
        joined = self._joined(at + 1)
        denied = self._denied(lead)
        if denied is not None and not joined and kind in ("", "way"):
            return self._made(
                StreetPart("mid-block"), denied, max(at + 1, after), moves="any", denied=True
            )
        if self._word(at) == "corners":
            return None
        part = StreetPart("corner", bearing)
        if joined:
            return self._made(part, first, joined[-1] + 1, joined)
        led = bearing is not None or self._word(lead) in _NEAR
        if kind == "other" or where in self.named or not led:
            return None
        if first - 1 in self.owners:
            return None
        if kind == "way":
            return self._made(part, first, after, moves="any")
        return self._made(part, first, at + 1, moves="back") if self._goes_on(at + 1) else None

    def _joined(self, at: int) -> tuple[int, ...]:
        """Return the streets of "(corner) of A and B", "with A", "A and B"."""
        found: list[int] = []
        onward = at
        while onward < at + 2 * _LOOKS and len(found) < 3:
            step = onward
            while self._word(step) in _JOINS or self._word(step) in _ARTICLES:
                step += 1
            if step not in self.named or (step == onward and found):
                break
            if self._word(onward) != "of" and not found and step > onward + 1:
                break
            if self._word(onward) in ("on", "in", "at", "by") and found:
                break
            found.append(step)
            onward = step + 1
            while self._word(onward) in _WAYS:
                onward += 1
        return tuple(found) if found and all(self._is_way(k) for k in found) else ()

    def _denied(self, lead: int) -> int | None:
        """Return where "not at" stands, before which "a corner" is denied; None if it is not."""
        for k in range(lead, lead - 4, -1):
            word = self._word(k)
            if word in _DENIES:
                return k
            if k in self.named or not (
                word in _NEAR or word in ("close", "really", "quite", "very", "even")
            ):
                return None
        return None

    def _that_one(self, at: int, found: list[PartMention]) -> None:
        """Read ", the northwest one" as which of the corners spoken of before."""
        bearing, first = self._bearing(at)
        before = found[-1]
        near = self.starts[at] - before.last <= _LOOKS
        if bearing is None or before.part.kind != "corner" or not near:
            return
        if before.part.bearing_rad is None and self._word(first - 1) == "the":
            found[-1] = replace(before, part=StreetPart("corner", bearing))

    def _end(self, at: int) -> PartMention | None:
        """Read "the (north, dead, far) end of A", "at the south end"."""
        first = at
        while self._word(first - 1) in _LAST:
            first -= 1
        bearing, first = self._bearing(first)
        while self._word(first - 1) in _LAST:
            first -= 1
        part = StreetPart("end", bearing)
        led = self._word(first - 1) == "the" and self._word(first - 2) in _NEAR - {"in", "by"}
        if bearing is None and not led and self._of(at + 1)[0] == "":
            return None
        return self._governed(part, first, at + 1, "back")

    def _block(self, at: int) -> PartMention | None:
        """Read "mid-block", "the middle of the block", "on the same block as X", "X's block"."""
        before = self._word(at - 1)
        hyphen = before == "-" and self._word(at - 2) == "mid"
        if before == "mid" or hyphen:
            return self._middle(at - 2 if hyphen else at - 1, at + 1)
        if at - 1 in self.owners:
            return self._made(StreetPart("block"), at, at + 1, (at - 1,))
        first = at
        while self._word(first - 1) in ("long", "whole", "city", "same"):
            first -= 1
        same = self._word(first) == "same" or "same" in self.words[first:at]
        onward = at + 2 if (self._word(at + 1) in ("as", "with") and same) else 0
        kind, where, _ = self._of(at + 1)
        if onward or (kind == "name" and not self._is_way(where) and not self._measured(first)):
            where = onward or where
            while self._word(where) in _ARTICLES:
                where += 1
            places = (where,) if where in self.named else ()
            return self._made(StreetPart("block"), first, where, places)
        while self._word(first - 1) in _ARTICLES:
            first -= 1
        if self._word(first - 1) == "of" and self._word(first - 2) in _MIDDLES:
            return self._middle(first - 2, at + 1)
        if self._word(first - 1) in _ALONG:
            half = first - 2
            if self._word(half) in _HALFWAY:
                return self._middle(half, at + 1)
            if self._word(half) == "way" and "half" in (self._word(half - 1), self._word(half - 2)):
                return self._middle(half - 1, at + 1)
        return None

    def _measured(self, first: int) -> bool:
        """Whether a block is a measure or has a number: "a block of", "the 1200 block of"."""
        return self._word(first - 1) not in ("the", "this", "that") and first - 1 not in self.owners

    def _middle(self, first: int, last: int) -> PartMention:
        kind, where, after = self._of(last)
        part = StreetPart("mid-block")
        if kind == "name" and self._is_way(where):
            return self._made(part, first, after, (where,))
        return self._made(part, first, last, moves="any")
