"""Know a map's names: their words, how much each word tells, and which words look alike."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from functools import lru_cache

from rapidfuzz import process
from rapidfuzz.distance import OSA

from sloop_ppl.language.lexicon import camel_words, lexicon
from sloop_ppl.language.words import split_words
from sloop_ppl.maps import PATH_KINDS, CityMap, Landmark

__all__ = ["STREET_TYPES", "Hit", "Name", "NameIndex", "canonical", "name_index"]

STREET_TYPES = frozenset(("street", "avenue", "road", "lane", "drive", "boulevard", "way"))
_SIMILAR = 0.66
_CACHE = 20000


@dataclass(frozen=True, slots=True)
class Name:
    """One name of one landmark, as words.

    Parameters
    ----------
    landmark
        Position of the landmark in the map.
    tokens
        Canonical words.
    weights
        How much each word tells, in (0, 1].
    informative
        Whether each word alone can give the landmark away.
    total
        Sum of the weights.
    spelt
        The words as they are written, folded.
    """

    landmark: int
    tokens: tuple[str, ...]
    weights: tuple[float, ...]
    informative: tuple[bool, ...]
    total: float
    spelt: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Hit:
    """A word of text that may stand for the words `first` to `last` (excluded) of a name."""

    name: int
    first: int
    last: int
    similarity: float


@lru_cache(maxsize=16384)
def canonical(low: str) -> str:
    """Return the form in which a folded word is compared: no ending, no abbreviation.

    Examples
    --------
    >>> [canonical(w) for w in ("ave", "sixth", "apartments", "oblio's")]
    ['avenue', '6th', 'apartment', 'oblio']
    """
    words = lexicon()
    word = low[:-2] if low.endswith("'s") else low
    word = word.replace("'", "")
    word = words.abbreviations.get(word, words.ordinals.get(word, word))
    if len(word) > 3 and word.endswith("s") and not word.endswith("ss"):
        word = word[:-1]
    return words.abbreviations.get(word, word)


class NameIndex:
    """The names of one map, ready for looking words up.

    Parameters
    ----------
    city
        The map; landmarks without a name are found by kind only.
    """

    def __init__(self, city: CityMap) -> None:
        self.city = city
        self.landmarks: tuple[Landmark, ...] = city.landmarks
        named_tokens = _named_tokens(city)
        count = Counter(t for _, t in {(i, t) for i, tokens in named_tokens for t in tokens})
        self.names = [
            _name(i, tokens, count, spelt)
            for (i, tokens), spelt in zip(named_tokens, named_tokens.values(), strict=True)
        ]
        self.spelt = [" ".join(name.tokens) for name in self.names]
        self.vocabulary: dict[str, list[Hit]] = {}
        self.joined: dict[str, list[Hit]] = {}
        for n, name in enumerate(self.names):
            for p, token in enumerate(name.tokens):
                self.vocabulary.setdefault(token, []).append(Hit(n, p, p + 1, 1.0))
                for q in range(p + 2, min(p + 5, len(name.tokens) + 1)):
                    run = "".join(name.tokens[p:q])
                    self.joined.setdefault(run, []).append(Hit(n, p, q, 1.0))
        words = lexicon()
        unlike = words.compass | words.stop
        self._alike = [
            t for t in self.vocabulary if len(t) > 3 and t not in unlike and not _digits(t)
        ]
        self._hits: dict[str, tuple[Hit, ...]] = {}
        self._known = words
        self.junction_names = self._junction_names()

    def hits(self, low: str) -> tuple[Hit, ...]:
        """Return every place in a name that this folded word may stand for."""
        found = self._hits.get(low)
        if found is None or self._known is not lexicon():
            if len(self._hits) > _CACHE or self._known is not lexicon():
                self._known = lexicon()
                self._hits.clear()
            found = self._hits[low] = self._look_up(low)
        return found

    def _look_up(self, low: str) -> tuple[Hit, ...]:
        token = canonical(low)
        hits = list(self.vocabulary.get(token, ()))
        if low == "st":
            hits += self.vocabulary.get("saint", ())
        hits += self.joined.get(token, ()) or self.joined.get(low, ())
        if hits or len(token) < 4 or _digits(token) or not token.isalpha():
            return tuple(hits)
        words = lexicon()
        known = low in words.closed and low not in words.colours
        if known or low in words.plain or token in words.compass:
            return ()
        near = process.extract(
            token, self._alike, scorer=OSA.normalized_similarity, score_cutoff=_SIMILAR, limit=8
        )
        if not near:
            return ()
        rival = process.extractOne(
            low, words.closed, scorer=OSA.normalized_similarity, score_cutoff=near[0][1] + 1e-9
        )
        if rival is not None and rival[1] > near[0][1] and OSA.distance(low, rival[0]) == 1:
            return ()
        return tuple(
            Hit(h.name, h.first, h.last, similarity)
            for other, similarity, _ in near
            for h in self.vocabulary[other]
        )

    def _junction_names(self) -> frozenset[int]:
        """Return the landmarks named after the streets that meet there, as bus stops are."""
        streets = {
            token
            for name in self.names
            if self.landmarks[name.landmark].kind in PATH_KINDS
            for token, is_informative in zip(name.tokens, name.informative, strict=True)
            if is_informative
        }
        found = set()
        for name in self.names:
            landmark = self.landmarks[name.landmark]
            informative = [
                t
                for t, is_informative in zip(name.tokens, name.informative, strict=True)
                if is_informative
            ]
            joined = re.search(r"[&+/]| and ", landmark.name or "")
            if (
                landmark.kind == "poi"
                and joined
                and len(informative) > 1
                and streets.issuperset(informative)
            ):
                found.add(name.landmark)
        return frozenset(found)


def name_index(city: CityMap) -> NameIndex:
    """Return the (cached) index of a map's names."""
    found = _INDICES.get(city.digest)
    if found is None:
        if len(_INDICES) >= 16:
            _INDICES.clear()
        found = _INDICES[city.digest] = NameIndex(city)
    return found


