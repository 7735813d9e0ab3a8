"""The rules of the search as arrays, for machine code.

Legend: K cells of the largest fan; R range of the sensor, rounded down; P poses.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning.pose import HEADINGS
from sloop_ppl.planning.space import SearchSpace

__all__ = ["SearchData", "search_data"]


class SearchData(NamedTuple):
    """What the functions know about the search.

    Attributes
    ----------
    n_rows, n_cols, n_targets, turn, max_finds, n_finds, reach : whole numbers; `reach` is R.
    steps : rows north and columns east of a step by heading, shape (8, 2).
    fan : one plus the place of an offset in its fan, else 0, shape (8, 2 R + 1, 2 R + 1).
    fans : offsets of each fan, shape (8, K, 2), and how many there are, `fan_sizes` (8,).
    hidden : True where a place of the fan is hidden from a pose, shape (P, K) or (0, 0).
    blocked : True where a step forward hits a no-fly building, shape (P,) or (0,).
    aim : directions that a target must be anticlockwise of for a left turn to turn towards it, and
        clockwise of for a right turn, by heading, as x and y, shape (8, 2, 2).
    move, right, wrong, collision : rewards.
    hit, false, sigma : rates and noise of the sensor.
    published : 1 for the published rollout, 0 for the random one.
    """

    n_rows: int
    n_cols: int
    n_targets: int
    turn: int
    max_finds: int
    n_finds: int
    reach: int
    steps: NDArray[np.int64]
    fan: NDArray[np.uint8]
    fans: NDArray[np.int64]
    fan_sizes: NDArray[np.int64]
    hidden: NDArray[np.bool_]
    blocked: NDArray[np.bool_]
    aim: NDArray[np.float64]
    move: float
    right: float
    wrong: float
    collision: float
    hit: float
    false: float
    sigma: float
    published: int


def search_data(space: SearchSpace) -> SearchData:
    """Return a search space as arrays."""
    config = space.config
    reach = math.floor(config.sensor_range_cells + 1e-9)
    most = max(len(fan) for fan in space.fans)
    fan = np.zeros((HEADINGS, 2 * reach + 1, 2 * reach + 1), dtype=np.uint8)
    fan_type = np.uint8 if most < 255 else np.int32
    fan = fan.astype(fan_type)
    fans = np.zeros((HEADINGS, most, 2), dtype=np.int64)
    for heading, offsets in enumerate(space.fans):
        for place, (dr, dc) in enumerate(offsets):
            fan[heading, dr + reach, dc + reach] = place + 1
            fans[heading, place] = dr, dc
    turn = config.turn_deg // 45
    ahead = np.arange(HEADINGS) * 2 * np.pi / HEADINGS
    half = turn * np.pi / HEADINGS
    aim = np.stack(
        [np.stack([np.cos(a), np.sin(a)], axis=-1) for a in (ahead + half, ahead - half)], axis=1
    )
    return SearchData(
        n_rows=space.n_rows,
        n_cols=space.n_cols,
        n_targets=len(space.target_ids),
        turn=turn,
        max_finds=space.max_finds,
        n_finds=len(space.finds),
        reach=reach,
        steps=np.array(space.steps, dtype=np.int64),
        fan=fan,
        fans=fans,
        fan_sizes=np.array([len(f) for f in space.fans], dtype=np.int64),
        hidden=_hidden(space, most),
        blocked=_blocked(space),
        aim=aim,
        move=float(config.move_reward),
        right=float(config.right_find_reward),
        wrong=float(config.wrong_find_reward),
        collision=float(config.collision_reward),
        hit=float(config.true_positive_rate),
        false=float(config.false_positive_rate),
        sigma=float(config.position_noise_cells),
        published=int(config.rollout != "random"),
    )


def _hidden(space: SearchSpace, most: int) -> NDArray[np.bool_]:
    if not (space.config.occlusion and space.tall.any()):
        return np.zeros((0, 0), dtype=bool)
    hidden = np.zeros((space.n_cells * HEADINGS, most), dtype=bool)
    for pose in range(len(hidden)):
        row, col, heading = space.decode(pose)
        view = space.view(pose)
        for place, (dr, dc) in enumerate(space.fans[heading]):
            hidden[pose, place] = (row + dr) * space.n_cols + col + dc not in view
    return hidden


def _blocked(space: SearchSpace) -> NDArray[np.bool_]:
    if not space.no_fly:
        return np.zeros(0, dtype=bool)
    return np.array([space.collides(pose) for pose in range(space.n_cells * HEADINGS)])
