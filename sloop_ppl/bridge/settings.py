"""Read settings of a search that have no option of their own, such as ``no_fly=true``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.planning import SearchConfig

__all__ = ["read_settings"]

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
