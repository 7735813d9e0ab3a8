"""Find the places of a map that are of a kind: "the tavern", "the parking garage"."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from sloop_ppl.language.kinds import landmarks_of_kind
from sloop_ppl.language.lexicon import camel_words, lexicon
from sloop_ppl.language.name_index import NameIndex, canonical, name_index
from sloop_ppl.maps import CityMap

__all__ = ["KindFit", "PlaceIndex", "kind_name", "place_index"]

_REMEMBERED = 2048
_CARRIERS = frozenset(("building", "shop", "store", "place", "office", "branch"))
_LESS_LIKE = 0.25
"""Weight of a landmark that a kind fits in part: the tower of that name where a bank is meant."""


@dataclass(frozen=True)
class KindFit:
    """The landmarks of a kind.

    Parameters
    ----------
    name
        What the kind is called first.
    ids
        Ids of the landmarks, the surest first.
    best
        Those that fit best; one when it is clear which is meant.
    weights
        Id -> how well it fits, in (0, 1].
    """

    name: str
    ids: tuple[str, ...]
    best: tuple[str, ...]
    weights: dict[str, float] = field(default_factory=dict)


def kind_name(words: tuple[str, ...]) -> str:
    """Return the name of the hand-made kind that words call, in the singular too; "" for none."""
    places = lexicon().place_phrases
    head = words[-1].removesuffix("s") if words else ""
    return places.get(words) or places.get((*words[:-1], head), "")


_WAYS = ("street", "service", "pedestrian")


class PlaceIndex:
    """The places of one map by name and by kind.

    Parameters
    ----------
    city
        The map.
    """

    def __init__(self, city: CityMap) -> None:
        self.city = city
        self.index: NameIndex = name_index(city)
        self._ids = [m.id for m in city.landmarks]
        self._maps = [_home(m.id) for m in city.landmarks]
        self._tokens: dict[str, list[tuple[str, ...]]] = {}
        for entry in self.index.names:
            self._tokens.setdefault(self._ids[entry.landmark], []).append(entry.tokens)
        self._fits: dict[str, KindFit] = {}
        self._scores: dict[str, dict[str, float]] = {}
        self._positions = {one: i for i, one in enumerate(self._ids)}
        self.streets = frozenset(i for i, m in enumerate(city.landmarks) if m.kind in _WAYS)

    def id(self, position: int) -> str:
        """Return the id of the landmark at a position in the map."""
        return self._ids[position]

    def position(self, landmark_id: str) -> int | None:
        """Return the position in the map of a landmark, None for another id."""
        return self._positions.get(landmark_id)

    def home(self, position: int) -> str:
        """Return which of several merged maps a landmark came from."""
        return self._maps[position]

    def of_phrase(self, phrase: str) -> KindFit:
        """Return the landmarks of the kind that a noun phrase names.

        Parameters
        ----------
        phrase
            The noun phrase, folded, without an article.
        """
        found = self._fits.get(phrase)
        if found is None:
            if len(self._fits) >= _REMEMBERED:
                self._fits.clear()
            found = self._fits[phrase] = self._fit(phrase)
        return found

    def _fit(self, phrase: str) -> KindFit:
        words = tuple(phrase.split())
        name = kind_name(words) or (kind_name(words[:-1]) if words[-1] in _CARRIERS else "")
        scores = self._scored(name) if name else {}
        best = self._best(scores, words)
        weights = dict.fromkeys(best, 1.0)
        tagged = [self._ids[i] for i in landmarks_of_kind(phrase, self.city, by_name=True)]
        weights |= dict.fromkeys(tagged, 1.0)
        for i in (*self._liked(scores), *self._named(words)):
            weights.setdefault(i, _LESS_LIKE)
        for i in self._named(words, head=True):
            weights[i] = 1.0
        if not best and len(weights) == 1:
            best = tuple(weights)
        return KindFit(name or phrase, tuple(weights), best, weights)

    def _named(self, words: tuple[str, ...], head: bool = False) -> tuple[str, ...]:
        """Return the landmarks in whose names a phrase stands; `head`: at the end of a name."""
        tokens = tuple(canonical(w) for w in words)
        hits = self.index.vocabulary.get(tokens[-1], ())
        found = []
        for hit in hits:
            name = self.index.names[hit.name]
            ends = hit.last == len(name.tokens) > len(tokens)
            if not (ends if head else len(name.tokens) > len(tokens)):
                continue
            if name.tokens[max(0, hit.last - len(tokens)) : hit.last] == tokens:
                found.append(self._ids[name.landmark])
        return tuple(dict.fromkeys(found))

    def _scored(self, name: str) -> dict[str, float]:
        if name not in self._scores:
            self._scores[name] = self._score(name)
        return self._scores[name]

    @staticmethod
    def _liked(scores: dict[str, float]) -> list[str]:
        return sorted(scores, key=lambda i: -scores[i])

    def _best(self, scores: dict[str, float], words: tuple[str, ...]) -> tuple[str, ...]:
        """Return the landmarks that fit a kind best; a word in a name decides among equals."""
        top = max(scores.values(), default=0.0)
        best = tuple(i for i, s in scores.items() if s == top)
        if len(best) > 1 and words:
            tokens = {canonical(w) for w in words}
            named = [i for i in best if any(tokens <= set(n) for n in self._tokens.get(i, ()))]
            if len(named) == 1:
                return tuple(named)
        return best

    def _score(self, name: str) -> dict[str, float]:
        """Return how well every landmark that fits a kind at all fits it."""
        kind = next(k for k in lexicon().place_kinds if k.name == name)
        wanted = [tuple(canonical(w) for w in n.split()) for n in kind.names]
        scores: dict[str, float] = {}
        for landmark in self.index.landmarks:
            tokens = self._tokens.get(landmark.id, [])
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
