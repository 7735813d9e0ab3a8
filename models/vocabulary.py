"""What a speaker could have said of a ground: a word for each meaning, and its plain English."""

from __future__ import annotations

import re
from collections.abc import Sequence

from sloop_ppl.errors import InputError
from sloop_ppl.language import SpatialRelation, TargetObject
from sloop_ppl.maps import CityMap

__all__ = ["SPEAKER_WORDS", "TEMPLATES", "in_english", "speakable_grounds"]

SPEAKER_WORDS = (
    "at",
    "near",
    "north",
    "northeast",
    "east",
    "southeast",
    "south",
    "southwest",
    "west",
    "northwest",
    "front",
    "behind",
    "left",
    "right",
)
"""Relation words a simulated speaker chooses from, one per meaning that models tell apart."""

TEMPLATES: dict[str, str] = {
    "at": "at",
    "near": "near",
    "front": "in front of",
    "behind": "behind",
    "left": "to the left of",
    "right": "to the right of",
    **{
        word: f"{word} of"
        for word in (
            "north", "northeast", "east", "southeast", "south", "southwest", "west", "northwest",
        )
    },
}  # fmt: skip
"""Relation word of a simulated speaker -> the English that a ground's name follows."""

_JOINS = {"and", "at", "&", "/", ",", "@", "…"}


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
    relations : of one ground each, with a word of `TEMPLATES`.
    targets : the figures; each is called by the first of its names.
    city : the map, whose names of the grounds are used.

    Raises
    ------
    InputError : for a relation there is no template for.

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
        if relation.relation not in TEMPLATES or len(relation.grounds) > 1:
            raise InputError(
                f"Relation '{relation.relation}' of {len(relation.grounds)} grounds has no "
                f"template; expected one ground and one of {', '.join(TEMPLATES)}"
            )
        name = city.landmark(relation.ground).name
        denied = "not " if relation.negated else ""
        sentences.append(
            f"The {called[relation.figure]} is {denied}{TEMPLATES[relation.relation]} {name}."
        )
    return " ".join(sentences)
