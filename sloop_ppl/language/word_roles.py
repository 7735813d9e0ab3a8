"""Tell what role a word plays before it is compared with names: measure, person, place, or any."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from sloop_ppl.language.lexicon import Lexicon, lexicon
from sloop_ppl.language.words import Word

__all__ = ["ALWAYS_CAPITAL", "BARE", "PERSONS", "Roles", "find_roles"]

PERSONS = frozenset((
    "adult", "adults", "ambulance", "aunt", "aunty", "auntie", "baby", "babies", "boss", "boy",
    "boys", "boyfriend", "brother", "brothers", "buddy", "child", "children", "colleague", "cop",
    "cops", "cousin", "cousins", "customer", "dad", "daddy", "daughter", "doctor", "driver",
    "everybody", "everyone", "family", "father", "folks", "friend", "friends", "gentleman", "girl",
    "girls", "girlfriend", "grandad", "granddad", "granddaughter", "grandfather", "grandma",
    "grandmother", "grandpa", "grandparents", "grandson", "granny", "guard", "guest", "guests",
    "guy", "guys", "husband", "kid", "kids", "ladies", "lady", "lads", "man", "mate", "men", "mom",
    "mommy", "mother", "mum", "mummy", "neighbor", "neighbors", "neighbour", "neighbours",
    "nephew", "niece", "nobody", "officer", "parents", "passenger", "passengers", "patient",
    "people", "person", "pilot", "police", "rider", "sister", "sisters", "somebody", "someone",
    "son", "sons", "stranger", "student", "students", "suspect", "teacher", "teenager", "toddler",
    "tourist", "tourists", "twins", "uncle", "victim", "visitor", "waiter", "waitress", "wife",
    "witness", "woman", "women", "worker", "workers",
))  # fmt: skip
"""Who is spoken of; a name of one such word is a name only where it is written as one."""

ALWAYS_CAPITAL = frozenset((
    "i", "i'm", "i've", "i'll", "i'd", "ok", "sms", "gps", "tv", "suv", "am", "pm",
    "monday", "tuesday", "wednesday", "thursday", "friday", "saturday", "sunday",
    "january", "february", "march", "april", "may", "june", "july", "august", "september",
    "october", "november", "december", "christmas", "easter", "english", "french", "german",
    "spanish", "italian", "chinese", "japanese", "korean", "russian", "arabic", "american",
    "british", "swedish", "finnish", "dutch", "polish", "turkish", "indian", "mexican", "thai",
))  # fmt: skip
"""What English writes with a capital whether or not it names a place."""

BARE = frozenset((
    "accident", "air", "all", "alone", "average", "bed", "board", "call", "case", "charge", "class",
    "cold", "course", "danger", "dark", "day", "daylight", "dinner", "display", "duty", "fact",
    "fire", "first", "fist", "foot", "free", "general", "ground", "hand", "hold", "home", "hurry",
    "ice", "last", "least", "line", "love", "luck", "lunch", "midnight", "mind", "mistake", "money",
    "most", "motion", "night", "noon", "once", "order", "own", "pain", "panic", "paper", "part",
    "peace", "person", "place", "plain", "private", "public", "purpose", "rain", "red", "rest",
    "risk", "road", "sale", "schedule", "school", "sea", "service", "shock", "sight", "snow",
    "speed", "spring", "summer", "sun", "tears", "time", "top", "total", "trouble", "vacation",
    "way", "work", "winter",
))  # fmt: skip
"""Nouns that stand without an article after a preposition: "on fire", "at home"."""

_TITLE_SHARE = 0.3
_LINKERS = frozenset(("from", "between", "at", "off", "via", "where"))
_VAGUE_ENDS = frozenset(("of", "to", "with", "than"))
_TO_PLACES = frozenset((
    "next", "close", "closer", "closest", "adjacent", "near", "nearer", "nearest", "opposite",
    "parallel", "nr", "beside",
))  # fmt: skip
_JUNCTIONS = frozenset(("between", "corner", "corners", "intersection", "junction", "crossing"))
_JOINING = frozenset(("and", "&", "/", "+", "or", "nor"))
_REACH = 8
_NUMBER_LEADS = frozenset(("number", "no", "nr", "nos", "#", "numbers", "num", "house"))


@dataclass(frozen=True, slots=True)
class Roles:
    """What is known of each word of a text before names are looked up.

    Parameters
    ----------
    capital
        Whether it is written with a capital that a sentence does not explain.
    placed
        Whether it stands where a place is expected: after "near", "at the", "corner of A and".
    indefinite
        Whether "a", "an", "some" or a number leads it.
    measure
        Whether it belongs to a measure ("50 metres", "20 to 30 m", "25 years").
    numbered
        Whether a word before says that a number of a house follows ("number 12").
    cased
        Whether the text uses capitals for names.
    """

    capital: Sequence[bool]
    placed: Sequence[bool]
    indefinite: Sequence[bool]
    measure: Sequence[bool]
    numbered: Sequence[bool]
    cased: bool

    def named(self, at: int) -> bool:
        """Whether the writer marks a word as a name, or puts it where a place belongs."""
        return self.capital[at] or self.placed[at]


def find_roles(words: Sequence[Word]) -> Roles:
    """Return the roles of the words of a text; linear in the words."""
    initial = [_is_initial(words, i) for i in range(len(words))]
    inner = [
        w
        for w, first in zip(words, initial, strict=True)
        if w.kind == "word" and not first and w.low not in ALWAYS_CAPITAL
    ]
    upper = sum(w.text[:1].isupper() for w in inner)
    cased = 0 < upper <= (1 - _TITLE_SHARE) * len(inner) or (upper > 0 and len(inner) < 4)
    capital = [
        cased
        and w.kind == "word"
        and not first
        and w.text[:1].isupper()
        and w.low not in ALWAYS_CAPITAL
        for w, first in zip(words, initial, strict=True)
    ]
    ends = _cue_ends(lexicon())
    placed, indefinite = [], []
    for i in range(len(words)):
        found = _before(words, i, ends)
        placed.append(found[0])
        indefinite.append(found[1])
    numbered = [_is_numbered(words, i) for i in range(len(words))]
    return Roles(capital, placed, indefinite, _measures(words), numbered, cased)


def _is_initial(words: Sequence[Word], at: int) -> bool:
    """Whether a sentence, or what is written like one, begins at a word."""
    return (
        at == 0 or words[at].breaks or (words[at - 1].low in ".!?:;-–—()\"“'" and _ends(words, at))
    )


def _ends(words: Sequence[Word], at: int) -> bool:
    """Whether the mark before a word ends something, unlike that of "St. Anne" or "Hi-Lo"."""
    if words[at - 1].low == "." and at > 1:
        known = lexicon().abbreviations
        return words[at - 2].low not in known and len(words[at - 2].low) > 1
    return words[at].spaced or words[at - 1].low in '("“'


@lru_cache(maxsize=4)
def _cue_ends(known: Lexicon) -> frozenset[str]:
    """Return the words that cues end in, after which a place stands."""
    houses = {w for w, classes in known.classes.items() if "houses" in classes} - {"for"}
    return (frozenset(form[-1] for form in known.cues) | _LINKERS | houses) - _VAGUE_ENDS


@lru_cache(maxsize=4)
def _sided(known: Lexicon) -> frozenset[str]:
    """Return the words of sides and parts, after which "of" leads to a place."""
    parts = {w for w, classes in known.classes.items() if classes & {"parts", "junctions"}}
    return frozenset({*known.directions, *parts, "front", "outside", "inside", "out", "ahead"})


def _before(words: Sequence[Word], at: int, ends: frozenset[str]) -> tuple[bool, bool]:
    """Return whether a place is expected at a word, and whether any of a kind is spoken of."""
    i = at - 1
    indefinite = False
    while (
        i >= 0
        and at - i < 4
        and (
            words[i].low in ("the", "a", "an", "some", "that", "old")
            or (words[i].low == "." and i + 1 < at)
        )
    ):
        indefinite = indefinite or words[i].low in ("a", "an", "some")
        i -= 1
    if i < 0:
        return False, indefinite
    word = words[i]
    if word.kind == "number" and not word.low[-1:].isalpha():
        return False, True
    if word.low in ends:
        return True, indefinite
    if word.low in _VAGUE_ENDS:
        led = words[i - 1].low if i else ""
        sided = word.low == "of" and led in _sided(lexicon())
        return sided or (word.low == "to" and led in _TO_PLACES), indefinite
    if word.low in _JOINING:
        low = max(0, i - _REACH)
        joined = any(w.low in _JUNCTIONS or w.low in ends for w in words[low:i])
        return joined, indefinite
    compass = word.low in lexicon().compass or word.low in ("n", "s", "e", "w", "st", "saint")
    if compass and i > 0:
        return words[i - 1].low in ends, indefinite
    return False, indefinite


def _is_numbered(words: Sequence[Word], at: int) -> bool:
    if at == 0:
        return False
    before = words[at - 1]
    if before.low == "." and at > 1:
        before = words[at - 2]
        return before.low in ("no", "nr", "num")
    return before.low in _NUMBER_LEADS


_TIMES = frozenset((
    "am", "pm", "o'clock", "oclock", "second", "seconds", "sec", "secs", "minute", "minutes", "min",
    "mins", "hour", "hours", "hr", "hrs", "day", "days", "week", "weeks", "month", "months", "year",
    "years", "percent", "degree", "degrees", "kilo", "kilos", "kg", "pound", "pounds", "euro",
    "euros", "dollar", "dollars", "times", "cm", "mm", "centimetres", "centimeters", "inch",
    "inches", "mph", "kmh", "litre", "litres", "people", "persons",
))  # fmt: skip
_RANGES = frozenset(("to", "or", "-", "–", "and"))


def _measures(words: Sequence[Word]) -> list[bool]:
    """Return which words belong to a measure: its numbers and its unit."""
    known = lexicon()
    measure = [False] * len(words)
    for i, word in enumerate(words):
        if word.low not in known.units_m and word.low not in _TIMES and word.low != "%":
            continue
        first = i
        while (
            first > 0
            and i - first < 6
            and (
                words[first - 1].low in known.numbers
                or (words[first - 1].kind == "number" and not words[first - 1].low[-1:].isalpha())
                or (first < i and words[first - 1].low in _RANGES and _is_number(words, first - 2))
                or (first == i and words[first - 1].low == "-")
            )
        ):
            first -= 1
        if first < i:
            measure[first : i + 1] = [True] * (i + 1 - first)
    return measure


def _is_number(words: Sequence[Word], at: int) -> bool:
    return at >= 0 and (words[at].kind == "number" or words[at].low in lexicon().numbers)
