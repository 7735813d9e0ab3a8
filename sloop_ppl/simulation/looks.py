"""What the targets look like: kinds with their size, and colours."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from sloop_ppl.errors import UnknownName

__all__ = ["COLOURS", "KIND_SIZES", "Look", "look_of"]

KIND_SIZES: Mapping[str, tuple[float, float, float]] = MappingProxyType(
    {
        "car": (4.3, 1.8, 1.45),
        "van": (5.4, 2.0, 2.4),
        "bike": (1.8, 0.6, 1.2),
        "person": (0.5, 0.5, 1.75),
    }
)
"""Length, width and height of each kind of target, metres."""

COLOURS: Mapping[str, tuple[float, float, float]] = MappingProxyType(
    {
        "red": (0.80, 0.05, 0.06),
        "green": (0.04, 0.55, 0.14),
        "blue": (0.06, 0.20, 0.80),
        "yellow": (0.90, 0.80, 0.05),
        "orange": (0.92, 0.45, 0.04),
        "purple": (0.45, 0.08, 0.60),
        "pink": (0.92, 0.30, 0.60),
        "white": (0.90, 0.90, 0.90),
        "silver": (0.68, 0.69, 0.70),
        "grey": (0.42, 0.43, 0.44),
        "black": (0.08, 0.08, 0.09),
        "brown": (0.34, 0.20, 0.11),
    }
)
"""Colours of targets, red, green and blue in [0, 1]."""

_KIND_WORDS = {
    "bike": "bike", "bicycle": "bike", "cyclist": "bike", "motorbike": "bike",
    "van": "van", "truck": "van", "bus": "van", "lorry": "van",
    "person": "person", "man": "person", "woman": "person", "pedestrian": "person",
    "me": "person", "child": "person", "boy": "person", "girl": "person",
}  # fmt: skip


@dataclass(frozen=True)
class Look:
    """What a target looks like.

    Parameters
    ----------
    kind
        One of `KIND_SIZES`.
    colour
        One of `COLOURS`.

    Raises
    ------
    UnknownName
        When the simulator has no such kind or colour.
    """

    kind: str = "car"
    colour: str = "red"

    def __post_init__(self) -> None:
        if self.kind not in KIND_SIZES:
            raise UnknownName("kind of target", self.kind, KIND_SIZES)
        if self.colour not in COLOURS:
            raise UnknownName("colour of a target", self.colour, COLOURS)

    @property
    def size_m(self) -> tuple[float, float, float]:
        """Length, width and height."""
        return KIND_SIZES[self.kind]


def look_of(target_id: str, kind: str | None = None, colour: str | None = None) -> Look:
    """Return the look of a target, guessed from its id where it is not given.

    Parameters
    ----------
    target_id
        CamelCase id; its words may name a colour and a kind.
    kind, colour
        Words for them; one that the simulator does not know counts as not given.

    Notes
    -----
    What names no kind is a car, what names no colour is red.

    Examples
    --------
    >>> look_of("GreenToyota")
    Look(kind='car', colour='green')
    >>> look_of("MyDog", kind="van", colour="blue")
    Look(kind='van', colour='blue')
    """
    words = [w.lower() for w in re.findall(r"[A-Z]?[a-z]+|[A-Z]+", target_id)]
    kinds = [kind or "", *words]
    colours = [colour or "", *words]
    found = (w if w in KIND_SIZES else _KIND_WORDS.get(w) for w in kinds)
    return Look(
        next((k for k in found if k), "car"), next((c for c in colours if c in COLOURS), "red")
    )
