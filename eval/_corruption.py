"""Make reading harder: misspell words, and put the landmarks of several maps into one inventory."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap

__all__ = ["merge_maps", "misspell"]

_LONG_WORD = re.compile(r"[^\W\d_]{5,}")
_LETTERS = "abcdefghijklmnopqrstuvwxyz"


def misspell(text: str, share: float, *, rng: np.random.Generator) -> str:
    """Return `text` with one wrong letter in a share of its longer words.

    Parameters
    ----------
    share
        Probability, in [0, 1], that a word of five letters or more gets one edit: a letter
        inserted, left out or replaced, or two neighbours swapped.
    rng
        Draws the words and the edits.

    Examples
    --------
    >>> misspell("behind Velvet Dog", 1.0, rng=np.random.default_rng(1))
    'behidn Vielvet Dog'
    """
    return _LONG_WORD.sub(lambda m: _typo(m[0], rng) if rng.random() < share else m[0], text)


def _typo(word: str, rng: np.random.Generator) -> str:
    """Return `word` after one edit that changes it."""
    kind = int(rng.integers(4))
    at = int(rng.integers(len(word)))
    letter = _LETTERS[int(rng.integers(len(_LETTERS)))]
    if kind == 0:
        return word[:at] + letter + word[at:]
    if kind == 1:
        return word[:at] + word[at + 1 :]
    if kind == 2 and word[at].lower() != letter:
        return word[:at] + letter + word[at + 1 :]
    at = min(at, len(word) - 2)
    swapped = word[:at] + word[at + 1] + word[at] + word[at + 2 :]
    return swapped if swapped != word else word[:at] + word[at + 1 :]


def merge_maps(cities: Iterable[CityMap]) -> CityMap:
    """Return one map that holds the landmarks of several, addressed as ``map/id``.

    Parameters
    ----------
    cities
        At least one map; names are unique.

    Returns
    -------
    CityMap
        On the grid of the first map. Places of different maps lie on top of each other: it is
        an inventory to read texts on, not a map to search.

    Raises
    ------
    InputError
        When there is no map, or two share a name.
    """
    cities = list(cities)
    names = [city.name for city in cities]
    if not cities or len(set(names)) < len(names):
        raise InputError(
            f"The maps to merge are {', '.join(names) or 'none'}; expected at least one, "
            "each with a name of its own"
        )
    landmarks = tuple(
        replace(
            landmark,
            id=f"{city.name}/{landmark.id}",
            within=None if landmark.within is None else f"{city.name}/{landmark.within}",
        )
        for city in cities
        for landmark in city.landmarks
    )
    return CityMap("+".join(names), cities[0].grid, landmarks)
