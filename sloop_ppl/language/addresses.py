"""Read addresses: "221 West 6th", "Main Street 12", "number 7"."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

import shapely

from sloop_ppl.language.lexicon import lexicon
from sloop_ppl.language.mentions import LandmarkMention
from sloop_ppl.language.name_index import STREET_TYPES, NameIndex, canonical
from sloop_ppl.language.referents import of_a_kind
from sloop_ppl.language.word_roles import Roles
from sloop_ppl.language.words import Word, split_words
from sloop_ppl.maps import PATH_KINDS, CityMap, Landmark

__all__ = ["AddressIndex", "link_addresses"]

_ALONG_M = 60.0
_ALONG = 3
"""A house without a street of its own is one of the nearest three streets within 60 m."""

_HOUSE_UNKNOWN = 0.6
"""Share of the street where it is on the map and a house of that number is not."""

_HOUSE_INFERRED = 0.9
"""Share of the house where the map has its number, and its street is only near."""

_STREET_UNKNOWN = 0.7
"""Share of the houses of a number where the street that was named is not on the map."""

_BARE_NUMBER = 0.8
"""Share of the houses of a number that was given without a street."""

_TYPE_WITHIN = 3
_LONGEST_NUMBER = 6
"""Digits of a house number; more are a postal code's, or none at all."""


class AddressIndex:
    """The house numbers of one map.

    Parameters
    ----------
    city
        The map.
    """

    def __init__(self, city: CityMap) -> None:
        self._houses: dict[str, list[tuple[int, frozenset[str], bool]]] = {}
        streets = tuple(m for m in city.of_kind(*sorted(PATH_KINDS)) if m.name)
        tree = shapely.STRtree([m.geometry for m in streets])
        for i, landmark in enumerate(city.landmarks):
            for number, street in dict.fromkeys(_addresses(landmark)):
                if street:
                    names, stated = [street], True
                else:
                    near = _nearest(landmark, streets, tree)
                    names, stated = [m.name or "" for m in near], False
                words_of_street = frozenset(t for name in names for t in _distinctive(name))
                self._houses.setdefault(number, []).append((i, words_of_street, stated))

    def houses(self, number: str) -> list[int]:
        """Return the positions of the landmarks of a number, on whatever street."""
        return list(dict.fromkeys(i for i, _, _ in self._houses.get(number, ())))

    def on_street(self, number: str, street: Iterable[str]) -> dict[int, bool]:
        """Return the landmarks of a number on a street -> whether the map says so itself.

        Parameters
        ----------
        number
            The house number as it is written.
        street
            Name of the street.
        """
        asked = frozenset(t for name in street for t in _distinctive(name))
        found = {
            i: stated
            for i, words_of_street, stated in self._houses.get(number, ())
            if asked & words_of_street
        }
        sure = {i: True for i, stated in found.items() if stated}
        return sure or found


def _addresses(landmark: Landmark) -> list[tuple[str, str]]:
    """Return the numbers of a landmark with their streets, "" for one that is unknown."""
    known = landmark.properties
    number = known.get("house_number") or known.get("addr:housenumber")
    street = str(known.get("addr:street") or "")
    found = [(part, street) for part in _numbers(number)]
    for address in known.get("addresses", ()):
        match = re.fullmatch(r"(\d\S*)\s+(.+)|(.+?)\s+(\d\S*)", str(address))
        if match:
            other, name = match[1] or match[4], match[2] or match[3]
            found += [(part, name) for part in _numbers(other)]
    return found


def _numbers(text: object) -> list[str]:
    """Return the numbers that a house answers to: of "22-24" also "22" and "24"."""
    if not isinstance(text, str | int) or isinstance(text, bool):
        return []
    whole = str(text).strip().lower()
    parts = [p.strip() for p in re.split(r"[;,]", whole) if p.strip()]
    ends = [e for p in parts for e in re.split(r"\s*[-–]\s*", p) if e]
    return list(dict.fromkeys((*parts, *ends)))


def _distinctive(name: str) -> list[str]:
    """Return the words of a street's name that tell it from others."""
    known = lexicon()
    low = [canonical(w.low) for w in split_words(name) if w.kind != "mark"]
    return [w for w in low if w not in known.generic | known.compass | known.stop] or low


