"""Parts of a street, a crossing or a block that a description names."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

from sloop_ppl.errors import DescriptionError

__all__ = ["StreetPart", "StreetPartKind"]

StreetPartKind: TypeAlias = Literal[
    "side", "corner", "block-corner", "mid-block", "end", "number", "block"
]


@dataclass(frozen=True)
class StreetPart:
    """The part of its ground that a relation is about: "the north side of", "the SW corner of".

    Parameters
    ----------
    kind
        ``"side"`` of a street; ``"corner"``, where the street meets another, or all streets of the
        relation meet; ``"block-corner"``, a corner of a block along the street, as its bearing
        says; ``"mid-block"``, away from corners; ``"end"`` of a street; house
        ``"number"`` on a street; ``"block"``, the block of the ground, whatever it is.
    bearing_rad
        Which side, corner or end is meant: its direction, radians anticlockwise from east; None
        when any may be.
    number
        The house number; of a side 1 for the odd and 2 for the even one.

    Raises
    ------
    DescriptionError
        When the kind is none, the bearing not finite, or a house number missing or below 1.

    Examples
    --------
    >>> StreetPart("side", math.pi / 2).kind
    'side'
    """

    kind: StreetPartKind
    bearing_rad: float | None = None
    number: int | None = None

    def __post_init__(self) -> None:
        if self.kind not in get_args(StreetPartKind):
            raise DescriptionError(
                f"Part '{self.kind}' of a street is none; expected one of "
                f"{', '.join(get_args(StreetPartKind))}"
            )
        if self.bearing_rad is not None and not math.isfinite(self.bearing_rad):
            raise DescriptionError(
                f"The bearing of part '{self.kind}' is {self.bearing_rad}; expected a finite "
                "number of radians"
            )
        wanted = self.kind == "number"
        if (wanted and self.number is None) or (self.number is not None and self.number < 1):
            raise DescriptionError(
                f"The number of part '{self.kind}' is {self.number}; expected a house number of "
                "at least 1"
            )
