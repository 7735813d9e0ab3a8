"""Put a part of a street into words."""

from __future__ import annotations

import math

from sloop_ppl.language.street_parts import StreetPart
from sloop_ppl.maps._whereabouts import COMPASS_POINTS

__all__ = ["part_in_words"]

_PARITY = {1: "odd", 2: "even"}


def part_in_words(part: StreetPart | None, ground: str) -> str:
    """Return a part of a ground, such as "north side of Forbes Avenue"; the ground without a part.

    Examples
    --------
    >>> part_in_words(StreetPart("side", 1.57), "Forbes Avenue")
    'north side of Forbes Avenue'
    >>> part_in_words(StreetPart("number", number=4400), "Forbes Avenue")
    '4400 Forbes Avenue'
    """
    if part is None:
        return ground
    if part.kind == "number":
        return f"{part.number} {ground}"
    noun = {"mid-block": "middle of the block", "block-corner": "corner of the block"}.get(
        part.kind, part.kind
    )
    which = _PARITY.get(part.number or 0, "")
    if part.bearing_rad is not None:
        which = COMPASS_POINTS[round(part.bearing_rad / (math.pi / 4)) % 8]
    joint = "on" if part.kind in ("mid-block", "block-corner") else "of"
    return f"{f'{which} ' if which else ''}{noun} {joint} {ground}"
