"""The objects that can be located: those a user declares, and the default ones."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

from msgspec import Meta, Struct

from sloop_ppl._foreign import ForeignFault, parse_json, read_text
from sloop_ppl._records import Fault, checked
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

Word = Annotated[str, Meta(pattern=r"\S", description="a word")]


class _Entry(Struct):
    """One object of a targets file."""

    id: Word
    names: Annotated[list[Word], Meta(description="a list of words")] = []
    colour: Word | None = None
    kind: Word | None = None


_FIELDS = set(_Entry.__struct_fields__)


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
    text = read_text(path, "Targets file", error=DescriptionError)
    try:
        payload = parse_json(text)
    except ForeignFault as error:
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
    try:
        made = checked(entry, _Entry)
    except Fault as fault:
        raise DescriptionError(f"{where}: {fault}") from fault
    return TargetObject(made.id, tuple(made.names), made.colour, made.kind)


def _shown(value: Any) -> str:
    """Return a short wording of a JSON value."""
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 40 else text[:37] + "..."
