"""The format of a line of a description file."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta, Struct

from sloop_ppl._records import Fault, Text, Texts, checked

__all__ = [
    "AnnotationLine",
    "EntryLine",
    "Fault",
    "FrameLine",
    "HearerLine",
    "Line",
    "ObjectLine",
    "PartLine",
    "PlaceLine",
    "checked",
]

# The bounds exclude nan and inf.
Number = Annotated[float, Meta(ge=-1e300, le=1e300, description="a finite number")]
Pair = Annotated[tuple[Number, Number], Meta(description="two numbers")]
Flag = Annotated[bool, Meta(description="true or false")]
Object = Annotated[dict[str, Any], Meta(description="an object")]
GoldStatus = Literal[
    "asserted", "denied", "alternative", "asked", "retracted", "past", "route", "other", "unknown"
]
GroundClass = Literal["named", "own_kind", "hearer", "other"]


class PlaceLine(Struct, frozen=True):
    """Where a target is: metres, degrees, or both."""

    east_m: Number | None = None
    north_m: Number | None = None
    lonlat: Pair | None = None
    col_from_west: Number | None = None
    row_from_north: Number | None = None


class HearerLine(Struct, frozen=True):
    """Where who listens is: metres, degrees, or both."""

    east_m: Number | None = None
    north_m: Number | None = None
    lonlat: Pair | None = None


class ObjectLine(Struct, frozen=True):
    """An object that may be spoken of."""

    id: Text
    names: Texts = []
    colour: Text | None = None
    kind: Text | None = None


class PartLine(Struct, frozen=True):
    """Which part of its ground a relation is about."""

    kind: Text
    bearing_deg: Number | None = None
    number: int | None = None


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
    part: PartLine | None = None
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
