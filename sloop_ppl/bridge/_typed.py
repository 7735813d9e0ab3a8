"""Read what a user types: places and starts such as ``GreenToyota=-37.5,-72.5``, and settings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields
from typing import Any

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.planning import SearchConfig

__all__ = ["read_hearer", "read_places", "read_settings", "read_start"]


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


_OWN_OPTION = {
    "sensor_range_cells": "--range",
    "fov_deg": "--fov",
    "sims": "--sims",
    "max_steps": "--steps",
    "rollout": "--rollout",
    "find_each": "--find-each",
}
_TRUTHS = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}


def read_settings(typed: Sequence[str]) -> dict[str, Any]:
    """Return names of settings -> values.

    Parameters
    ----------
    typed
        One ``NAME=VALUE`` per setting; see `SearchConfig` for the names.

    Raises
    ------
    InputError
        When one is malformed, given twice, or has an option of its own.
    UnknownName
        When there is no such setting.

    Examples
    --------
    >>> read_settings(["no_fly=true", "turn_deg=90"])
    {'no_fly': True, 'turn_deg': 90}
    """
    kinds = {f.name: str(f.type) for f in fields(SearchConfig)}
    settable = [name for name in kinds if name not in _OWN_OPTION]
    values: dict[str, Any] = {}
    for text in typed:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not value:
            raise InputError(f"Setting '{text}' is malformed; expected NAME=VALUE, as no_fly=true")
        if name in _OWN_OPTION:
            raise InputError(f"Setting '{name}' has an option of its own; give {_OWN_OPTION[name]}")
        if name not in kinds:
            raise UnknownName("setting", name, settable)
        if name in values:
            raise InputError(f"Setting '{name}' is given twice; give it once")
        values[name] = _value(name, kinds[name], value)
    return values


def _value(name: str, kind: str, text: str) -> bool | int | float:
    try:
        if kind == "bool":
            return _TRUTHS[text.lower()]
        return int(text) if kind.startswith("int") else float(text)
    except (KeyError, ValueError):
        wanted = "true or false" if kind == "bool" else "a number"
        wanted = "a whole number" if kind.startswith("int") else wanted
        raise InputError(f"Setting '{name}' is '{text}'; expected {wanted}") from None
