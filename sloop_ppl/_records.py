"""Check what a file holds against a record, with one kind of message for a field that breaks it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, TypeVar

import msgspec
from msgspec import Meta, inspect

from sloop_ppl.errors import on_one_line

__all__ = ["Fault", "Text", "Texts", "checked"]

T = TypeVar("T")

Text = Annotated[str, Meta(pattern=r"\S", description="a text")]
Texts = Annotated[list[Text], Meta(description="a list of texts")]


class Fault(Exception):
    """What is wrong with one field of one record; the reader turns it into an InputError.

    Attributes
    ----------
    field
        Path of the field, such as ``"targets.RedBike.east_m"``.
    what
        What was found and what was expected, to be read after the field.
    """

    def __init__(self, field: str, what: str) -> None:
        self.field, self.what = on_one_line(field), on_one_line(what, 2000)
        super().__init__(f"field '{self.field}' {self.what}")


def checked(data: object, kind: type[T], path: str = "") -> T:
    """Return parsed JSON as a record.

    Parameters
    ----------
    data
        What was parsed.
    kind
        The record.
    path
        What stands before its fields' names in messages.

    Raises
    ------
    Fault
        For the first field that breaks the format.
    """
    try:
        return msgspec.convert(data, kind)
    except msgspec.ValidationError as error:
        raise _fault(str(error), data, kind, path) from error


def _fault(message: str, data: object, kind: type, path: str) -> Fault:
    """Say of what msgspec found which field it is, what is there and what was expected."""
    _, _, place = message.partition(" - at `$")
    place = place.partition("[...]")[0]  # a member of a mapping, which msgspec does not name
    steps = re.findall(r"\.(\w+)|\[(\d+)\]", place)
    missing = re.match(r"Object missing required field `(\w+)`", message)
    if missing:
        steps.append((missing[1], ""))
    where, type_ = path, inspect.type_info(kind)
    for name, index in steps:
        where += f"[{index}]" if index else f"{'.' if where else ''}{name}"
        known = _words(type_)
        type_ = _inside(type_, name)
        if index and not (_words(type_) or _is_container(type_)):
            return Fault(where[: -len(index) - 2], f"is {_shown(data)}; expected {known}")
        if not missing or (name, index) != steps[-1]:
            data = data[int(index)] if index else data[name]  # type: ignore[index]
    expected = _words(type_) or "an object"
    if missing:
        return Fault(where, f"is missing; expected {expected}")
    container = expected.startswith(("an object", "a list")) or isinstance(data, Mapping)
    found = f"a {type(data).__name__}" if container and data is not None else _shown(data)
    return Fault(where or "line", f"is {found}; expected {expected}")


def _shown(data: object) -> str:
    text = repr(data)
    return text if len(text) <= 120 else f"{text[:80]}...{text[-30:]}"


def _is_container(type_: inspect.Type) -> bool:
    """Tell whether a field of a value can be named: of a record, or of a list in a list."""
    return isinstance(_plain(type_), inspect.StructType | inspect.ListType)


def _plain(type_: inspect.Type) -> inspect.Type:
    """Return a type without its metadata, and without null."""
    while isinstance(type_, inspect.Metadata):
        type_ = type_.type
    if isinstance(type_, inspect.UnionType):
        rest = [t for t in type_.types if not isinstance(t, inspect.NoneType)]
        return _plain(rest[0]) if len(rest) == 1 else type_
    return type_


def _inside(type_: inspect.Type, name: str) -> inspect.Type:
    """Return the type of a field of a record, or of the members of a list."""
    plain = _plain(type_)
    if isinstance(plain, inspect.StructType):
        return next(f.type for f in plain.fields if f.encode_name == name)
    if isinstance(plain, inspect.ListType):
        return plain.item_type
    return inspect.AnyType()


def _words(type_: inspect.Type) -> str:
    """Return what a field's values are in words; none for records and for parts of a value."""
    if isinstance(type_, inspect.Metadata):
        return str((type_.extra_json_schema or {}).get("description", "")) or _words(type_.type)
    if isinstance(type_, inspect.UnionType):
        return next(filter(None, map(_words, type_.types)), "")
    return ""
