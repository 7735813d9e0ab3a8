"""The closed classes of words and the cue vocabulary, read from their data files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Any

__all__ = ["Lexicon", "PlaceKind", "camel_words", "lexicon"]

_CLASSES = (
    "be", "neg", "too", "only", "and", "or", "but", "sub", "which", "where", "houses", "pronouns",
    "plural_pronouns", "robot", "map", "route", "route_ing", "see", "det", "possessive", "same",
    "parts", "junctions", "of", "to", "from", "subjects",
)  # fmt: skip


@dataclass(frozen=True)
class PlaceKind:
    """A kind of place that a map may hold: how it is said and how the map shows it.

    Parameters
    ----------
    words : what it is called, canonical words joined by a space.
    names : words in a landmark's name that give it away.
    amenities : values of the property ``amenity``.
    kinds : kinds of landmark.
    """

    name: str
    words: tuple[str, ...]
    names: tuple[str, ...] = ()
    amenities: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()


@dataclass(frozen=True)
class Lexicon:
    """Everything the rule parser knows about English.

    Parameters
    ----------
    classes : word -> the closed classes it belongs to.
    directions : word -> canonical relation, such as ``"upper" -> "top"``.
    cues : word tuples -> (canonical relation, whether the form itself negates).
    abbreviations : short word -> full word.
    units_m : unit -> metres.
    numbers : number word -> value.
    colours : words for colours.
    object_kinds : noun or make -> kind of object.
    place_kinds : kinds of places, in file order.
    generic, stop, compass, common : words that weigh little, nothing, or need company in names.
    closed : every word above, those that spelling is corrected to.
    plain : everyday words that are never corrected.
    """

    classes: Mapping[str, frozenset[str]]
    directions: Mapping[str, str]
    cues: Mapping[tuple[str, ...], tuple[str, bool]]
    abbreviations: Mapping[str, str]
    ordinals: Mapping[str, str]
    units_m: Mapping[str, float]
    numbers: Mapping[str, float]
    colours: frozenset[str]
    object_kinds: Mapping[str, str]
    place_kinds: tuple[PlaceKind, ...]
    intensifiers: frozenset[str]
    copula: frozenset[str]
    generic: frozenset[str]
    stop: frozenset[str]
    compass: frozenset[str]
    common: frozenset[str]
    closed: frozenset[str]
    plain: frozenset[str]


def camel_words(symbol: str) -> list[str]:
    """Return the lower-case words of a CamelCase symbol.

    Examples
    --------
    >>> camel_words("GreenToyota"), camel_words("SUV2")
    (['green', 'toyota'], ['suv'])
    """
    words: list[str] = []
    for i, letter in enumerate(symbol):
        starts = letter.isupper() and (
            not words or not symbol[i - 1].isupper() or symbol[i + 1 : i + 2].islower()
        )
        if not letter.isalpha():
            words.append("")
        elif starts or not words:
            words.append(letter.lower())
        else:
            words[-1] += letter.lower()
    return [w for w in words if w]


@lru_cache(maxsize=1)
def lexicon() -> Lexicon:
    """Return the lexicon that ships with the package."""
    data = files("sloop_ppl") / "data"
    words: dict[str, Any] = json.loads((data / "words.json").read_text("utf-8"))
    cues = _cues(json.loads((data / "cues.json").read_text("utf-8"))["cues"])
    classes: dict[str, set[str]] = {}
    for name in _CLASSES:
        for word in words[name]:
            classes.setdefault(word, set()).add(name)
            if word.endswith("n't"):
                classes.setdefault(word.replace("'", ""), set()).add(name)
    directions = {w: rel for rel, forms in words["directions"].items() for w in forms}
    objects = {w: kind for kind, forms in words["object_kinds"].items() for w in forms}
    kinds = tuple(
        PlaceKind(
            name,
            *(tuple(spec.get(field, ())) for field in ("words", "names", "amenities", "kinds")),
        )
        for name, spec in words["place_kinds"].items()
    )
    closed = {
        *classes,
        *directions,
        *(w for form in cues for w in form),
        *words["units_m"],
        *words["numbers"],
        *words["colours"],
        *objects,
        *(w for kind in kinds for form in kind.words for w in form.split()),
        *words["intensifiers"],
    }
    return Lexicon(
        classes={w: frozenset(c) for w, c in classes.items()},
        directions=directions,
        cues=cues,
        abbreviations=words["abbreviations"],
        ordinals=words["ordinals"],
        units_m=words["units_m"],
        numbers=words["numbers"],
        colours=frozenset(words["colours"]),
        object_kinds=objects,
        place_kinds=kinds,
        intensifiers=frozenset(words["intensifiers"]),
        copula=frozenset(words["copula"]),
        generic=frozenset(words["generic"]),
        stop=frozenset(words["stop"]),
        compass=frozenset(words["compass"]),
        common=frozenset(words["common"]),
        closed=frozenset(closed),
        plain=frozenset(words["plain"]),
    )


def _cues(entries: list[dict[str, Any]]) -> dict[tuple[str, ...], tuple[str, bool]]:
    """Return the surface forms of the vocabulary file."""
    return {
        tuple(form.split()): (entry["relation"], bool(entry.get("negated", False)))
        for entry in entries
        for form in entry["forms"]
    }
