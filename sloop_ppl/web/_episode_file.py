"""Read an episode that someone dropped in, as ``sloop fly`` or ``sloop search`` wrote it.

Shape legend: H, W grid.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
from msgspec import Meta, Struct

from sloop_ppl._foreign import ForeignFault, parse_json, read_text
from sloop_ppl._records import Fault, checked
from sloop_ppl.errors import InputError
from sloop_ppl.web._codec import packed_bits
from sloop_ppl.web._limits import MOST_CELLS, MOST_PLAYED_STEPS, MOST_TEXT
from sloop_ppl.web._search_worker import belief_tables
from sloop_ppl.web._state import Metres, Name, Place

__all__ = ["read_episode_file"]

_WANTED = "expected what `sloop fly` or `sloop search` writes with --json or --out"

Number = Annotated[float, Meta(ge=-1e9, le=1e9, description="a finite number")]
Pose = Annotated[
    tuple[Metres, Metres, Number], Meta(description="x and y in metres and a heading in degrees")
]
Places = Annotated[dict[Name, Place], Meta(max_length=50, description="an object of places")]
Names = Annotated[list[Name], Meta(max_length=50, description="a list of names")]


class _Detection(Struct):
    target: Name
    place: Place


class _Collision(Struct, rename={"obstacle": "with"}):
    step: int
    obstacle: Name = ""


class _Info(Struct):
    values: dict[Name, Number] = {}


class _EpisodeFile(Struct):
    """What is played of an episode; other members are passed over."""

    map: Name
    places: Places
    poses: Annotated[
        list[Pose], Meta(min_length=1, max_length=MOST_PLAYED_STEPS + 1, description="poses")
    ]
    actions: list[Name]
    rewards: list[Number]
    observations: list[dict[Name, Any]]
    found: bool
    found_targets: Names
    text: Annotated[str, Meta(max_length=MOST_TEXT, description="a text")] = ""
    model: Name = ""
    map_digest: Name = ""
    detections: list[list[_Detection]] = []
    collisions: list[_Collision] = []
    shape: tuple[int, int] | None = None
    views: list[list[int]] = []
    info: list[_Info] = []
    beliefs: list[dict[Name, list[list[float]]]] = []
    altitude_m: Number | None = None
    wind_m_s: Number | None = None
    detector: Name = ""
    time_s: Number | None = None


def read_episode_file(path: Path, name: str) -> dict[str, Any]:
    """Return an episode as the page plays it, with the map, words and model that it names.

    Raises
    ------
    InputError
        When the file is no episode, or one whose parts do not fit each other.
    """
    what = f"Episode '{name}'"
    try:
        document = parse_json(read_text(path, "Episode"))
    except ForeignFault as error:
        raise InputError(f"{what} is not JSON ({error}); {_WANTED}") from error
    try:
        record = checked(document, _EpisodeFile)
    except Fault as fault:
        raise InputError(f"{what}: its field '{fault.field}' {fault.what}; {_WANTED}") from fault
    steps = len(record.actions)
    for part, count in {"poses": steps + 1, "rewards": steps, "observations": steps}.items():
        if len(getattr(record, part)) != count:
            raise InputError(
                f"{what} has {steps} actions and {len(getattr(record, part))} {part}; expected "
                f"{count}: save it anew"
            )
    try:
        views, beliefs = _views(record), _beliefs(record)
    except (ValueError, IndexError) as error:
        raise InputError(f"{what} is damaged ({error}); save it anew") from error
    return {
        "map": record.map,
        "map_digest": record.map_digest,
        "shape": record.shape,
        "text": record.text,
        "model": record.model,
        "note": _note(record, has_beliefs=bool(beliefs)),
        "search": {
            "places": record.places,
            "pose": _pose(record.poses[0]),
            "beliefs": beliefs[0] if beliefs else None,
            "steps": _steps(record, views, beliefs),
            "found": record.found,
            "start_view": views[0] if views else None,
            "episode": document,
        },
    }


def _pose(pose: Sequence[float]) -> list[float]:
    x, y, heading_deg = pose
    return [x, y, math.radians(heading_deg)]


def _steps(
    record: _EpisodeFile, views: list[str], beliefs: list[dict[str, Any]]
) -> list[dict[str, Any]]:
    steps: list[dict[str, Any]] = []
    hits = {one.step: one.obstacle or "something" for one in record.collisions}
    seen_so_far: list[str] = []
    found: list[str] = []
    for i, action in enumerate(record.actions):
        seen = _seen(record, i)
        seen_so_far += [t for t in seen if t not in seen_so_far]
        if action.startswith("find") and record.rewards[i] > 0:
            # A find marks what is in view, which was seen before; the end tells what is left.
            found += [t for t in seen_so_far if t in record.found_targets and t not in found]
        if i == len(record.actions) - 1:
            found = list(record.found_targets)
        steps.append(
            {
                "index": i,
                "action": action,
                "pose": _pose(record.poses[i + 1]),
                "reward": record.rewards[i],
                "seen": seen,
                "found": list(found),
                "collision": hits.get(i, ""),
                "view": views[i + 1] if views else None,
                "values": record.info[i].values if i < len(record.info) else {},
                "plan": [],
                "beliefs": beliefs[i + 1] if beliefs else {},
            }
        )
    return steps


def _seen(record: _EpisodeFile, step: int) -> dict[str, Place]:
    """Return where targets were seen: by the camera, whose word is the finer, or on the grid."""
    seen: dict[str, Place] = {}
    for target, at in record.observations[step].items():
        with contextlib.suppress(msgspec.ValidationError):  # not seen, or no place
            seen[target] = msgspec.convert(at, Place)
    if step < len(record.detections):
        seen |= {one.target: one.place for one in record.detections[step]}
    return seen


def _views(record: _EpisodeFile) -> list[str]:
    """Return the cells in view at each pose as bits; none where they were not kept."""
    if not record.views:
        return []
    height, width = _shape(record)
    if len(record.views) != len(record.poses):
        raise ValueError(f"{len(record.poses)} poses and {len(record.views)} views")
    packed = []
    for cells in record.views:
        view = np.zeros(height * width, dtype=bool)
        if min(cells, default=0) < 0:
            raise ValueError(f"cell {min(cells)} is in view")
        view[cells] = True
        packed.append(packed_bits(view))
    return packed


def _beliefs(record: _EpisodeFile) -> list[dict[str, Any]]:
    """Return the belief at each pose; none where not all were kept."""
    if len(record.beliefs) != len(record.poses):
        return []
    found = []
    for tables in record.beliefs:
        arrays = {name: np.array(rows, dtype=np.float64) for name, rows in tables.items()}
        for name, table in arrays.items():
            if table.shape != _shape(record) or not (table >= 0).all() or not table.sum() > 0:
                raise ValueError(f"the belief of {name} is none over the cells of the map")
        found.append(belief_tables(arrays))
    return found


def _shape(record: _EpisodeFile) -> tuple[int, int]:
    height, width = record.shape or (0, 0)
    if height < 1 or width < 1 or height * width > MOST_CELLS:
        raise ValueError(f"a map of {height} x {width} cells")
    return height, width


def _note(record: _EpisodeFile, *, has_beliefs: bool) -> str:
    """Return what is said of the episode beside the map."""
    parts = []
    if record.altitude_m is not None:
        wind = "" if record.wind_m_s is None else f" in wind of {record.wind_m_s:g} m/s"
        parts.append(f"Flown {record.altitude_m:g} m high{wind}")
        if record.detector:
            parts[0] += f", seen by {record.detector}"
        if record.time_s is not None:
            parts[0] += f"; {record.time_s:.0f} s in the air"
    hits = len(record.collisions)
    if hits:
        parts.append(f"{hits} collision{'s' if hits > 1 else ''}")
    if not has_beliefs:
        parts.append("The file keeps no beliefs: the colours stay those of the sentence")
    return "".join(f"{part}. " for part in parts).strip()
