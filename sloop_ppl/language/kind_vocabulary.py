"""Know what kinds of places are called: a table from phrases to the tags of OpenStreetMap."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Any

from sloop_ppl.language.words import fold

__all__ = ["Kind", "KindVocabulary", "kind_vocabulary", "phrase_words"]

_PIECES = re.compile(r"[\w&+]+(?:'\w+)*")
_MOST_SHARERS = 6
_BY_NAME, _BY_TERM = range(2)
_IRREGULAR = {
    "buses": "bus", "cookies": "cookie", "gases": "gas", "movies": "movie", "pies": "pie",
    "smoothies": "smoothie", "men": "man", "women": "woman", "children": "child",
}  # fmt: skip
_SPELLINGS = {
    "bike": "bicycle", "centre": "center", "colour": "color", "counselling": "counseling",
    "doughnut": "donut", "grey": "gray", "harbour": "harbor", "jeweller": "jeweler",
    "jewellery": "jewelry", "kerb": "curb", "neighbourhood":
    "neighborhood", "orthopaedic": "orthopedic", "parlour": "parlor", "storey": "story",
    "theatre": "theater", "traveller": "traveler", "tyre": "tire", "licence": "license",
    "yoghurt": "yogurt",
}  # fmt: skip
"""British spellings, for the names of the presets are American; "bike" is no name of any."""


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of place: tags that a landmark has to have.

    Parameters
    ----------
    name
        What it is called, lower case.
    tags
        Pairs of key and value, all of which must hold. The value ``"*"`` is any value, and
        ``""`` none: the key must be absent. The key ``"kind"`` is `Landmark.kind`.
    modifiers
        Words of the phrase that narrow it down and are not in the tags ("red" of "red house").
    is_fallback
        Whether it counts only where a map has nothing of a surer kind.
    """

    name: str
    tags: tuple[tuple[str, str], ...]
    modifiers: tuple[str, ...] = ()
    is_fallback: bool = False


@dataclass(frozen=True, eq=False)
class KindVocabulary:
    """What kinds of places are called.

    Parameters
    ----------
    by_hand
        Everyday phrases -> their kinds, the surest first; keys are words as `phrase_words` gives
        them.
    by_name
        Names of presets -> their kinds, and terms where no preset has such a name.
    cuisines
        Phrases for what is eaten -> value of the tag ``cuisine``.
    plain
        Ordinary verbs, adjectives and general nouns, no kind when they stand alone.
    plural_only
        Words that are a kind in the plural only ("flats").
    compound
        Heads whose meaning a noun before them changes ("blood bank").
    descriptive
        Words that describe and leave such a head what it is ("big bank").
    keys, known
        Keys of all tags, and the tags.
    """

    by_hand: dict[tuple[str, ...], tuple[Kind, ...]]
    by_name: dict[tuple[str, ...], tuple[Kind, ...]]
    cuisines: dict[tuple[str, ...], str]
    plain: frozenset[str]
    plural_only: frozenset[str]
    compound: frozenset[str]
    descriptive: frozenset[str]
    keys: frozenset[str]
    known: frozenset[tuple[str, str]]


@lru_cache(maxsize=1)
def kind_vocabulary() -> KindVocabulary:
    """Return the kinds that ship with the package."""
    folder = files("sloop_ppl") / "data" / "kinds"
    osm: dict[str, Any] = json.loads((folder / "osm.json").read_text("utf-8"))
    everyday: dict[str, Any] = json.loads((folder / "everyday.json").read_text("utf-8"))
    by_hand: dict[tuple[str, ...], tuple[Kind, ...]] = {}
    for phrases, rows in everyday["kinds"]:
        kinds = tuple(_by_hand(phrases[0], row) for row in rows)
        by_hand |= dict.fromkeys(map(phrase_words, phrases), kinds)
    found: dict[tuple[str, ...], dict[int, list[Kind]]] = {}
    for tags, names, terms in osm["kinds"]:
        kind = Kind(names[0], _tags(tags))
        for tier, phrases in ((_BY_NAME, names), (_BY_TERM, terms)):
            for phrase in phrases:
                found.setdefault(phrase_words(phrase), {}).setdefault(tier, []).append(kind)
    by_name: dict[tuple[str, ...], tuple[Kind, ...]] = {}
    for words, tiers in found.items():
        best = min(tiers)
        # A term that many presets share is too general to name any of them.
        if best == _BY_NAME or len(tiers[best]) <= _MOST_SHARERS:
            by_name[words] = tuple(dict.fromkeys(tiers[best]))
    lists = {*by_hand.values(), *by_name.values()}
    known = {tag for kinds in lists for kind in kinds for tag in kind.tags}
    cuisines = {**osm["cuisines"], **everyday["cuisines"]}
    return KindVocabulary(
        by_hand=by_hand,
        by_name=by_name,
        cuisines={phrase_words(phrase): value for phrase, value in cuisines.items()},
        plain=frozenset(everyday["plain"]),
        plural_only=frozenset(everyday["plural_only"]),
        compound=frozenset(everyday["compound"]),
        descriptive=frozenset(everyday["descriptive"]),
        keys=frozenset(key for key, _ in known),
        known=frozenset(known),
    )


def phrase_words(phrase: str) -> tuple[str, ...]:
    """Return the words of a phrase as they are compared: singular, spelt one way.

    Examples
    --------
    >>> phrase_words("Bike racks"), phrase_words("doctor's surgeries")
    (('bicycle', 'rack'), ('doctor', 'surgery'))
    """
    return tuple(_compared(w) for w in _PIECES.findall(fold(phrase)))


@lru_cache(maxsize=16384)
def _compared(word: str) -> str:
    word = word.removesuffix("'s").replace("'", "")
    if word in _IRREGULAR:
        word = _IRREGULAR[word]
    elif len(word) > 4 and word.endswith("ies"):
        word = word[:-3] + "y"
    elif word.endswith(("ches", "shes", "sses", "xes", "zzes")):
        word = word[:-2]
    elif len(word) > 3 and word.endswith("s") and not word.endswith(("ss", "us", "is")):
        word = word[:-1]
    return _SPELLINGS.get(word, word)


def _by_hand(name: str, row: str) -> Kind:
    tags = row.removeprefix("else ")
    return Kind(name, _tags(tags), is_fallback=tags != row)


def _tags(text: str) -> tuple[tuple[str, str], ...]:
    pairs = (pair.partition("=") for pair in text.split())
    return tuple((key, value) for key, _, value in pairs)
