"""Read places that a user types, such as ``GreenToyota=-37.5,-72.5``."""

from __future__ import annotations

import math
from collections.abc import Sequence

from sloop_ppl.errors import InputError

__all__ = ["read_hearer", "read_places", "read_start"]


def read_places(typed: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Return target -> x and y in metres.

    Parameters
    ----------
    typed
        One ``OBJECT=x,y`` per target.

    Raises
    ------
    InputError
        When one is malformed, repeated or not finite.

    Examples
    --------
    >>> read_places(["GreenToyota=-37.5,-72.5"])
    {'GreenToyota': (-37.5, -72.5)}
    """
    places: dict[str, tuple[float, float]] = {}
    for text in typed:
        name, sign, numbers = text.partition("=")
        values = _numbers(numbers)
        if not name.strip() or not sign or len(values) != 2:
            raise InputError(
                f"Place '{text}' is malformed; expected OBJECT=x,y in metres, such as "
                "GreenToyota=-37.5,-72.5"
            )
        if name.strip() in places:
            raise InputError(f"Place of '{name.strip()}' is given twice; give it once")
        places[name.strip()] = values[0], values[1]
    return places


def read_start(typed: str | None) -> tuple[float, ...] | None:
    """Return ``(x, y)`` or ``(x, y, heading)`` of a typed start; None when none is given.

    Raises
    ------
    InputError
        When it is malformed or not finite.
    """
    if typed is None:
        return None
    values = _numbers(typed)
    if len(values) not in (2, 3):
        raise InputError(
            f"Start '{typed}' is malformed; expected x,y or x,y,heading in metres and degrees"
        )
    return tuple(values)


def read_hearer(typed: str | None) -> tuple[float, float] | None:
    """Return x and y, in metres, of where who listens is; None when it is not given.

    Raises
    ------
    InputError
        When it is malformed or not finite.

    Examples
    --------
    >>> read_hearer("-20,150")
    (-20.0, 150.0)
    """
    if typed is None:
        return None
    values = _numbers(typed)
    if len(values) != 2:
        raise InputError(
            f"Hearer '{typed}' is malformed; expected x,y in metres, such as -20,150: where who "
            "listens is, inside the map or outside"
        )
    return values[0], values[1]


def _numbers(text: str) -> list[float]:
    """Return comma-separated finite numbers, or nothing when one of them is not."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        return []
    return values if all(map(math.isfinite, values)) else []
