"""Episodes as JSON documents, to be saved, read and drawn again."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any

import msgspec
import numpy as np

from sloop_ppl._foreign import ForeignFault, parse_json, read_text
from sloop_ppl._records import Fault, checked
from sloop_ppl.errors import InputError, OutputError
from sloop_ppl.outputs import written_whole
from sloop_ppl.planning._episode_record import (
    EpisodeRecord,
    InfoRecord,
    QuestionRecord,
    check_counts,
)
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.episode import Episode, PlanInfo
from sloop_ppl.planning.pose import Pose
from sloop_ppl.planning.questions import AskedQuestion

__all__ = [
    "EPISODE_VERSION",
    "episode_from_document",
    "episode_to_document",
    "read_episode",
    "write_episode",
]

EPISODE_VERSION = 1
"""Version of the document's format."""


def episode_to_document(episode: Episode, **extra: Any) -> dict[str, Any]:
    """Return an episode as JSON values: what the command line prints, and what drawing it needs.

    Parameters
    ----------
    **extra
        Members to add, such as ``model`` and ``seed``.

    Notes
    -----
    Times are left out, so that the same seed gives the same bytes.
    """
    return {
        "format": "sloop_ppl episode",
        "version": EPISODE_VERSION,
        **episode.to_json(),
        **extra,
        **({"map_digest": episode.map_digest} if episode.map_digest else {}),
        "config": asdict(episode.config),
        "targets": list(episode.targets or episode.places),
        "shape": list(episode.views.shape[1:]),
        # Indices of the cells in view: a view has a dozen cells, a map thousands.
        "views": [np.flatnonzero(view).tolist() for view in episode.views],
        "info": [
            {
                "planner": info.planner,
                "sims": info.sims,
                "values": dict(info.values),
                "visits": dict(info.visits),
                "expected": {name: dict(seen) for name, seen in info.expected.items()},
                "notes": {k: list(v) if isinstance(v, tuple) else v for k, v in info.notes.items()},
            }
            for info in episode.info
        ],
        "beliefs": [
            {name: table.tolist() for name, table in tables.items()} for tables in episode.beliefs
        ],
    }


def episode_from_document(document: Any) -> Episode:
    """Return the episode that a document holds.

    Raises
    ------
    InputError
        When it is no such document, is of another version, or lacks a member.
    """
    if not isinstance(document, Mapping) or document.get("format") != "sloop_ppl episode":
        raise InputError(
            "This is no episode; expected a JSON object whose 'format' is 'sloop_ppl episode', "
            "as a search saves it"
        )
    version = document.get("version")
    if version != EPISODE_VERSION:
        raise InputError(
            f"The episode has version {version!r}; this program reads version {EPISODE_VERSION}: "
            "search again with this program, or read it with the one that wrote it"
        )
    try:
        return _episode(document)
    except (Fault, KeyError, TypeError, ValueError, AttributeError, LookupError) as error:
        reason = " ".join(str(error).split())[:300]
        raise InputError(f"The episode is damaged ({reason}); save it anew") from error


def _episode(document: Mapping[str, Any]) -> Episode:
    record = checked(document, EpisodeRecord)
    known = {f.name for f in fields(SearchConfig)}
    # Settings that a later version dropped are passed over.
    config = {k: v for k, v in record.config.items() if k in known}
    msgspec.convert(config, SearchConfig)  # the types; as converted, 3 would come back as 3.0
    check_counts(record)
    height, width = record.shape
    views = np.zeros((len(record.views), height * width), dtype=bool)
    for view, cells in zip(views, record.views, strict=True):
        view[cells] = True
    return Episode(
        map_name=record.map,
        planner=record.planner,
        config=SearchConfig(**config),
        places=MappingProxyType({k: _place(v) for k, v in record.places.items()}),
        poses=tuple(Pose(float(x), float(y), math.radians(h)) for x, y, h in record.poses),
        actions=tuple(record.actions),
        observations=tuple(
            MappingProxyType({k: _place(v) if isinstance(v, list) else v for k, v in seen.items()})
            for seen in record.observations
        ),
        rewards=tuple(float(r) for r in record.rewards),
        found_targets=tuple(record.found_targets),
        views=views.reshape(-1, height, width),
        info=tuple(map(_info, record.info)),
        beliefs=tuple(
            MappingProxyType({k: np.array(v, dtype=np.float64) for k, v in tables.items()})
            for tables in record.beliefs
        ),
        imagined=tuple(record.imagined),
        map_digest=record.map_digest,
        targets=tuple(record.targets),
        notes=tuple(record.notes),
        questions=tuple(map(_question, record.questions)),
    )


def _question(record: QuestionRecord) -> AskedQuestion:
    return AskedQuestion(
        step=record.step,
        text=record.text,
        answer=record.answer,
        target=record.target,
        cost=float(record.cost),
        steps=record.steps,
        bits=float(record.bits),
        realised=record.realised_bits,
        gain=record.gain,
        note=record.note,
    )


def _place(value: Any) -> tuple[float, float]:
    x, y = value
    return float(x), float(y)


def _info(record: InfoRecord) -> PlanInfo:
    return PlanInfo(
        planner=record.planner,
        sims=record.sims,
        values=MappingProxyType(record.values),
        visits=MappingProxyType(record.visits),
        expected=MappingProxyType(record.expected),
        notes=MappingProxyType(
            {k: tuple(v) if isinstance(v, list) else v for k, v in record.notes.items()}
        ),
    )


def write_episode(episode: Episode, path: str | Path, **extra: Any) -> None:
    """Write an episode to a JSON file, whole or not at all.

    Parameters
    ----------
    episode
        The episode.
    path
        Where to write it.
    **extra
        Members to add; see `episode_to_document`.

    Raises
    ------
    OutputError
        When the file cannot be written.
    """
    document = episode_to_document(episode, **extra)
    text = json.dumps(document, ensure_ascii=False, allow_nan=False)
    try:
        with written_whole(path) as whole:
            whole.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise OutputError(f"Cannot write {path}: {error.strerror}; choose another path") from error


def read_episode(path: str | Path) -> Episode:
    """Read an episode from a JSON file.

    Raises
    ------
    InputError
        When there is no such file, or it does not hold an episode of this version.
    """
    text = read_text(path, "Episode", hint="; give an episode's path")
    try:
        document = parse_json(text)
    except ForeignFault as error:
        raise InputError(f"{path} is not JSON: {error}; give an episode's path") from error
    return episode_from_document(document)