def _nearest(
    landmark: Landmark, streets: Sequence[Landmark], tree: shapely.STRtree
) -> list[Landmark]:
    found = tree.query(landmark.geometry, predicate="dwithin", distance=_ALONG_M)
    near = sorted(found, key=lambda k: float(landmark.geometry.distance(streets[k].geometry)))
    return [streets[int(k)] for k in near[:_ALONG]]


def link_addresses(
    words: Sequence[Word], mentions: list[LandmarkMention], roles: Roles, index: NameIndex
) -> list[LandmarkMention]:
    """Return mentions with house numbers next to a street taken in, and addresses added.

    Parameters
    ----------
    words
        The text.
    mentions
        Names that were found in it, in order.
    roles
        The roles of its words.
    index
        Names of the map.
    """
    numbers = [
        i
        for i, word in enumerate(words)
        if word.kind == "number" and not word.low[-1:].isalpha() and not roles.measure[i]
    ]
    if not numbers:
        return mentions
    houses = index.city.derived("addresses", lambda: AddressIndex(index.city))
    starts = {m.first: m for m in mentions}
    ends = {m.last: m for m in mentions}
    taken = {w for m in mentions for w in range(m.first, m.last)}
    made: dict[int, LandmarkMention] = {}
    for i in numbers:
        if i in taken:
            continue
        after = i + 1
        if after < len(words) and words[after].low == ",":
            after += 1
        street = starts.get(i + 1) or starts.get(after)
        number = words[i].low.replace(",", "")
        if street is not None and street.first not in made and _is_street(street, index):
            found = _at_number(number, street, houses, index)
            made[street.first] = replace(found, first=i)
            continue
        street = ends.get(i)
        if street is not None and street.first not in made and _is_street(street, index):
            found = _at_number(number, street, houses, index)
            if found.score >= 1.0 or found.candidates != street.candidates:
                made[street.first] = replace(found, last=i + 1)
            continue
        alone = _alone(words, i, number, roles, houses)
        if alone is not None:
            made[i] = alone
    added = list(made.values())
    covered = {w for m in added for w in range(m.first, m.last)}
    kept = [m for m in mentions if not covered.intersection(range(m.first, m.last))]
    return sorted([*kept, *added], key=lambda m: m.first)


def _is_street(mention: LandmarkMention, index: NameIndex) -> bool:
    return index.landmarks[mention.candidates[0]].kind in PATH_KINDS


def _at_number(
    number: str, street: LandmarkMention, houses: AddressIndex, index: NameIndex
) -> LandmarkMention:
    """Return the houses of a number on a street, or the street with a lower share."""
    names = [index.landmarks[c].name or "" for c in street.candidates]
    found = houses.on_street(number, names)
    if not found:
        shares = tuple((i, p * _HOUSE_UNKNOWN) for i, p in street.shares)
        house = int(number) if number.isdecimal() and len(number) <= _LONGEST_NUMBER else 0
        return replace(
            street, shares=shares, score=street.score * _HOUSE_UNKNOWN, number=house or None
        )
    sure = all(found.values())
    shares = of_a_kind(dict.fromkeys(found, 1.0), 0.0 if sure else 1 - _HOUSE_INFERRED)
    if not sure:
        shares = (*shares, (street.candidates[0], (1 - _HOUSE_INFERRED) / 2))
    return replace(
        street, candidates=tuple(found), rivals=street.candidates, score=1.0, shares=shares
    )


def _alone(
    words: Sequence[Word], at: int, number: str, roles: Roles, houses: AddressIndex
) -> LandmarkMention | None:
    """Return the houses of a number whose street is not on the map, or was not given."""
    found = houses.houses(number)
    if not found:
        return None
    last = _street_type(words, at + 1)
    if last is None and not roles.numbered[at]:
        return None
    known = _STREET_UNKNOWN if last is not None else _BARE_NUMBER
    shares = of_a_kind(dict.fromkeys(found, 1.0), 1 - known)
    first = at
    if last is None:
        first -= 2 if words[at - 1].low == "." else 1
    return LandmarkMention(first, last or at + 1, tuple(found), known, (), shares)


def _street_type(words: Sequence[Word], at: int) -> int | None:
    """Return the word after "G Street" when a street's name that the map lacks stands there."""
    known = lexicon()
    for k in range(at, min(at + _TYPE_WITHIN, len(words))):
        low = words[k].low
        if words[k].kind == "mark" and low != ".":
            return None
        if k > at and canonical(low) in STREET_TYPES and low != "way":
            return k + 1
        if low in known.closed and canonical(low) not in known.compass and len(low) > 1:
            return None
    return None
