"""The objects that can be located: those a user declares, and the default ones."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sloop_ppl.errors import DescriptionError
from sloop_ppl.language.values import TargetObject

__all__ = ["DEFAULT_TARGETS", "load_targets"]

DEFAULT_TARGETS = (
    TargetObject(
        "GreenToyota",
        ("green toyota", "toyota", "green car", "green vehicle", "green automobile"),
        "green",
        "car",
    ),
    TargetObject(
        "RedHonda",
        ("red honda", "honda", "red car", "red vehicle", "red automobile"),
        "red",
        "car",
    ),
    TargetObject("RedBike", ("red bike", "bike", "red bicycle", "bicycle"), "red", "bike"),
)
"""The objects of the published data, meant only when a text names them."""

_FIELDS = {"id", "names", "colour", "kind"}


def load_targets(path: str | Path) -> tuple[TargetObject, ...]:
    """Read the objects that a user searches for.

    Parameters
    ----------
    path
        JSON file: a list of ``{"id", "names": [...], "colour", "kind"}``; only `id` is required.

    Raises
    ------
    DescriptionError
        When the file cannot be read or does not follow the format; the message names the entry and
        the field.

    Examples
    --------
    >>> load_targets("none.json")
    Traceback (most recent call last):
    sloop_ppl.errors.DescriptionError: Targets file 'none.json' cannot be read: No such file ...
    """
    try:
        payload = json.loads(Path(path).read_text("utf-8"))
    except OSError as error:
        raise DescriptionError(
            f"Targets file '{path}' cannot be read: {error.strerror or error}"
        ) from error
    except ValueError as error:
        raise DescriptionError(
            f"Targets file '{path}' is not JSON ({error}); expected a list of objects with an 'id'"
        ) from error
    if not isinstance(payload, list) or not payload:
        raise DescriptionError(
            f"Targets file '{path}' holds {_shown(payload)}; expected a list of objects with "
            "an 'id'"
        )
    targets = tuple(_target(path, i, entry) for i, entry in enumerate(payload))
    check_targets(targets, f"Targets file '{path}'")
    return targets


def check_targets(targets: Sequence[TargetObject], where: str = "The targets") -> None:
    """Raise `DescriptionError` when two targets share an id."""
    seen: set[str] = set()
    for target in targets:
        if target.id in seen:
            raise DescriptionError(f"{where}: id '{target.id}' is given twice; ids are unique")
        seen.add(target.id)


def _target(path: str | Path, number: int, entry: Any) -> TargetObject:
    """Return one entry of a targets file as a value."""
    where = f"Targets file '{path}', entry {number + 1}"
    if not isinstance(entry, dict):
        raise DescriptionError(f"{where} is {_shown(entry)}; expected an object with an 'id'")
    unknown = sorted(set(entry) - _FIELDS)
    if unknown:
        raise DescriptionError(
            f"{where}: field '{unknown[0]}' is unknown; expected id, names, colour, kind"
        )
    symbol = entry.get("id")
    if not isinstance(symbol, str) or not symbol.strip():
        raise DescriptionError(f"{where}: field 'id' is {_shown(symbol)}; expected a word")
    names = entry.get("names", [])
    if not isinstance(names, list) or not all(isinstance(n, str) and n.strip() for n in names):
        raise DescriptionError(
            f"{where}: field 'names' is {_shown(names)}; expected a list of words"
        )
    for field in ("colour", "kind"):
        value = entry.get(field)
        if value is not None and (not isinstance(value, str) or not value.strip()):
            raise DescriptionError(f"{where}: field '{field}' is {_shown(value)}; expected a word")
    return TargetObject(symbol, tuple(names), entry.get("colour"), entry.get("kind"))


def _shown(value: Any) -> str:
    """Return a short wording of a JSON value."""
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 40 else text[:37] + "..."
