"""Search in a process of its own and send each step as JSON when it is done."""

from __future__ import annotations

import json
import math
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any

import numpy as np

from sloop_ppl.errors import SloopError
from sloop_ppl.web._codec import packed_bits, packed_floats

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from sloop_ppl.inference import Posterior
    from sloop_ppl.planning import Episode, Step
    from sloop_ppl.planning.pose import Pose
    from sloop_ppl.planning.space import SearchSpace
    from sloop_ppl.web._state import SearchAsked

__all__ = ["belief_tables", "episode_payload", "search_in_worker", "step_payload"]

_MOVES = ("forward", "left", "right")


def search_in_worker(posterior: Posterior, asked: SearchAsked, connection: Connection) -> None:
    """Send ``start``, each ``step``, and ``end`` or ``error``, and end."""
    from sloop_ppl.bridge.searching import imagined_places, search
    from sloop_ppl.planning import SearchConfig
    from sloop_ppl.planning.space import SearchSpace

    def send(kind: str, payload: dict[str, Any]) -> None:
        connection.send_bytes(json.dumps({"kind": kind, **payload}, allow_nan=False).encode())

    try:
        rng = np.random.default_rng(asked.seed)
        places: dict[str, tuple[float, float]] = {
            t: p for t, p in asked.places.items() if t in posterior.targets
        }
        # A place once drawn stays when something is said later on: the page sends it back.
        imagined = imagined_places(posterior, places, rng=rng)
        config = SearchConfig(max_steps=asked.steps, sensor_range_cells=asked.range_cells)
        space = SearchSpace.of_city(posterior.city, posterior.targets, config)
        start = _start(posterior, asked, space, rng)
        send("start", {"places": {**places, **imagined}, "imagined": list(imagined),
                       "pose": [*start]})  # fmt: skip
        episode = search(
            posterior,
            posterior.city,
            {**places, **imagined},
            planner=asked.planner,
            sims=asked.sims,
            sensor_range_cells=asked.range_cells,
            start=(start.x_m, start.y_m, start.heading_deg),
            rng=rng,
            config=config,
            on_step=lambda step: send("step", step_payload(step, space)),
            said=dict(asked.utterances),
        )
        send("end", episode_payload(episode, asked.seed))
    except SloopError as error:
        send("error", {"error": str(error)})
    finally:
        connection.close()


def step_payload(step: Step, space: SearchSpace) -> dict[str, Any]:
    """Return what is shown of one step."""
    return {
        "index": step.index,
        "action": step.action,
        "pose": [step.pose.x_m, step.pose.y_m, step.pose.heading_rad],
        "reward": step.reward,
        "seen": {t: list(at) for t, at in step.observation.items() if isinstance(at, tuple)},
        "found": list(step.found_targets),
        "view": packed_bits(step.view),
        "values": {name: round(v, 2) for name, v in step.info.values.items() if math.isfinite(v)},
        "plan": _planned(step, space),
        "beliefs": belief_tables(step.beliefs),
    }


def episode_payload(episode: Episode, seed: int) -> dict[str, Any]:
    """Return how a search ended, with the episode as ``sloop search --json`` tells it."""
    return {
        "found": episode.found,
        "start_view": packed_bits(episode.views[0]),
        "episode": {"map": episode.map_name, "planner": episode.planner, "seed": seed,
                    **episode.to_json()},
    }  # fmt: skip


def belief_tables(tables: Mapping[str, NDArray[np.float64]]) -> dict[str, Any]:
    """Return the belief over each target's cell, with the smallest set that holds nine tenths."""
    from sloop_ppl.inference import hpd_cells

    return {
        name: {**packed_floats(table), "hpd90": packed_bits(hpd_cells(table, 0.9))}
        for name, table in tables.items()
    }


def _planned(step: Step, space: SearchSpace) -> list[list[float]]:
    """Return the places that the planner means to visit next, where it says so."""
    pose, places = space.snap(step.pose), []
    # The first of the path is the move that this step made.
    for name in step.info.notes.get("path", ())[1:]:
        if name not in _MOVES:
            break
        pose, _ = space.moved(_MOVES.index(name), pose)
        after = space.pose_at(pose)
        places.append([after.x_m, after.y_m])
    return places


def _start(
    posterior: Posterior, asked: SearchAsked, space: SearchSpace, rng: np.random.Generator
) -> Pose:
    """Return where the search starts, as it would draw it."""
    from sloop_ppl.planning.environment import start_pose

    cells = None if posterior.area is None else posterior.area.cells
    return start_pose(asked.start, space, rng, cells)
