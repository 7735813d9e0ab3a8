"""Hold what some words of a text name."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["LandmarkMention"]


@dataclass(frozen=True, slots=True)
class LandmarkMention:
    """Words that name a landmark.

    Parameters
    ----------
    first, last
        Half-open range of words.
    candidates
        Positions of landmarks in the map, best first; several when the words do not tell them
        apart.
    score
        Share of the name's weight that was found, in (0, 1].
    rivals
        Positions of landmarks that fit the words less well.
    shares
        Position of every landmark that may be meant, with its probability, best first; what is
        left to one is the share of places that are not on the map.
    number
        House number that was said with a street, where the map has no such house on it.
    """

    first: int
    last: int
    candidates: tuple[int, ...]
    score: float
    rivals: tuple[int, ...] = ()
    shares: tuple[tuple[int, float], ...] = ()
    number: int | None = None
