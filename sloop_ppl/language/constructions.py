"""Put wordings that say one thing in many ways into items that all mean the same.

Each rule looks a bounded number of items ahead, so that time stays linear in the text.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from typing import Final

from sloop_ppl.language.items import Chunk, Cue
from sloop_ppl.language.lexicon import lexicon
from sloop_ppl.language.values import Distance
from sloop_ppl.language.words import Word

__all__ = ["clock_direction", "rewrite"]

_HOURS: Final = (
    "north", "northeast", "northeast", "east", "southeast", "southeast", "south", "southwest",
    "southwest", "west", "northwest", "northwest",
)  # fmt: skip
"""Compass word nearest to where each hour of a clock points whose twelve is north."""

_MEETS = frozenset(
    ("meets", "meet", "crosses", "cross", "hits", "hit", "joins", "join", "intersects",
     "intersect", "touches", "touch", "merges", "merge", "connects", "connect", "bisects", "runs",
     "comes", "come", "met", "crossed", "x")
)  # fmt: skip
_INTO = frozenset(("into", "with", "to", "together", "onto"))
_SMALL = ("det", "skip", "none", "possessive", "same")
_POINTS = frozenset(("point", "spot", "place", "bit"))
_PLACES = ("landmark", "place", "figure")
_GROUNDS = ("landmark", "figure", "place", "pronoun", "robot", "map")
_STRAY = frozenset(
    ("near", "beside", "next", "close", "behind", "front", "across", "between", "under", "below",
     "above", "inside", "outside", "beyond", "around", "adjacent", "against", "towards")
)  # fmt: skip
_ORDINALS = ("st", "nd", "rd", "th")
_LEADING = ("cue", "dir", "distance", "to", "skip")
_DIALS = frozenset(("clock", "dial", "clockface", "watch"))
_TURNED = frozenset(("pointing", "looking", "turned", "faces", "pointed"))
_NEVER_ALONE = frozenset(("near", "front", "next", "beside", "opposite"))
_STRAYS = ("of", "to", "from")
_ON_BLOCK = frozenset(("on", "in", "at", "within", "inside", "along"))
_FAR = 12

Items = list[Chunk]


def clock_direction(norms: Sequence[str], i: int) -> tuple[str, int] | None:
    """Return the compass word of "nine o'clock", and the word after it.

    Source: twelve is north on a map; an hour is 30 degrees clockwise.
    """
    hour = lexicon().numbers.get(norms[i], 0.0) if norms[i] not in ("a", "an") else 0.0
    if norms[i].isdecimal() and norms[i].isascii() and len(norms[i]) < 3:
        hour = float(norms[i])
    if norms[i] == "twelve":
        hour = 12.0
    if not (1 <= hour <= 12 and hour == int(hour)):
        return None
    at = i + 1
    for words in (("o'clock",), ("oclock",), ("o", "clock"), ("o", "'", "clock")):
        if tuple(norms[at : at + len(words)]) == words:
            return _HOURS[int(hour) % 12], at + len(words)
    return None


def rewrite(chunks: Items, words: Sequence[Word], streets: Collection[int]) -> Items:
    """Return the items with each construction as its plain counterpart; linear in the items.

    Parameters
    ----------
    chunks
        The items of a text.
    words
        The words they are made of.
    streets
        Positions in the map of the landmarks that are streets.
    """
    for rule in _RULES:
        rule(chunks, words)
    _on_its_block(chunks, words, streets)
    return _crossings_without_words(chunks, words, streets)


def _kind(chunks: Items, at: int) -> str:
    return chunks[at].kind if 0 <= at < len(chunks) else "end"


def _value(chunks: Items, at: int) -> object:
    return chunks[at].value if 0 <= at < len(chunks) else None


def _past(chunks: Items, at: int, *kinds: str) -> int:
    end = at + _FAR
    while at < end and _kind(chunks, at) in kinds:
        at += 1
    return at


def _word_at(chunks: Items, words: Sequence[Word], at: int) -> str:
    """Return the single word of an item, nothing for longer ones."""
    if not 0 <= at < len(chunks) or chunks[at].last != chunks[at].first + 1:
        return ""
    return words[chunks[at].first].low


def _as(chunks: Items, at: int, kind: str, value: object = None) -> None:
    """Give the item at a position another role."""
    chunks[at] = Chunk(kind, chunks[at].first, chunks[at].last, value)


def _where_they_meet(chunks: Items, words: Sequence[Word]) -> None:
    """Read "where A meets B", "where A and B cross" as "the junction of A and B"."""
    for i, chunk in enumerate(chunks):
        point = _word_at(chunks, words, i) in _POINTS and _kind(chunks, i - 1) == "det"
        if chunk.kind != "where" and not point:
            continue
        first = _past(chunks, i + 1, *_SMALL)
        pointed = _kind(chunks, first) == "pronoun" and _kind(chunks, i - 1) == "landmark"
        if _kind(chunks, first) not in ("landmark", "place") and not pointed:
            continue
        verb = _past(chunks, first + 1, "place", "none", "skip")
        if _kind(chunks, verb) in ("and", "comma"):
            second = _past(chunks, verb + 1, *_SMALL)
            onward = _past(chunks, second + 1, "place", "none", "skip")
            if _kind(chunks, second) in ("landmark", "place") and _meets(chunks, words, onward):
                _as(chunks, i, "junction", "where")
                _as(chunks, verb, "and", "and")
                _as(chunks, onward, "skip")
                _pointless(chunks, words, i)
            continue
        if not _meets(chunks, words, verb):
            continue
        second = verb + 1
        while _word_at(chunks, words, second) in _INTO:
            second += 1
        if _kind(chunks, _past(chunks, second, *_SMALL)) not in ("landmark", "place"):
            continue
        for k in range(verb + 1, second):
            _as(chunks, k, "skip")
        if pointed:  # "on A where it meets B"
            _as(chunks, i, "and", "and")
            _as(chunks, first, "skip")
            _as(chunks, verb, "skip")
        else:
            _as(chunks, i, "junction", "where")
            _as(chunks, verb, "and", "and")
            _pointless(chunks, words, i)


def _meets(chunks: Items, words: Sequence[Word], at: int) -> bool:
    return _word_at(chunks, words, at) in _MEETS


def _pointless(chunks: Items, words: Sequence[Word], at: int) -> None:
    """Pass over "the point" before "where A meets B"."""
    if _word_at(chunks, words, at - 1) in _POINTS and _kind(chunks, at - 1) in ("word", "place"):
        _as(chunks, at - 1, "skip")


def _crossing_with(chunks: Items, words: Sequence[Word]) -> None:
    """Read "the crossing of A with B" as "of A and B"."""
    for i, chunk in enumerate(chunks):
        if chunk.kind != "junction" or _kind(chunks, i + 1) != "of":
            continue
        first = _past(chunks, i + 2, *_SMALL)
        joint = _past(chunks, first + 1, "place", "none")
        second = _past(chunks, joint + 1, *_SMALL)
        both = _kind(chunks, first) == _kind(chunks, second) == "landmark"
        if both and _word_at(chunks, words, joint) in ("with", "at", "by", "x"):
            _as(chunks, joint, "and", "and")


def _between_two(chunks: Items, words: Sequence[Word]) -> None:
    """Read "between A with B", "between A / B" as "between A and B"."""
    for i, chunk in enumerate(chunks):
        if chunk.kind != "cue" or chunk.value.relation != "between":
            continue
        first = _past(chunks, i + 1, *_SMALL, "of")
        joint = _past(chunks, first + 1, "place", "none")
        second = _past(chunks, joint + 1, *_SMALL)
        both = _kind(chunks, first) == _kind(chunks, second) == "landmark"
        if both and _word_at(chunks, words, joint) in ("with", "to", "/", "from"):
            _as(chunks, joint, "and", "and")


def _near_where_it_is(chunks: Items, words: Sequence[Word]) -> None:  # noqa: ARG001
    """Read "near (to) where the bank is" as "near the bank"."""
    for i, chunk in enumerate(chunks):
        if chunk.kind != "where" or _kind(chunks, i - 1) not in ("cue", "of", "to", "from"):
            continue
        ground = _past(chunks, i + 1, *_SMALL, "be")
        after = _past(chunks, ground + 1, "place", "none")
        placed = "be" in (_kind(chunks, k) for k in range(i + 1, ground))
        if _kind(chunks, ground) not in _PLACES or not (placed or _kind(chunks, after) == "be"):
            continue
        for k in range(i, ground):
            if chunks[k].kind in ("where", "be"):
                _as(chunks, k, "skip")
        if not placed:
            _as(chunks, after, "none")


def _stray_prepositions(chunks: Items, words: Sequence[Word]) -> None:
    """Read "beside of", "in front from", "opposite to" as the cue without the small word."""
    for i, chunk in enumerate(chunks):
        if chunk.kind != "cue":
            continue
        stray = _kind(chunks, i + 1) in _STRAYS
        second = _word_at(chunks, words, i + 1)
        stray = stray or (second == "at" and words[chunk.last - 1].low in _NEVER_ALONE)
        stray = stray or (second == "with" and chunk.value.relation in ("next", "across"))
        ground = _past(chunks, i + 2, *_SMALL)
        if stray and chunk.value.relation in _STRAY and _kind(chunks, ground) in _GROUNDS:
            chunks[i] = Chunk("cue", chunk.first, chunks[i + 1].last, chunk.value)
            _as(chunks, i + 1, "none")


def _ways(chunks: Items, words: Sequence[Word]) -> None:  # noqa: ARG001
    """Read "30 m down A from B" as "along A, 30 m from B": a street is a way, no direction."""
    for i, chunk in enumerate(chunks):
        way = chunk.kind == "cue" and chunk.value.relation in ("up", "down", "along")
        street = _past(chunks, i + 1, *_SMALL)
        onward = _past(chunks, street + 1, "place", "none") if way else 0
        if not way or _kind(chunks, street) != "landmark" or _kind(chunks, onward) != "from":
            continue
        if _kind(chunks, _past(chunks, onward + 1, *_SMALL, "where")) not in _GROUNDS:
            continue
        _as(chunks, i, "cue", Cue("along"))
        before = i - 1 if _kind(chunks, i - 1) != "skip" else i - 2
        if _kind(chunks, before) == "distance":
            measured = chunks[before]
            _as(chunks, before, "skip")
            _as(chunks, onward, "cue", Cue("near", distance=measured.value))
        else:
            _as(chunks, onward, "cue", Cue("near"))


def _denied_bounds(chunks: Items, words: Sequence[Word]) -> None:
    """Read "not 20 m from", "shouldn't be more than 20 m from" as "within 20 m of"."""
    for i, chunk in enumerate(chunks):
        far = _past(chunks, i + 1, "be", "skip")
        if chunk.kind != "neg" or _kind(chunks, far) != "distance":
            continue
        bound = chunks[far].value
        number = bound.stated_m is not None and far == i + 1
        if bound.high_m == math.inf or number:
            distance = Distance(0.0, bound.low_m, bound.vagueness)
            _as(chunks, i, "skip")
            _as(chunks, far, "distance", distance)
    del words


def _measured_order(chunks: Items, words: Sequence[Word]) -> None:
    """Read "the first house after the bank": what follows a distance says on which side."""
    for i, chunk in enumerate(chunks):
        if chunk.kind != "distance":
            continue
        word = _word_at(chunks, words, i + 1)
        if word in ("after", "before"):
            _as(chunks, i + 1, "cue", Cue("beyond" if word == "after" else "near"))
        onward = _past(chunks, i + 1, "skip")
        way = _kind(chunks, onward) == "cue" and chunks[onward].value.relation in ("up", "down")
        if way and words[chunks[onward].last - 1].low == "from":  # "three blocks up from the bank"
            _as(chunks, onward, "cue", Cue("near"))
        if not _is_ordinal(words[chunk.first].low):
            continue
        lead = i - 1
        if _kind(chunks, lead) == "det":
            _as(chunks, lead, "skip")
            lead -= 1
        if _kind(chunks, lead) == "cue":  # "at the third house from": that house is no ground
            _as(chunks, lead, "skip")


def _is_ordinal(low: str) -> bool:
    return low in lexicon().ordinals or (low[:1].isdigit() and low[-2:] in _ORDINALS)


def _side_without_cue(chunks: Items, words: Sequence[Word]) -> None:
    """Read ", Elm Street side," as "side of Elm Street": a telegram leaves the cue out."""
    for i, chunk in enumerate(chunks):
        if chunk.kind != "landmark":
            continue
        part = _past(chunks, i + 1, "place", "none")
        if _kind(chunks, part) != "part" or _word_at(chunks, words, part) not in ("side", "sides"):
            continue
        apart = all(_kind(chunks, k) in ("comma", "end", "stop") for k in (i - 1, part + 1))
        if apart:
            chunks[i] = Chunk("cue", chunks[part].first, chunks[part].last, Cue("side"))
            chunks[part] = chunk


def _past_back(chunks: Items, at: int) -> int:
    end = at - _FAR
    while at > end and _kind(chunks, at) in _SMALL:
        at -= 1
    return at


def _is_parking(chunks: Items, words: Sequence[Word]) -> None:
    """Read "is parking behind" as "is behind": what one does is no place."""
    for i, chunk in enumerate(chunks):
        parks = chunk.kind == "place" and _word_at(chunks, words, i) == "parking"
        if parks and _kind(chunks, i - 1) == "be" and _kind(chunks, i + 1) in _LEADING:
            _as(chunks, i, "skip")


def _facing_away(chunks: Items, words: Sequence[Word]) -> None:
    """Pass over "facing away from the bank", which says how something is turned."""
    for i, chunk in enumerate(chunks):
        away = chunk.kind == "cue" and _kind(chunks, i + 1) == "cue"
        if away and chunk.value.relation == "towards" and chunks[i + 1].value.negated:
            _as(chunks, i, "skip")
            _as(chunks, i + 1, "none")
        turned = _word_at(chunks, words, i - 1) in _TURNED
        if chunk.kind == "cue" and turned and words[chunk.first].low == "away":
            _as(chunks, i, "none")


def _clock_turned(chunks: Items, words: Sequence[Word]) -> None:
    """Leave hours alone where twelve is said to point elsewhere than north."""
    hours = [i for i, chunk in enumerate(chunks) if chunk.kind == "clock"]
    if hours:
        _no_dial(chunks, words)
    for i in hours:
        onward = _past(chunks, i + 1, "be", "skip", "det", "word")
        if chunks[i].value != "north" or onward == i + 1 or _kind(chunks, onward) != "dir":
            continue
        if chunks[onward].value[:1] != ("north",):
            for k in hours:
                _as(chunks, k, "none")
            return


def _no_dial(chunks: Items, words: Sequence[Word]) -> None:
    """Pass over "(is) the centre of a clock face", which is no place, where hours are said."""
    for i, chunk in enumerate(chunks):
        if chunk.kind not in ("word", "place") or _word_at(chunks, words, i) not in _DIALS:
            continue
        _as(chunks, i, "none")
        if _word_at(chunks, words, i + 1) == "face":
            _as(chunks, i + 1, "none")
        for k in range(i - 1, max(-1, i - _FAR // 2), -1):
            if chunks[k].kind not in ("det", "of", "skip", "dir", "cue"):
                break
            _as(chunks, k, "skip")


_RULES: tuple[Callable[[Items, Sequence[Word]], None], ...] = (
    _is_parking, _clock_turned, _where_they_meet, _crossing_with, _between_two, _near_where_it_is,
    _facing_away, _ways, _denied_bounds, _measured_order, _stray_prepositions, _side_without_cue,
)  # fmt: skip


def _on_its_block(chunks: Items, words: Sequence[Word], streets: Collection[int]) -> None:
    """Read "on the same block as X", "on X's block", "in the block of X" as "near X"."""
    for i, chunk in enumerate(chunks):
        if chunk.kind != "cue" or chunk.value.relation not in _ON_BLOCK or chunk.value.negated:
            continue
        at = _past(chunks, i + 1, *_SMALL)
        if _kind(chunks, at) == "landmark" and not _is_street(chunks, at, streets):
            mark = _word_at(chunks, words, at + 1) == "'"
            block = at + 2 if mark else at + 1
            owns = mark or words[chunks[at].last - 1].low.endswith("'s")
            if owns and _word_at(chunks, words, block) == "block":
                _as(chunks, i, "cue", Cue("near"))
                _as(chunks, block, "none")
            continue
        same = any(_kind(chunks, k) == "same" for k in range(i + 1, at))
        definite = same or any(_value(chunks, k) in ("the", "this") for k in range(i + 1, at))
        if _word_at(chunks, words, at) in ("city", "whole"):
            at += 1
        link = at + 1
        ground = _past(chunks, link + 1, *_SMALL)
        if _word_at(chunks, words, at) != "block" or _kind(chunks, ground) not in _PLACES:
            continue
        definite = definite and not _is_street(chunks, ground, streets)
        alike = same and _word_at(chunks, words, link) in ("as", "with")
        if alike or (definite and _kind(chunks, link) == "of"):
            chunks[i] = Chunk("cue", chunk.first, chunks[link].last, Cue("near"))
            for k in range(i + 1, link + 1):
                _as(chunks, k, "none")


def _crossings_without_words(
    chunks: Items, words: Sequence[Word], streets: Collection[int]
) -> Items:
    """Read "A/B", "A x B", "on A at B" as "A and B"; a bare "A & B" is their corner."""
    if not streets:
        return chunks
    read: Items = []
    for i, chunk in enumerate(chunks):
        first = _street_before(chunks, i, streets)
        second = _past(chunks, i + 1, "det", "none")
        joined = first >= 0 and _is_street(chunks, second, streets)
        on = joined and _past_back(chunks, first - 1)
        led = _kind(chunks, on) == "cue" and chunks[on].value.relation in ("on", "at", "in")
        at = joined and chunk.kind == "cue" and chunk.value.relation == "at"
        if joined and (_word_at(chunks, words, i) in ("/", "x") or (at and led)):
            chunk = Chunk("and", chunk.first, chunk.last, "and")
            chunks[i] = chunk
        if joined and chunk.kind == "and":
            lead = _past_back(chunks, first - 1)
            after = _past(chunks, second + 1, "place", "none")
            bare = _kind(chunks, lead) in ("end", "stop", "figure") or (
                _kind(chunks, lead) == "comma"
                and _kind(chunks, lead - 1) in ("figure", "be", "end")
            )
            if bare and _kind(chunks, after) in ("end", "stop", "comma"):
                read.insert(
                    len(read) - (i - first), Chunk("junction", chunk.first, chunk.last, "&")
                )
        read.append(chunk)
    return read


def _street_before(chunks: Items, at: int, streets: Collection[int]) -> int:
    """Return the position of the street that ends before an item, -1 if none does."""
    before = at - 1
    while before > at - 4 and _kind(chunks, before) in ("place", "none"):
        before -= 1
    return before if _is_street(chunks, before, streets) else -1


def _is_street(chunks: Items, at: int, streets: Collection[int]) -> bool:
    return _kind(chunks, at) == "landmark" and chunks[at].value.candidates[0] in streets
