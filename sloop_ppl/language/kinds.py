"""Read which kinds of places a noun phrase names, and find them on a map."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache

from sloop_ppl.language.kind_vocabulary import Kind, kind_vocabulary, phrase_words
from sloop_ppl.language.lexicon import camel_words
from sloop_ppl.maps import PATH_KINDS, CityMap, Landmark

__all__ = ["Kind", "is_kind_noun", "kinds_of", "landmarks_of_kind"]

_LONGEST = 8
_REMEMBERED = 4096
_DETERMINERS = frozenset((
    "a", "an", "the", "any", "some", "every", "each", "all", "no", "this", "that", "these",
    "those", "my", "your", "our", "their", "its", "his", "her", "another",
))  # fmt: skip
_EATING = frozenset((
    "restaurant", "place", "joint", "spot", "eatery", "takeaway", "takeout", "shop", "house",
    "stand", "truck", "bar", "diner", "kitchen", "parlor", "store", "stall", "cafe", "buffet",
))  # fmt: skip
_DINING = frozenset(("restaurant", "eatery", "diner"))
_SHOPS = ("store", "shop")
"""One word to either side of the Atlantic; the presets have the first or the second."""
_CARRIERS = frozenset((
    "building", "shop", "store", "place", "spot", "area", "location", "facility", "center",
    "establishment", "complex", "branch", "site",
))  # fmt: skip
"""Heads that add little to the kind before them: "pharmacy store", "church building"."""
_PLACE_KEYS = frozenset((
    "amenity", "shop", "leisure", "tourism", "office", "craft", "historic", "healthcare",
    "railway", "public_transport", "man_made", "natural", "landuse", "highway", "place",
    "waterway", "emergency", "club", "barrier",
))  # fmt: skip


def kinds_of(phrase: str) -> tuple[Kind, ...]:
    """Return the kinds of places that a noun phrase names, the surest first.

    Parameters
    ----------
    phrase
        The noun phrase, singular or plural, British or American. An article before it does not
        matter.

    Returns
    -------
    tuple of Kind
        Of one reading: alternatives of which a landmark has to satisfy one. Empty when the head
        of the phrase names no kind. Words before the longest phrase that is known are in
        `Kind.modifiers`, as `phrase_words` gives them.

    Notes
    -----
    What was written by hand for everyday words goes before names of presets, and those before
    search terms. "Thai place" and the like are read as the tag ``cuisine``; "church building" is
    read as "church".

    Examples
    --------
    >>> kinds_of("gas stations")[0].tags
    (('amenity', 'fuel'),)
    >>> kinds_of("red brick house")[0].modifiers
    ('red', 'brick')
    """
    return _kinds_of(phrase, False)


def is_kind_noun(word: str) -> bool:
    """Tell whether a word, or a phrase as a whole, names a kind of place.

    Parameters
    ----------
    word
        The word, singular or plural. Ordinary verbs, adjectives and general nouns ("open",
        "place", "stand") are no kinds.

    Examples
    --------
    >>> is_kind_noun("pharmacies"), is_kind_noun("open")
    (True, False)
    """
    found = kinds_of(word)
    return bool(found) and not found[0].modifiers


def landmarks_of_kind(kind_phrase: str, city: CityMap, *, by_name: bool = False) -> tuple[int, ...]:
    """Return the positions of all landmarks of a kind.

    Parameters
    ----------
    kind_phrase
        A noun phrase, as `kinds_of` reads it. Its modifiers do not narrow the choice.
    city
        The map; it is indexed when it is first asked.
    by_name
        Whether a landmark without tags may be of the kind that its name says ("The United
        Church").

    Returns
    -------
    tuple of int
        Positions in ``city.landmarks``: those of the surest kind first, each kind in the map's
        order. Besides tags it counts what a nameless landmark is called by in its id
        (``"BusStop2"``).
    """
    what = "kinds, by name too" if by_name else "kinds"
    return city.derived(what, lambda: _KindIndex(city.landmarks, by_name)).find(kind_phrase)


@lru_cache(maxsize=_REMEMBERED)
def _kinds_of(phrase: str, in_name: bool) -> tuple[Kind, ...]:
    """Return the kinds of a phrase; in a name, any word may come before the head ("Chase Bank")."""
    low = phrase.replace("-", " ").split()
    while low and low[0].lower() in _DETERMINERS:
        low = low[1:]
    words = phrase_words(" ".join(low))
    known = kind_vocabulary()
    for first in range(max(0, len(words) - _LONGEST), len(words)):
        found = _whole(words[first:], low[-1].lower())
        if not found:
            continue
        # A noun before some heads makes another thing of them: a blood bank is no bank.
        changed = first == len(words) - 1 > 0 and words[first] in known.compound
        if changed and not in_name and words[first - 1] not in known.descriptive:
            return ()
        return tuple(replace(kind, modifiers=words[:first]) for kind in found) if first else found
    return ()


def _whole(words: tuple[str, ...], last: str) -> tuple[Kind, ...]:
    """Return the kinds that words name as a whole; `last` is the last word as it stands."""
    found = _exact(words, last)
    *before, head = words
    stem = tuple(before)
    known = kind_vocabulary()
    if words in known.by_hand or not stem:
        return found
    eaten = stem[:-1] if stem[-1] == "food" else stem
    if head in _EATING and eaten in known.cuisines:
        return _cuisine(" ".join(words), known.cuisines[eaten], head)
    if not found and head in _SHOPS:
        found = next((f for other in _SHOPS if (f := _exact((*stem, other), other))), ())
    if found or head not in _CARRIERS:
        return found
    return _exact(stem, stem[-1])


def _exact(words: tuple[str, ...], last: str) -> tuple[Kind, ...]:
    known = kind_vocabulary()
    if len(words) == 1:
        singular = words[0] == last
        if words[0] in known.plain or (singular and last in known.plural_only):
            return ()
    return known.by_hand.get(words) or known.by_name.get(words, ())


def _cuisine(name: str, value: str, head: str) -> tuple[Kind, ...]:
    """Return the kinds of "thai restaurant" (one may be fast food) or "thai place" (any)."""
    eaten = ("cuisine", value)
    if head in _DINING:
        return tuple(Kind(name, (("amenity", v), eaten)) for v in ("restaurant", "fast_food"))
    return (Kind(name, (eaten,)),)


class _KindIndex:
    """The landmarks of one map by tag.

    Parameters
    ----------
    landmarks
        The landmarks.
    by_name
        Whether those without tags are given the tags of the kind that their names say.
    """

    def __init__(self, landmarks: Iterable[Landmark], by_name: bool) -> None:
        self._with: dict[tuple[str, str], set[int]] = {}
        self._stated: dict[str, set[int]] = {}
        self._all: set[int] = set()
        self._found: dict[str, tuple[int, ...]] = {}
        for i, landmark in enumerate(landmarks):
            self._all.add(i)
            tags = _stated_tags(landmark)
            for key, _ in tags:
                self._stated.setdefault(key, set()).add(i)
            for key, value in (*tags, *_implied_tags(landmark, tags, by_name)):
                self._with.setdefault((key, value), set()).add(i)
                self._with.setdefault((key, "*"), set()).add(i)

    def find(self, phrase: str) -> tuple[int, ...]:
        """Return the positions of the landmarks of a kind, the surest kind first."""
        found = self._found.get(phrase)
        if found is None:
            if len(self._found) >= _REMEMBERED:
                self._found.clear()
            ordered: dict[int, None] = {}
            for kind in kinds_of(phrase):
                if not (kind.is_fallback and ordered):
                    ordered |= dict.fromkeys(sorted(self._satisfying(kind)))
            found = self._found[phrase] = tuple(ordered)
        return found

    def _satisfying(self, kind: Kind) -> set[int]:
        nothing: set[int] = set()
        sets = [
            self._with.get((key, value), nothing)
            if value
            else self._all - self._stated.get(key, nothing)
            for key, value in kind.tags
        ]
        return set.intersection(*sets)


def _stated_tags(landmark: Landmark) -> list[tuple[str, str]]:
    """Return the tags of a landmark that some kind asks for; "a;b" holds both values."""
    tags = [("kind", landmark.kind)]
    for key in kind_vocabulary().keys & landmark.properties.keys():
        value = landmark.properties[key]
        if isinstance(value, str):
            parts = (part.strip().lower() for part in value.split(";"))
            tags += [(key, part) for part in parts if part and part != "no"]
    return tags


def _implied_tags(
    landmark: Landmark, tags: list[tuple[str, str]], by_name: bool
) -> tuple[tuple[str, str], ...]:
    """Return the tags of the kind that a landmark's other words name.

    A map may hold its own word as ``amenity`` ("wine_shop"); a landmark without a name is called
    by its kind in its id.
    """
    tagged = [(key, value) for key, value in tags if key in _PLACE_KEYS]
    for key, value in tagged:
        elsewhere = any(v == value and k != key for k, v in tagged)
        if key == "amenity" and (key, value) not in kind_vocabulary().known and not elsewhere:
            return _tags_named(value.replace("_", " "), landmark, False)
    if tagged:
        return ()
    if not landmark.name:
        symbol = [w for w in camel_words(landmark.id.rsplit("/", 1)[-1]) if w != "poi"]
        return _tags_named(" ".join(symbol), landmark, False)
    return _tags_named(landmark.name, landmark, True) if by_name else ()


def _tags_named(phrase: str, landmark: Landmark, in_name: bool) -> tuple[tuple[str, str], ...]:
    """Return the tags of the kind that a phrase names, unless the landmark is of another kind."""
    if in_name:
        phrase = re.split(r"\s+(?:of|at|for|and|&|/|-)\s+", phrase.lower())[0]
    found = _kinds_of(phrase, in_name)
    if in_name and not found and landmark.kind == "poi":
        found = _kinds_of(phrase.split()[0], False) if phrase.split() else ()
    if not found or (in_name and landmark.kind in PATH_KINDS and found[0].modifiers):
        return ()  # "Fort Street Mall" is a street
    # A name is taken at its word: "Pioneer Plaza", a building, is no square by another tag.
    for kind in found[:1] if in_name else found:
        asked = dict(kind.tags)
        if asked.pop("kind", landmark.kind) == landmark.kind:
            return tuple((key, value) for key, value in asked.items() if value)
    return ()
