"""Read what a user types: places and starts such as ``GreenToyota=-37.5,-72.5``, and settings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields
from typing import Any

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import Grid
from sloop_ppl.maps._given_point import DEGREES, GivenPoint, read_point

__all__ = ["point_questions", "read_hearer", "read_places", "read_settings", "read_start"]


def read_places(typed: Sequence[str]) -> dict[str, GivenPoint]:
    """Return target -> its place as it was given; `GivenPoint.on` puts it on a map.

    Parameters
    ----------
    typed
        One ``OBJECT=x,y`` (metres) or ``OBJECT=@lat,lon`` (degrees) per target.

    Raises
    ------
    InputError
        When one is malformed, repeated or not finite.

    Examples
    --------
    >>> read_places(["GreenToyota=-37.5,-72.5"])
    {'GreenToyota': GivenPoint(first=-37.5, second=-72.5, in_degrees=False)}
    """
    places: dict[str, GivenPoint] = {}
    for text in typed:
        name, sign, numbers = text.partition("=")
        point = read_point(numbers)
        if not name.strip() or not sign or point is None:
            raise InputError(
                f"Place '{text}' is malformed; expected OBJECT=x,y in metres, such as "
                f"GreenToyota=-37.5,-72.5, or {DEGREES}"
            )
        if name.strip() in places:
            raise InputError(f"Place of '{name.strip()}' is given twice; give it once")
        places[name.strip()] = point
    return places


def read_start(typed: str | None) -> tuple[GivenPoint, tuple[float, ...]] | None:
    """Return the point of a typed start and its heading, if there is one; None when none is given.

    Raises
    ------
    InputError
        When it is malformed or not finite.

    Examples
    --------
    >>> read_start("41.4993N,81.6944W,90")
    (GivenPoint(first=41.4993, second=-81.6944, in_degrees=True), (90.0,))
    """
    if typed is None:
        return None
    point, heading = read_point(typed), list[float]()
    if point is None:
        before, _, last = typed.rpartition(",")
        heading = _numbers(last)
        point = read_point(before) if heading else None
    if point is None:
        raise InputError(
            f"Start '{typed}' is malformed; expected x,y or x,y,heading in metres and degrees, or "
            f"the point as {DEGREES}"
        )
    return point, tuple(heading)


def read_hearer(typed: str | None) -> GivenPoint | None:
    """Return where who listens is, as it was given; None when it is not.

    Raises
    ------
    InputError
        When it is malformed or not finite.

    Examples
    --------
    >>> read_hearer("-20,150")
    GivenPoint(first=-20.0, second=150.0, in_degrees=False)
    """
    if typed is None:
        return None
    point = read_point(typed)
    if point is None:
        raise InputError(
            f"Hearer '{typed}' is malformed; expected x,y in metres, such as -20,150, or "
            f"{DEGREES}: where who listens is, inside the map or outside"
        )
    return point


def point_questions(
    grid: Grid,
    places: Sequence[str] = (),
    start: str | None = None,
    hearer: str | None = None,
) -> list[str]:
    """Return a line for each typed point of metres that would be degrees of the map, too."""
    asked = [
        (f"--place {text}", point) for text in places for point in read_places([text]).values()
    ]
    begun, listens = read_start(start), read_hearer(hearer)
    if begun is not None:
        asked.append((f"--start {start}", begun[0]))
    if listens is not None:
        asked.append((f"--hearer {hearer}", listens))
    return [line for written, point in asked if (line := point.question(grid, written))]


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
    from sloop_ppl.planning import SearchConfig

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
