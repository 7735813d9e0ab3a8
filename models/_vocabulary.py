"""What a speaker could have said of a ground: a word for each meaning, and its plain English."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from functools import lru_cache

from sloop_ppl.errors import InputError
from sloop_ppl.language import RELATIONS, SpatialRelation, TargetObject
from sloop_ppl.maps import CityMap

__all__ = ["in_english", "speakable_grounds", "speaker_words"]

_JOINS = {"and", "at", "&", "/", ",", "@", "…"}


def speaker_words() -> tuple[str, ...]:
    """Return the words a simulated speaker chooses from, one per meaning that models tell apart.

    What has no direction comes first, then compass words clockwise from north, then frame words:
    draws depend on the order, so it is part of what a seed means.

    Examples
    --------
    >>> speaker_words()[:4]
    ('at', 'near', 'north', 'northeast')
    """
    return _speaker_words(RELATIONS.changes)


@lru_cache(maxsize=8)
def _speaker_words(changes: int) -> tuple[str, ...]:  # noqa: ARG001
    return tuple(sorted((word for word, r in RELATIONS.items() if r.speakable), key=_turn))


def _turn(word: str) -> tuple[int, float]:
    record = RELATIONS[word]
    if record.bearing_rad is None:
        return (2 if record.needs_frame else 0), 0.0
    return 1, (math.pi / 2 - record.bearing_rad) % (2 * math.pi)


def speakable_grounds(city: CityMap) -> tuple[str, ...]:
    """Return the ids of the landmarks whose name can only be read as theirs, in map order.

    A name that another landmark has, that is part of another's name or has another's in it, that
    begins with a word of another's, or that joins names ("A & B", "A / B") may be read otherwise.
    """
    return city.derived("speakable grounds", lambda: _speakable(city))


def _speakable(city: CityMap) -> tuple[str, ...]:
    called = {
        landmark.id: [name.casefold() for name in (landmark.name, *landmark.aliases) if name]
        for landmark in city.landmarks
    }
    return tuple(
        landmark.id
        for landmark in city.landmarks
        if landmark.name
        and _is_plain(
            landmark.name.casefold(),
            [name for other, names in called.items() if other != landmark.id for name in names],
        )
    )


def _is_plain(name: str, names: Sequence[str]) -> bool:
    """Tell whether a name cannot be taken for one of the others."""
    words = _words(name)
    first = next((word for word in words if word != "the"), "")
    related = any(other in name or name in other or first in _words(other) for other in names)
    return not related and not _JOINS & set(words)


def _words(name: str) -> list[str]:
    return re.findall(r"\w+|[^\w\s]", name)


def in_english(
    relations: Sequence[SpatialRelation], targets: Sequence[TargetObject], city: CityMap
) -> str:
    """Return one sentence per relation.

    Parameters
    ----------
    relations
        Relations of as many grounds each as the word takes.
    targets
        The figures; each is called by the first of its names.
    city
        The map, whose names of the grounds are used.

    Raises
    ------
    InputError
        For a corner of several grounds, or "between" one.

    Examples
    --------
    >>> from sloop_ppl.language import DEFAULT_TARGETS
    >>> from sloop_ppl.maps import load_map
    >>> said = [SpatialRelation("RedBike", "front", ("Ivy",))]
    >>> in_english(said, DEFAULT_TARGETS, load_map("cleveland"))
    'The red bike is in front of Ivy.'
    """
    called = {target.id: (target.names or (target.id,))[0] for target in targets}
    sentences = []
    for relation in relations:
        record = RELATIONS[relation.relation]
        if not record.takes(len(relation.grounds)):
            raise InputError(
                f"Relation '{relation.relation}' of {len(relation.grounds)} grounds has no "
                f"template; expected {record.grounds} of them"
            )
        names = " and ".join(str(city.landmark(ground).name) for ground in relation.grounds)
        denied = "not " if relation.negated else ""
        sentences.append(f"The {called[relation.figure]} is {denied}{record.phrase} {names}.")
    return " ".join(sentences)
