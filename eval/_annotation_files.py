"""Files of annotations: what texts say, without the texts."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sloop_ppl._foreign import ForeignFault, parse_json, read_text
from sloop_ppl.errors import InputError
from sloop_ppl.eval._gold import GoldEntry, gold_entries
from sloop_ppl.eval._line_format import AnnotationLine, Fault, checked
from sloop_ppl.language import StreetPart

__all__ = ["read_annotations", "write_annotations"]


def read_annotations(path: str | Path) -> dict[str, tuple[GoldEntry, ...]]:
    """Return id -> what a text says, by a file of annotations; ids of grounds are not checked.

    Parameters
    ----------
    path
        One JSON object a line, with ``id`` and ``relations`` as in description files.

    Raises
    ------
    InputError
        When the file cannot be read, and for the first line that does not follow the format.
    """
    text = read_text(path, "Annotations")
    found = {}
    for number, line in enumerate(text.split("\n"), start=1):
        if not line.strip():
            continue
        try:
            known = checked(parse_json(line, finite=False), AnnotationLine)
            found[known.id] = gold_entries(known.relations)
        except Fault as fault:
            raise InputError(f"{path}:{number}: field '{fault.field}' {fault.what}") from fault
        except ForeignFault as error:
            raise InputError(f"{path}:{number}: field 'line' is not JSON: {error}") from error
    return found


def write_annotations(path: str | Path, annotations: Mapping[str, Sequence[GoldEntry]]) -> None:
    """Write annotations, one line a text; fields that say nothing are left out."""
    lines = [
        json.dumps({"id": key, "relations": [_fields(e) for e in entries]}, ensure_ascii=False)
        for key, entries in annotations.items()
    ]
    Path(path).write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")


def _fields(entry: GoldEntry) -> dict[str, Any]:
    distance = entry.distance
    fields: dict[str, Any] = {
        "figure": entry.figure,
        "relation": entry.relation,
        "ground": entry.ground,
        "kind": entry.kind,
        "also": list(entry.also),
        "class": entry.ground_class,
        "status": None if entry.status in ("asserted", "denied") else entry.status,
        "negated": entry.negated,
        "group": entry.group,
        "either": None if entry.either is None else list(entry.either),
        "distance_m": None if distance is None else [distance.low_m, _finite(distance.high_m)],
        "optional": entry.optional,
        "part": None if entry.part is None else _part(entry.part),
    }
    silent = ("negated", "optional", "also")  # where they are false or empty; a group may be 0
    return {
        name: value
        for name, value in fields.items()
        if name == "ground" or (value if name in silent else value is not None)
    }


def _part(part: StreetPart) -> dict[str, Any]:
    bearing = part.bearing_rad
    fields = {
        "kind": part.kind,
        "bearing_deg": None if bearing is None else round(math.degrees(bearing), 6),
        "number": part.number,
    }
    return {name: value for name, value in fields.items() if value is not None}


def _finite(number: float) -> float | None:
    return number if number < float("inf") else None
