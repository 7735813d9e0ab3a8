"""A study that collects descriptions: configurations of objects, and what people said of them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
from msgspec import Meta, Struct

from sloop_ppl._foreign import ForeignFault, parse_json, read_text
from sloop_ppl._records import Fault, checked
from sloop_ppl.errors import InputError
from sloop_ppl.eval import read_descriptions
from sloop_ppl.maps import CityMap, load_map
from sloop_ppl.outputs import check_output, written_whole
from sloop_ppl.rng import child

__all__ = ["Configuration", "Study", "export_answers", "merged_answers", "prepare_study"]

_OBJECTS = ("GreenToyota", "RedHonda", "RedBike")
_APART_M = 20.0
_CLOSED = ("building", "water")
"""Kinds in whose cells no object is put."""


class Configuration(Struct, frozen=True):
    """Objects placed on a map.

    Parameters
    ----------
    id
        Name of the placement.
    map
        Name or path of the map.
    targets
        Object -> x and y, metres.
    """

    id: str
    map: str
    targets: dict[str, tuple[float, float]]


class Study(Struct, frozen=True):
    """What is described, and by how many people each.

    Parameters
    ----------
    people
        So many people describe each configuration at most, no one the same twice.
    configurations
        The placements.
    seed
        The seed they were drawn with.
    """

    people: Annotated[int, Meta(ge=1, le=10_000, description="a number of at least 1")]
    configurations: Annotated[
        list[Configuration], Meta(min_length=1, description="a list of configurations")
    ]
    seed: int = 0

    @classmethod
    def load(cls, path: str | Path) -> Study:
        """Read a study that `save` wrote.

        Raises
        ------
        InputError
            When it cannot be read, or a place is off its map.
        """
        try:
            study = checked(parse_json(read_text(path, "Study")), cls)
        except ForeignFault as error:
            raise InputError(f"Study '{path}' is not JSON: {error}") from error
        except Fault as fault:
            raise InputError(f"Study '{path}': field '{fault.field}' {fault.what}") from fault
        ids = [one.id for one in study.configurations]
        if len(set(ids)) < len(ids):
            raise InputError(f"Study '{path}' has two configurations of one id; ids are unique")
        for one in study.configurations:
            grid = load_map(one.map).grid
            for x, y in one.targets.values():
                grid.cell_at(x, y)
        return study

    def save(self, path: str | Path) -> None:
        """Write the study, ``.json``.

        Raises
        ------
        OutputError
            When the path cannot be written.
        """
        target = check_output(path, (".json",))
        with written_whole(target) as part:
            part.write_bytes(msgspec.json.format(msgspec.json.encode(self), indent=1) + b"\n")


def prepare_study(
    maps: Sequence[str], per_map: int = 10, people: int = 5, *, rng: np.random.Generator,
    seed: int = 0,
) -> Study:  # fmt: skip
    """Draw configurations: two objects each, in the open, at least 20 m apart.

    Parameters
    ----------
    maps
        Names or paths of maps.
    per_map
        Configurations of each map, > 0.
    people
        How many people describe each at most, > 0.
    rng
        Where they are drawn from, a stream for each map.
    seed
        What `rng` was seeded with, to be kept.

    Raises
    ------
    InputError
        When a number is not positive, or a map has no two places in the open so far apart.

    Notes
    -----
    Source: SLOOP sec. V, where two of the objects stood on a map at random.
    """
    if per_map < 1 or people < 1:
        raise InputError(
            f"There are {per_map} configurations for {people} people; expected at least 1 of each"
        )
    configurations = []
    for name in maps:
        city = load_map(name)
        own = child(rng, "study", city.name)
        for number in range(1, per_map + 1):
            targets = _placed(city, own)
            configurations.append(Configuration(f"{city.name}-{number:03d}", name, targets))
    return Study(people, configurations, seed)


def _placed(city: CityMap, rng: np.random.Generator) -> dict[str, tuple[float, float]]:
    grid = city.grid
    closed = np.zeros(grid.shape, dtype=bool)
    for landmark in city.of_kind(*_CLOSED):
        closed |= city.cells(landmark.id)
    inside = np.array([[grid.contains(x, y) for x in grid.x_m] for y in grid.y_m])
    free = np.argwhere(~closed & inside)
    names = rng.choice(len(_OBJECTS), size=2, replace=False)
    for _ in range(1000 if len(free) > 1 else 0):
        chosen = free[rng.choice(len(free), size=2, replace=False)]
        (x0, y0), (x1, y1) = (grid.centre_of(int(row), int(col)) for row, col in chosen)
        if np.hypot(x1 - x0, y1 - y0) >= _APART_M:
            return {_OBJECTS[names[0]]: (x0, y0), _OBJECTS[names[1]]: (x1, y1)}
    raise InputError(
        f"Map '{city.name}' has no two places in the open {_APART_M:g} m apart; choose a larger one"
    )


def merged_answers(records: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the descriptions of an answers file with their corrections, in order.

    Parameters
    ----------
    records
        Its lines, as the collection page saved them.
    """
    found: dict[str, dict[str, Any]] = {}
    for record in records:
        if "correction_of" in record:
            if record["correction_of"] in found:
                found[record["correction_of"]] |= {
                    "relations": record["relations"],
                    "checked": True,
                }
        elif "text" in record:
            found[record["id"]] = dict(record)
    return list(found.values())


def export_answers(
    answers: str | Path, out: str | Path, *, only_checked: bool = False, parsed: bool = False
) -> int:
    """Write what people said as a description file.

    Parameters
    ----------
    answers
        What the collection page saved.
    out
        The description file to write, ``.jsonl``.
    only_checked
        Leave out lines whose relations nobody has checked.
    parsed
        Keep the relations that were read in lines nobody has checked, as if they were gold;
        otherwise those lines have no relations.

    Returns
    -------
    int
        How many lines were written.

    Raises
    ------
    InputError
        When the answers cannot be read.
    OutputError
        When `out` cannot be written.
    """
    from sloop_ppl._journal import Journal

    target = check_output(out, (".jsonl",))
    read_text(answers, "Answers file")
    lines = []
    for record in merged_answers(Journal(Path(answers)).records()):
        is_checked = record.pop("checked", False)
        if only_checked and not is_checked:
            continue
        record.pop("consent", None)
        if not is_checked and not parsed:
            record.pop("relations", None)
        lines.append(json.dumps(record, ensure_ascii=False))
    if not lines:
        which = "description that was checked" if only_checked else "description"
        raise InputError(f"Answers file '{answers}' holds no {which}; expected one at least")
    with written_whole(target) as part:
        part.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
        try:
            read_descriptions([part])
        except InputError as error:
            raise InputError(str(error).replace(str(part), f"Answers file '{answers}'")) from None
    return len(lines)
