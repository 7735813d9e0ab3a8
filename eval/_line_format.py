"""The format of a line of a description file, and the one message for a value that breaks it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeVar

import msgspec
from msgspec import Meta, Struct, inspect

__all__ = [
    "AnnotationLine",
    "EntryLine",
    "Fault",
    "FrameLine",
    "HearerLine",
    "Line",
    "ObjectLine",
    "PlaceLine",
    "checked",
]

T = TypeVar("T")

Text = Annotated[str, Meta(pattern=r"\S", description="a text")]
# The bounds exclude nan and inf.
Number = Annotated[float, Meta(ge=-1e300, le=1e300, description="a finite number")]
Pair = Annotated[tuple[Number, Number], Meta(description="two numbers")]
Flag = Annotated[bool, Meta(description="true or false")]
Object = Annotated[dict[str, Any], Meta(description="an object")]
Texts = Annotated[list[Text], Meta(description="a list of texts")]
GoldStatus = Literal[
    "asserted", "denied", "alternative", "asked", "retracted", "past", "route", "other", "unknown"
]
GroundClass = Literal["named", "own_kind", "hearer", "other"]


class Fault(Exception):
    """What is wrong with one field of one line; the reader turns it into an InputError.

    Attributes
    ----------
    field
        Path of the field, such as ``"targets.RedBike.east_m"``.
    what
        What was found and what was expected, to be read after the field.
    """

    def __init__(self, field: str, what: str) -> None:
        self.field, self.what = field, what
        super().__init__(f"field '{field}' {what}")


class PlaceLine(Struct, frozen=True):
    """Where a target is."""

    east_m: Number
    north_m: Number
    lonlat: Pair | None = None
    col_from_west: Number | None = None
    row_from_north: Number | None = None


class HearerLine(Struct, frozen=True):
    """Where who listens is."""

    east_m: Number
    north_m: Number


class ObjectLine(Struct, frozen=True):
    """An object that may be spoken of."""

    id: Text
    names: Texts = []
    colour: Text | None = None
    kind: Text | None = None


class EntryLine(Struct, frozen=True):
    """One figure in one relation to one ground."""

    figure: Text
    relation: Text
    ground: Text | None = None
    negated: Flag = False
    group: Annotated[int | str | None, Meta(description="a number or a text")] = None
    also: Texts = []
    kind: Text | None = None
    optional: Flag = False
    status: (
        Annotated[
            GoldStatus,
            Meta(
                description="asserted, denied, alternative, asked, retracted, past, route, other "
                "or unknown"
            ),
        ]
        | None
    ) = None
    either: (
        Annotated[tuple[int, int], Meta(description="two numbers: the group and its branch")] | None
    ) = None
    distance_m: Annotated[
        float | tuple[float | None, float | None] | None,
        Meta(description="a number of metres, or the lower and the upper bound"),
    ] = None
    ground_class: (
        Annotated[GroundClass, Meta(description="named, own_kind, hearer or other")] | None
    ) = msgspec.field(default=None, name="class")


class FrameLine(Struct, frozen=True):
    """Which way an annotator saw a ground face."""

    ground: Text
    relation: Text
    front_deg: Number
    annotator: Text | None = None


Entries = Annotated[list[EntryLine], Meta(description="a list")]


class Line(Struct, frozen=True):
    """One description. Places are checked one by one, for messages that name the target."""

    id: Text
    map: Text
    text: Text
    targets: Object | None = None
    relations: Entries | None = None
    configuration: Text | None = None
    speaker: Text | None = None
    viewpoint: Text = "map"
    frames: Annotated[list[FrameLine], Meta(description="a list")] | None = None
    phenomena: Texts = []
    objects: Annotated[list[ObjectLine], Meta(description="a list of objects")] | None = None
    area_m: (
        Annotated[
            tuple[Number, Number, Number, Number],
            Meta(description="four numbers: west, south, east, north"),
        ]
        | None
    ) = None
    hearer: HearerLine | None = None


class AnnotationLine(Struct, frozen=True):
    """The relations of a line whose text is in another file."""

    id: Text
    relations: Entries


def checked(data: object, kind: type[T], path: str = "") -> T:
    """Return parsed JSON as one of the records of this module.

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
    steps = re.findall(r"\.(\w+)|\[(\d+)\]", place)
    missing = re.match(r"Object missing required field `(\w+)`", message)
    if missing:
        steps.append((missing[1], ""))
    where, type_ = path, inspect.type_info(kind)
    for name, index in steps:
        where += f"[{index}]" if index else f"{'.' if where else ''}{name}"
        known = _words(type_)
        type_ = _inside(type_, name)
        if index and not (_words(type_) or _is_object(type_)):
            return Fault(where[: -len(index) - 2], f"is {data!r}; expected {known}")
        if not missing or (name, index) != steps[-1]:
            data = data[int(index)] if index else data[name]  # type: ignore[index]
    expected = _words(type_) or "an object"
    if missing:
        return Fault(where, f"is missing; expected {expected}")
    container = expected.startswith(("an object", "a list")) or isinstance(data, Mapping)
    found = f"a {type(data).__name__}" if container and data is not None else repr(data)
    return Fault(where or "line", f"is {found}; expected {expected}")


def _is_object(type_: inspect.Type) -> bool:
    return isinstance(_plain(type_), inspect.StructType)


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
