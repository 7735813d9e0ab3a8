"""Say how probable each place is that words may refer to, before the map is asked where."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

from sloop_ppl.language.values import NOT_ON_MAP, Candidate

__all__ = ["NONE_OF_KIND", "candidates_of", "of_a_kind", "referents"]

Place = TypeVar("Place", int, str)

NONE_OF_KIND = 0.15
"""Share of "none on this map" where only a kind was said ("a bank") and the map has some.

A choice, not a fit: a map lacks some places of every kind, and who speaks of "the bank" without a
name mostly means one that both know of. It is low enough that the map's own places decide, and high
enough that a place far from all of them is not ruled out (a factor 0.15 costs 1.9 nats).
"""

_SHARPNESS = 4.0
"""Exponent of coverage: of a name half of which is said, the weight is a sixteenth."""

_NONE_OF_PART = 0.3
"""Share of "none on this map" per share of the best name that was left unsaid."""

_WHOLE = 0.995


def referents(coverages: Mapping[int, float]) -> tuple[tuple[int, float], ...]:
    """Return how probable each landmark is that words name, the rest being none on the map.

    Parameters
    ----------
    coverages
        Position of each landmark that the words fit -> share of its name that they say, (0, 1].

    Returns
    -------
    tuple
        Positions with probabilities, best first. Who says a whole name means a place of that
        name, equally probable when there are several; who says a part means each place in
        proportion to coverage^4, and with 0.3 (1 - the best coverage) none of them.

    Examples
    --------
    >>> referents({7: 1.0, 3: 0.5})
    ((7, 1.0),)
    >>> [(i, round(p, 2)) for i, p in referents({7: 0.8, 3: 0.5})]
    [(7, 0.82), (3, 0.12)]
    """
    best = max(coverages.values())
    if best >= _WHOLE:
        whole = [i for i, c in coverages.items() if c >= _WHOLE]
        return tuple((i, 1 / len(whole)) for i in whole)
    known = 1 - _NONE_OF_PART * (1 - best)
    weights = {i: c**_SHARPNESS for i, c in coverages.items()}
    return _shares(weights, known)


def of_a_kind(
    weights: Mapping[Place, float], none: float = NONE_OF_KIND
) -> tuple[tuple[Place, float], ...]:
    """Return how probable each landmark of a kind is, in proportion to its weight.

    Parameters
    ----------
    weights
        Id or position -> weight, >= 0, not all 0.
    none
        Share of places that are not on the map.
    """
    return _shares(weights, 1 - none)


def _shares(weights: Mapping[Place, float], known: float) -> tuple[tuple[Place, float], ...]:
    total = sum(weights.values())
    shares = [(i, known * w / total) for i, w in weights.items() if w > 0]
    return tuple(sorted(shares, key=lambda share: -share[1]))


def candidates_of(shares: Sequence[tuple[str, float]]) -> tuple[Candidate, ...]:
    """Return ids with shares as candidates that sum to one, none on the map last.

    Examples
    --------
    >>> candidates_of([("Ivy", 0.75)])
    (Candidate(ground='Ivy', probability=0.75), Candidate(ground=None, probability=0.25))
    """
    if not shares:
        return (Candidate(None, 1.0),)
    rest = 1 - sum(p for _, p in shares)
    known = [Candidate(i, p) for i, p in shares if i != NOT_ON_MAP]
    if rest < 1e-9:
        return tuple(known)
    return (*known, Candidate(None, rest))
