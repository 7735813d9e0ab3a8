"""Read a said distance: "about 50 feet", "20 to 30 m", "two doors down", "a stone's throw"."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from sloop_ppl.language.lexicon import lexicon
from sloop_ppl.language.values import Distance
from sloop_ppl.language.words import Word

__all__ = ["JUST_PAST", "read_distance", "read_ordinal_distance"]

HOUSE_M: Final = 12.0
"""From door to door along a street: lots of old city blocks are 25 to 50 feet (8 to 15 m) wide."""

CAR_M: Final = 6.0
"""From car to car along a kerb: a parallel parking space is 20 to 22 feet (6.1 to 6.7 m) long."""

TREE_M: Final = 8.0
"""From tree to tree or lamp to lamp along a street: mostly planted 7 to 10 m apart."""

BLOCK_M: Final = 100.0
"""From street to street ("one street over"), as `units_m` has blocks: mostly 80 to 120 m."""

WALKED_IN_A_MINUTE_M: Final = 80.0
"""As estate agents count (80 m a minute, Japan's Fair Competition Code); 1.33 m/s."""

JUST_PAST: Final = Distance(0.0, 25.0, 0.5)
"""What "just" bounds in "just past the bank": no farther than the next house or two."""

_EXACT, _PLAIN, _ABOUT, _COUNTED, _WALKED = 0.1, 0.2, 0.3, 0.3, 0.4
_EXACTLY = frozenset(("exactly", "precisely", "exact"))
_ABOUTS = frozenset(
    ("about", "around", "roughly", "approximately", "approx", "some", "nearly", "almost", "circa",
     "ca", "~", "maybe", "perhaps", "say", "probably", "like", "≈", "just", "only", "barely",
     "another", "good", "mere")
)  # fmt: skip
_NOT_VAGUE = frozenset(("just", "only", "another", "good", "mere"))
_AT_MOST: tuple[tuple[str, ...], ...] = tuple(
    tuple(p.split())
    for p in (
        "within", "less than", "no more than", "not more than", "under", "up to", "at most",
        "at the most", "max", "maximum", "fewer than", "no farther than", "no further than",
        "not farther than", "not further than", "closer than", "nearer than", "inside",
        "short of", "not over",
    )
)  # fmt: skip
_AT_LEAST: tuple[tuple[str, ...], ...] = tuple(
    tuple(p.split())
    for p in (
        "at least", "at the least", "more than", "over", "no less than", "not less than",
        "upwards of", "upward of", "min", "minimum", "no closer than", "not closer than",
        "no nearer than", "not nearer than", "farther than", "further than", "well over",
        "not under", "beyond", "in excess of", "greater than",
    )
)  # fmt: skip
_NEEDS_NUMBER = frozenset(("inside", "beyond"))  # "inside a block of flats" bounds nothing
_BOUNDS: dict[str, list[tuple[tuple[str, ...], str]]] = {}
for _phrases, _side in ((_AT_MOST, "most"), (_AT_LEAST, "least")):
    for _phrase in _phrases:
        _BOUNDS.setdefault(_phrase[0], []).append((_phrase, _side))
for _found in _BOUNDS.values():
    _found.sort(key=lambda bound: -len(bound[0]))
_AFTER: dict[tuple[str, ...], str] = {
    ("or", "so"): "about", ("or", "thereabouts"): "about", ("give", "or", "take"): "about",
    ("more", "or", "less"): "about", ("ish",): "about",
    ("or", "less"): "most", ("max",): "most", ("maximum",): "most", ("tops",): "most",
    ("at", "most"): "most", ("at", "the", "most"): "most", ("or", "under"): "most",
    ("or", "more"): "least", ("+",): "least", ("plus",): "least", ("minimum",): "least",
    ("at", "least"): "least", ("or", "over"): "least", ("min",): "least",
}  # fmt: skip
_SOME = {"couple": (2.0, 3.0), "few": (2.0, 5.0), "several": (3.0, 8.0)}
_TO = frozenset(("to", "-", "–", "—", "or", "till"))
_SIZES = frozenset(("full", "whole", "short", "long", "city", "little", "small", "of", "a", "an",
                    "more", "-", "parking", "good", "big"))  # fmt: skip
_DOTTED = frozenset(("m", "ft", "yd", "yds", "km", "min", "mins", "mi"))
_MINUTES = frozenset(("minute", "minutes", "minute's", "min", "mins", "minutes'"))
_WALKS = frozenset(("walk", "stroll", "walking", "foot", "away", "from", "on", "by"))
_WALKING = _WALKS - {"away", "from"}
_ALONG = frozenset(
    ("down", "up", "over", "along", "away", "in", "further", "farther", "on", "back")
)
_ONWARD = frozenset(("from", "past", "after", "before", "beyond"))
_BUILT = (["flats"], ["apartments"], ["houses"], ["shops"], ["offices"], ["buildings"], ["stores"])
_NSEW = frozenset("nsew")
_ENDS = frozenset(("left", "right", "end", "top", "bottom", "back", "front", "middle", "outside"))
_IDIOMS: Mapping[tuple[str, ...], Distance] = {
    # A stone thrown by hand flies 25 to 50 m; the others are bounds that the words themselves name.
    ("stone's", "throw"): Distance(0.0, 50.0, 0.5),
    ("stones", "throw"): Distance(0.0, 50.0, 0.5),
    ("stone", "throw"): Distance(0.0, 50.0, 0.5),
    ("throwing", "distance"): Distance(0.0, 50.0, 0.5),
    ("hop", "skip", "and", "a", "jump"): Distance(0.0, 100.0, 0.5),
    ("spitting", "distance"): Distance(0.0, 10.0, 0.5),
    ("touching", "distance"): Distance(0.0, 1.0, 0.5),
    ("arm's", "length"): Distance(0.0, 1.0, 0.5),
    ("arm's", "reach"): Distance(0.0, 1.0, 0.5),
    ("arms", "length"): Distance(0.0, 1.0, 0.5),
    ("shouting", "distance"): Distance(0.0, 100.0, 0.5),
    ("hailing", "distance"): Distance(0.0, 100.0, 0.5),
    ("earshot",): Distance(0.0, 100.0, 0.5),
    # Planners count ten minutes on foot as walking distance.
    ("walking", "distance"): Distance(0.0, 10 * WALKED_IN_A_MINUTE_M, 0.5),
}
_IDIOM_LEADS = frozenset(("a", "an", "within", "in", "just", "only", "about", "mere", "at", "like"))
_COUNTED_M: dict[str, float] = {}
for _length, _nouns in (
    (HOUSE_M, "door house home building shop storefront store entrance doorway driveway place lot"),
    (CAR_M, "car vehicle space spot bay truck van"),
    (BLOCK_M, "street"),
    (TREE_M, "one tree lamppost streetlight lamp streetlamp"),
):
    for _noun in _nouns.split():
        _COUNTED_M[_noun] = _COUNTED_M[_noun + "s"] = _length


@dataclass(frozen=True, slots=True)
class _Count:
    """How many of a unit are said, and where the words end."""

    low: float
    high: float
    last: int
    about: bool = False
    bound: str = ""


def read_distance(
    words: Sequence[Word], norms: Sequence[str], i: int, named: Collection[int]
) -> tuple[Distance, int] | None:
    """Return the distance whose words begin at `i`, and the word after them; None if none does.

    Parameters
    ----------
    words, norms
        The text; spelling mended.
    i
        A word.
    named
        Words at which a name begins; no unit is among them.
    """
    idiom = _idiom(norms, i)
    if idiom is not None:
        return idiom
    at, side, share, needs = _lead(words, norms, i)
    count = _amount(words, norms, at, led=at > i and norms[at - 1] == "between")
    if count is None:
        return None
    measured = _unit(words, norms, count.last, named)
    if measured is None or (needs and norms[at] in ("a", "an")):
        return None
    unit_m, unit_share, last = measured
    side = side or count.bound
    after, n = _suffix(norms, last)
    if after in ("most", "least"):
        side = after
    last += n
    half = 0.5 if norms[last : last + 3] == ["and", "a", "half"] else 0.0  # "a block and a half"
    last += 3 if half else 0
    if norms[last : last + 1] == ["away"]:
        last += 1
    if after == "about" or count.about:
        share = max(share or 0.0, _ABOUT)
    vagueness = max(unit_share, share or 0.0) if share != _EXACT else _EXACT
    low, high = (round((n + half) * unit_m, 3) for n in (count.low, count.high))
    if side == "most":
        return Distance(0.0, high, vagueness), last
    if side == "least":
        return Distance(low, math.inf, vagueness), last
    return Distance(low, high, vagueness), last


def read_ordinal_distance(norms: Sequence[str], i: int) -> tuple[Distance, int] | None:
    """Return the distance in "third house down (from)" and the word after it, else None.

    The third house from a place is three houses from it.
    """
    number = _ordinal(norms[i])
    if number is None:
        return None
    at = i + 1
    while at < len(norms) and at < i + 3 and norms[at] in ("parking", "parked", "next"):
        at += 1
    each = _COUNTED_M.get(norms[at]) if at < len(norms) else None
    if each is None:
        return None
    at += 1
    while at < len(norms) and norms[at] in _ALONG:
        at += 1
    if norms[at : at + 1] not in (["from"], ["past"], ["after"], ["before"], ["beyond"]):
        return None
    far = [n for n in norms[at + 1 : at + 3] if n != "the"]
    if far and far[0] in _ENDS:
        return None
    return Distance(number * each, number * each, _COUNTED), at


def _ordinal(norm: str) -> float | None:
    """Return the number of "third" or "3rd", None for another word or one beyond twenty."""
    norm = lexicon().ordinals.get(norm, norm)
    if (
        len(norm) < 5
        and norm[:-2].isdecimal()
        and norm.isascii()
        and norm[-2:] in ("st", "nd", "rd", "th")
    ):
        return float(norm[:-2]) if int(norm[:-2]) <= 20 else None
    return None


def _idiom(norms: Sequence[str], i: int) -> tuple[Distance, int] | None:
    """Return what "(within) a stone's throw" bounds."""
    at = i
    while at < len(norms) and at < i + 3 and norms[at] in _IDIOM_LEADS:
        at += 1
    for n in (5, 2, 1):
        found = _IDIOMS.get(tuple(norms[at : at + n]))
        if found is not None:
            last = at + n
            return found, last + 1 if norms[last : last + 1] == ["away"] else last
    return None


def _lead(
    words: Sequence[Word], norms: Sequence[str], i: int
) -> tuple[int, str, float | None, bool]:
    """Return the first word of the number, which bound it is, how vague, whether to be strict."""
    at, side, share, needs = i, "", None, False
    for _ in range(3):
        if at >= len(norms):
            break
        bound = next(
            (
                (len(phrase), which)
                for phrase, which in _BOUNDS.get(norms[at], ())
                if tuple(norms[at : at + len(phrase)]) == phrase
            ),
            None,
        )
        if bound is not None and not side:
            needs = bound[0] == 1 and norms[at] in _NEEDS_NUMBER
            at, side = at + bound[0], bound[1]
        elif norms[at] in _EXACTLY:
            at, share = at + 1, _EXACT
        elif norms[at] in _ABOUTS:
            share = share if norms[at] in _NOT_VAGUE else _ABOUT
            at += 1
            if norms[at : at + 1] == ["."] and not words[at].spaced:
                at += 1
        elif norms[at] == "between":
            return at + 1, side, share, needs
        else:
            break
    return at, side, share, needs


def _amount(words: Sequence[Word], norms: Sequence[str], at: int, led: bool) -> _Count | None:
    """Return a number or a range of numbers."""
    first = _count(words, norms, at)
    if first is None:
        return None
    at = first.last
    unit = at if norms[at : at + 1] and norms[at] in lexicon().units_m else None
    joint = at + 1 if unit is not None else at
    if joint < len(norms) and (norms[joint] in _TO or (led and norms[joint] == "and")):
        second = _count(words, norms, joint + 1)
        if second is not None and second.high > first.low:
            return replace(second, low=first.low, about=False)
    if led:
        return None
    after, n = _suffix(norms, at)
    if norms[at : at + 2] == ["-", "ish"]:
        after, n = "about", 2
    if after:
        bound = after if after != "about" else ""
        return replace(first, last=at + n, about=first.about or after == "about", bound=bound)
    return first


def _count(words: Sequence[Word], norms: Sequence[str], at: int) -> _Count | None:
    """Return one number: digits, words, "a hundred and fifty", "a few", "one and a half"."""
    known = lexicon().numbers
    if at >= len(norms):
        return None
    value = _number(words[at], norms[at])
    if value is None:
        return None
    article = norms[at] in ("a", "an")
    at += 1
    if article and norms[at : at + 1] and norms[at] in (*_SOME, "dozen", "hundred", "half"):
        value = known[norms[at]]
        at += 1
    low = high = value
    norm = norms[at - 1]
    if norm in _SOME:
        low, high = _SOME[norm]
    if norm == "half" and norms[at : at + 1] in (["a"], ["an"], ["of"]):
        at += 1
    tens = norm in known and 20 <= value < 100
    joint = at + 1 if norms[at : at + 1] == ["-"] else at
    ones = norms[joint] if joint < len(norms) and norms[joint] not in ("a", "an", *_SOME) else ""
    if tens and 1 <= known.get(ones, 0) < 10:
        low = high = value + known[ones]
        at = joint + 1
    if norms[at : at + 1] == ["hundred"]:
        low, high, at = low * 100, high * 100, at + 1
    if norm == "hundred" or norms[at - 1] == "hundred":
        more = at + 1 if norms[at : at + 1] == ["and"] else at
        rest = known.get(norms[more], 0) if more < len(norms) else 0
        if 10 <= rest < 100:
            low, high, at = low + rest, high + rest, more + 1
    if norms[at : at + 3] == ["and", "a", "half"]:
        low, high, at = low + 0.5, high + 0.5, at + 3
    return _Count(low, high, at)


def _number(word: Word, norm: str) -> float | None:
    if word.kind == "number":
        try:
            return float(word.low.replace(",", "")) if len(word.low) < 12 else None
        except ValueError:
            return None
    return lexicon().numbers.get(norm)


def _suffix(norms: Sequence[str], at: int) -> tuple[str, int]:
    """Return what "or so", "or less", "+" after a number or a unit says, and its words."""
    for n in (3, 2, 1):
        found = _AFTER.get(tuple(norms[at : at + n]))
        if found is not None and at + n <= len(norms):
            return found, n
    return "", 0


def _unit(
    words: Sequence[Word], norms: Sequence[str], at: int, named: Collection[int]
) -> tuple[float, float, int] | None:
    """Return metres of the unit at a word, how vague it is, and the word after it."""
    start = at
    while at < len(norms) and at < start + 4 and norms[at] in _SIZES:
        at += 1
    if at >= len(norms) or at in named:
        return None
    norm = norms[at]
    if norm in ("'", "′") and at == start and not words[at].spaced:
        return 0.3048, _PLAIN, at + 1
    if norm in _MINUTES:
        return _walked(norms, at + 1)
    if norm in lexicon().units_m:
        last = at + 1
        if norms[last : last + 1] == ["of"] and norms[last + 1 : last + 2] in _BUILT:
            return None
        dotted = norm in _DOTTED and norms[last : last + 1] == ["."] and last + 1 < len(norms)
        if dotted and not words[last + 1].text[:1].isupper():
            last += 1
        share = _COUNTED if norm.startswith(("block", "step", "pace")) else _PLAIN
        return lexicon().units_m[norm], share, last
    if norm in _COUNTED_M:
        last = at + 1
        while last < len(norms) and norms[last] in _ALONG:
            last += 1
        onward = norms[last] if last < len(norms) else ""
        side = _COUNTED_M[norm] >= HOUSE_M and (onward in lexicon().directions or onward in _NSEW)
        alone = norms[start - 1] in ("a", "an", "one") and _COUNTED_M[norm] < HOUSE_M
        if (onward in _ONWARD or side) and not alone:  # not "a car from Ohio"
            return _COUNTED_M[norm], _COUNTED, last
    return None


def _walked(norms: Sequence[str], at: int) -> tuple[float, float, int] | None:
    """Return what a minute is where it is walked: "two minutes' walk", "a minute away"."""
    if norms[at : at + 1] in (["'"], ["."]):
        at += 1
    if norms[at : at + 1] and norms[at] in _WALKS:
        last = at
        while last < len(norms) and norms[last] in _WALKING:
            last += 1
        return WALKED_IN_A_MINUTE_M, _WALKED, last
    return None
