"""The closed classes of words, and the words of all relations, ready to be looked up."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib.resources import files
from typing import Any

from sloop_ppl.language.relations import RELATIONS
from sloop_ppl.language.words import split_words

__all__ = ["Lexicon", "PlaceKind", "camel_words", "lexicon"]

_ROLES = (
    "speaker", "size_adjectives", "kin", "titles", "locating_verbs", "state_verbs", "meet_verbs",
    "ordinary_verbs", "adverbs", "times", "abstract", "clause_openers", "object_determiners",
    "traces", "object_particles", "existential", "staying", "motion_verbs",
    "outings", "addressing", "carrying", "arriving", "prepositions", "subject_goes_on",
)  # fmt: skip
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
    words
        What it is called, canonical words joined by a space.
    names
        Words in a landmark's name that give it away.
    amenities
        Values of the property ``amenity``.
    kinds
        Kinds of landmark.
    """

    name: str
    words: tuple[str, ...]
    names: tuple[str, ...] = ()
    amenities: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Lexicon:
    """Everything the rule parser knows about English.

    Parameters
    ----------
    classes
        Word -> the closed classes it belongs to.
    directions
        Word -> canonical relation, such as ``"upper" -> "top"``.
    cues
        Word tuples -> (canonical relation, whether the form itself negates); of two relations with
        one form that which was added later has it.
    alike
        Word -> the word that stands for it in cues: "the road" for "the street".
    short
        Short form of a cue's word -> the word.
    abbreviations
        Short word -> full word.
    slang
        Word of chats, or without its apostrophe -> the word in full.
    units_m
        Unit -> metres.
    numbers
        Number word -> value.
    colours
        Words for colours.
    object_kinds
        Noun or make -> kind of object.
    place_kinds
        Kinds of places, in file order.
    generic, stop, compass, common
        Words that weigh little, nothing, or need company in names.
    closed
        Every word above, those that spelling is corrected to.
    plain
        Everyday words that are never corrected.
    roles
        Lists of words by what they do: ``locating_verbs``, ``kin``, ``times``, and the classes.
    assertion
        Forms that ask, deny, correct or tell of before, by what they do, as word tuples.
    """

    classes: Mapping[str, frozenset[str]]
    directions: Mapping[str, str]
    cues: Mapping[tuple[str, ...], tuple[str, bool]]
    alike: Mapping[str, str]
    short: Mapping[str, str]
    abbreviations: Mapping[str, str]
    slang: Mapping[str, str]
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
    roles: Mapping[str, frozenset[str]]
    assertion: Mapping[str, tuple[tuple[str, ...], ...]]

    def words_of(self, role: str) -> frozenset[str]:
        """Return the words of an open list, or of a closed class."""
        return self.roles[role]

    @cached_property
    def cue_words(self) -> dict[tuple[str, ...], tuple[str, bool]]:
        """The cues in the words that stand for those alike, hyphens left out."""
        return {
            tuple(self.alike.get(w, w) for w in form if w != "-"): cue
            for form, cue in self.cues.items()
        }

    @cached_property
    def longest_cues(self) -> dict[str, int]:
        """First word of a cue -> the words of the longest that begins with it."""
        return _longest(self.cue_words)

    @cached_property
    def place_phrases(self) -> dict[tuple[str, ...], str]:
        """What a kind of place is called -> the kind; the first in the file has it."""
        phrases: dict[tuple[str, ...], str] = {}
        for kind in self.place_kinds:
            for phrase in kind.words:
                phrases.setdefault(tuple(phrase.split()), kind.name)
        return phrases

    @cached_property
    def longest_places(self) -> dict[str, int]:
        """First word of a place phrase -> the words of the longest that begins with it."""
        return _longest(self.place_phrases)


def _longest(phrases: Iterable[tuple[str, ...]]) -> dict[str, int]:
    longest: dict[str, int] = {}
    for words in phrases:
        longest[words[0]] = max(longest.get(words[0], 0), len(words))
    return longest


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


def lexicon() -> Lexicon:
    """Return the words that ship with the package, with those of all relations there are now."""
    return _lexicon(RELATIONS.changes)


@lru_cache(maxsize=1)
def _lexicon(changes: int) -> Lexicon:  # noqa: ARG001
    data = files("sloop_ppl") / "data"
    words: dict[str, Any] = json.loads((data / "words.json").read_text("utf-8"))
    cues = {
        tuple(w.low for w in split_words(form)): (word, denies)
        for word, record in RELATIONS.items()
        for forms, denies in ((record.forms, False), (record.denied_forms, True))
        for form in forms
    }
    classes: dict[str, set[str]] = {}
    for name in _CLASSES:
        for word in words[name]:
            classes.setdefault(word, set()).add(name)
            if word.endswith("n't"):
                classes.setdefault(word.replace("'", ""), set()).add(name)
    directions = {w: word for word, record in RELATIONS.items() for w in record.directions}
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
        alike={w: one for one, others in words["cue_words"].items() for w in others},
        short=words["cue_short"],
        abbreviations=words["abbreviations"],
        slang=words["slang"],
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
        plain=frozenset(words["plain"]).union(*words["cue_words"].values(), words["cue_short"]),
        roles={name: frozenset(words[name]) for name in (*_ROLES, *_CLASSES)}
        | {name: frozenset(forms) for name, forms in words["assertion"].items()},
        assertion={
            name: tuple(tuple(form.split()) for form in forms)
            for name, forms in words["assertion"].items()
        },
    )