_INDICES: dict[str, NameIndex] = {}


def _digits(token: str) -> bool:
    return any(c.isdigit() for c in token)


def _named_tokens(city: CityMap) -> dict[tuple[int, tuple[str, ...]], tuple[str, ...]]:
    """Return the distinct names of every landmark, as canonical words -> as they are written."""
    named: dict[tuple[int, tuple[str, ...]], tuple[str, ...]] = {}
    # A shop has the name of its house among its aliases: who says it means the house.
    names = {landmark.name for landmark in city.landmarks if landmark.name}
    for i, landmark in enumerate(city.landmarks):
        own = []
        aliases = [alias for alias in landmark.aliases if alias not in names]
        for name in (landmark.name, *aliases):
            if name and not (name != landmark.name and _is_address(name, landmark)):
                tokens, spelt = _tokens(name)
                named.setdefault((i, tokens), spelt)
                own.append("".join(tokens))
        symbol = landmark.id.rsplit("/", 1)[-1]
        if landmark.name and symbol.isalpha():
            tokens, spelt = _tokens(" ".join(camel_words(symbol)))
            part = set(tokens) < set(_tokens(landmark.name)[0])
            if "".join(tokens) not in own and not part:
                named.setdefault((i, tokens), spelt)
    return {key: spelt for key, spelt in named.items() if key[1]}


def _is_address(name: str, landmark: Landmark) -> bool:
    """Whether an alias is only a number of a street, which `addresses` reads."""
    known = landmark.properties
    number, street = known.get("house_number"), known.get("addr:street")
    return name in known.get("addresses", ()) or name in (
        f"{number} {street}",
        f"{street} {number}",
    )


def _tokens(name: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the words of a name as they are compared, and as they are written."""
    words = [w.low for w in split_words(name) if w.kind != "mark" or w.low in "&+"]
    tokens = [canonical(w) for w in words]
    if len(words) > 1 and words[0] == "st":
        tokens[0] = "saint"
    return tuple(tokens), tuple(words)


def _name(
    landmark: int, tokens: tuple[str, ...], count: Counter[str], spelt: tuple[str, ...]
) -> Name:
    words = lexicon()
    weights, informative = [], []
    for token in tokens:
        light = token in words.stop or token in words.generic or token in words.compass
        informative.append(not light)
        if token in words.stop:
            weights.append(0.1)
        elif token in words.compass:
            weights.append(0.15)
        elif light:
            weights.append(0.2 if token in STREET_TYPES else 0.25)
        else:
            weights.append(max(0.8, 1.1 - 0.1 * count[token]))
    return Name(landmark, tokens, tuple(weights), tuple(informative), sum(weights), spelt)
