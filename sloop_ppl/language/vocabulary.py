"""The canonical relation words and the classes that evaluation merges them into."""

from __future__ import annotations

from sloop_ppl.errors import UnknownName

__all__ = [
    "COMPASS",
    "FRAME_RELATIONS",
    "RELATIONS",
    "RELATION_CLASSES",
    "WHOLE_MAP",
    "check_relation",
]

RELATION_CLASSES: dict[str, tuple[str, ...]] = {
    "contact": ("on", "at", "in", "inside", "along", "within", "middle", "side", "adjacent"),
    "proximity": (
        "near", "beside", "next", "by", "around", "close", "outside", "towards", "against",
        "off", "beyond",
    ),
    "between": ("between",),
    "north": ("north", "above", "up", "top"),
    "south": ("south", "below", "down", "under"),
    "east": ("east",),
    "west": ("west",),
    "northeast": ("northeast",),
    "northwest": ("northwest",),
    "southeast": ("southeast",),
    "southwest": ("southwest",),
    "front": ("front",),
    "behind": ("behind",),
    "left": ("left",),
    "right": ("right",),
    "across": ("across",),
}  # fmt: skip
"""Class of relations -> the canonical words in it, the class's own name among them or not."""

RELATIONS: dict[str, str] = {
    word: name for name, words in RELATION_CLASSES.items() for word in words
}
"""Canonical relation word -> its class."""

COMPASS = (
    "north", "south", "east", "west", "northeast", "northwest", "southeast", "southwest",
)  # fmt: skip
"""Classes whose direction is fixed by the map."""

WHOLE_MAP = "Map"
"""Id of the map itself as a ground ("the top left of the map"), unless a landmark has it."""

FRAME_RELATIONS = ("front", "behind", "left", "right")
"""Classes whose direction depends on which way the ground faces."""


def check_relation(word: str) -> str:
    """Return `word` when it is a canonical relation.

    Raises
    ------
    UnknownName : when it is not; the message lists the words and the nearest of them.
    """
    if word not in RELATIONS:
        raise UnknownName("relation", word, RELATIONS)
    return word
