"""Find the places of a map that are of a kind: "the tavern", "the parking garage"."""

from __future__ import annotations

import re

from sloop_ppl.language.lexicon import camel_words, lexicon
from sloop_ppl.language.name_index import NameIndex, canonical, name_index
from sloop_ppl.maps import CityMap

__all__ = ["PlaceIndex", "place_index"]

_WAYS = ("street", "service", "pedestrian")


class PlaceIndex:
    """The places of one map by name and by kind.

    Parameters
    ----------
    city
        The map.
    """

    def __init__(self, city: CityMap) -> None:
        self.index: NameIndex = name_index(city)
        self._ids = [m.id for m in city.landmarks]
        self._maps = [_home(m.id) for m in city.landmarks]
        self._positions = {one: i for i, one in enumerate(self._ids)}
        self.streets = frozenset(i for i, m in enumerate(city.landmarks) if m.kind in _WAYS)
        self._scores = {kind.name: self._score(kind.name) for kind in lexicon().place_kinds}

    def id(self, position: int) -> str:
        """Return the id of the landmark at a position in the map."""
        return self._ids[position]

    def position(self, landmark_id: str) -> int | None:
        """Return the position in the map of a landmark, None for another id."""
        return self._positions.get(landmark_id)

    def home(self, position: int) -> str:
        """Return which of several merged maps a landmark came from."""
        return self._maps[position]

    def of_kind(self, kind: str) -> tuple[str, ...]:
        """Return the ids of the landmarks of a kind, the surest first."""
        scores = self._scores.get(kind, {})
        return tuple(sorted(scores, key=lambda i: -scores[i]))

    def best_of_kind(self, kind: str, words: tuple[str, ...] = ()) -> tuple[str, ...]:
        """Return the ids of the landmarks that fit a kind best; one when it is clear.

        Parameters
        ----------
        kind
            Name of the kind.
        words
            The words, which decide among equals when they stand in a name.
        """
        scores = self._scores.get(kind, {})
        top = max(scores.values(), default=0.0)
        best = tuple(i for i, s in scores.items() if s == top)
        if len(best) > 1 and words:
            tokens = {canonical(w) for w in words}
            named = [
                i
                for i in best
                if any(
                    tokens <= set(n.tokens) for n in self.index.names if self._ids[n.landmark] == i
                )
            ]
            if len(named) == 1:
                return tuple(named)
        return best

    def _score(self, name: str) -> dict[str, float]:
        """Return how well every landmark that fits a kind at all fits it."""
        kind = next(k for k in lexicon().place_kinds if k.name == name)
        wanted = [tuple(canonical(w) for w in n.split()) for n in kind.names]
        scores: dict[str, float] = {}
        names: dict[int, list[tuple[str, ...]]] = {}
        for entry in self.index.names:
            names.setdefault(entry.landmark, []).append(entry.tokens)
        for i, landmark in enumerate(self.index.landmarks):
            tokens = names.get(i, [])
            if not landmark.name:
                symbol = re.sub(r"\d+$", "", landmark.id.rsplit("/", 1)[-1])
                tokens = [tuple(canonical(w) for w in camel_words(symbol))]
            named = max(
                (
                    float(len(n))
                    for w in tokens
                    for n in wanted
                    if any(w[k : k + len(n)] == n for k in range(len(w)))
                ),
                default=0.0,
            )
            score = 2.0 * (named > 0) + 0.1 * named
            score += 2.0 * (landmark.properties.get("amenity") in kind.amenities)
            score += 1.0 * (landmark.kind in kind.kinds)
            if score:
                scores[landmark.id] = score
        return scores


_INDICES: dict[str, PlaceIndex] = {}


def place_index(city: CityMap) -> PlaceIndex:
    """Return the (cached) places of a map."""
    found = _INDICES.get(city.digest)
    if found is None:
        if len(_INDICES) >= 16:
            _INDICES.clear()
        found = _INDICES[city.digest] = PlaceIndex(city)
    return found


def _home(landmark_id: str) -> str:
    return landmark_id.rpartition("/")[0]
