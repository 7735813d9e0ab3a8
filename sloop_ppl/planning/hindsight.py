"""What a target at an offset would be worth to a robot that knew where it is."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.pose import HEADINGS
from sloop_ppl.planning.pose_tables import next_poses
from sloop_ppl.planning.space import SearchSpace

__all__ = ["hindsight_bounds", "known_worth"]

STRETCH = 1.6
"""How much longer than the shortest way the way is taken to be: one who does not know strays.

From 1.3 to 2 it makes no difference to what the plans are worth.
"""

FLOOD_POSES = 2_000_000
"""Poses up to which shortest ways are counted; beyond they are estimated."""


def hindsight_bounds(space: SearchSpace) -> NDArray[np.float32]:
    """Return the discounted return of driving to a known target and finding it, by offset.

    Parameters
    ----------
    space : the search space; its obstacles are left out.

    Returns
    -------
    numpy.ndarray
        By heading, rows north (from 1 - H) and columns east (from 1 - W), shape
        (8, 2 H - 1, 2 W - 1).
    """
    plain = replace(space.config, occlusion=False, no_fly=False)
    return _bounds((space.n_rows, space.n_cols), plain)


@lru_cache(maxsize=2)
def _bounds(shape: tuple[int, int], config: SearchConfig) -> NDArray[np.float32]:
    space = SearchSpace(shape, ("target",), config)
    wide = 2 * space.n_rows - 1, 2 * space.n_cols - 1
    few = wide[0] * wide[1] * HEADINGS <= FLOOD_POSES
    counted = _counted(space, wide) if few else None
    bounds = np.empty((HEADINGS, *wide), dtype=np.float32)
    for heading in range(HEADINGS):  # one by one, for the sake of memory
        least = _estimated(space, wide, heading) if counted is None else counted[heading]
        bounds[heading] = known_worth(config, least)
    bounds.flags.writeable = False
    return bounds


def known_worth(config: SearchConfig, least: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the discounted return of so many moves, stretched, and a find after them."""
    steps = STRETCH * least
    weight = config.discount**steps
    spent = (1 - weight) / (1 - config.discount) if config.discount < 1 else steps
    worth: NDArray[np.float64] = config.move_reward * spent + weight * config.right_find_reward
    return worth


def _counted(space: SearchSpace, shape: tuple[int, int]) -> NDArray[np.float64]:
    """Return the fewest moves until an offset is in view, by breadth-first search."""
    rows, cols = shape
    wide = SearchSpace(shape, ("target",), space.config)
    nexts = next_poses(wide)
    n_poses = rows * cols * HEADINGS
    row, col = space.n_rows - 1, space.n_cols - 1
    frontier = np.array(
        [
            wide.encode(row - dr, col - dc, heading)
            for heading, fan in enumerate(wide.fans)
            for dr, dc in fan
            if 0 <= row - dr < rows and 0 <= col - dc < cols
        ]
    )
    before = np.full(n_poses, -1, dtype=np.int32)
    moved = nexts[0] != np.arange(n_poses)
    before[nexts[0, moved]] = np.flatnonzero(moved)
    steps = np.full(n_poses, rows + cols, dtype=np.int32)
    left = np.ones(n_poses, dtype=bool)
    depth = 0
    while frontier.size:
        steps[frontier], left[frontier] = depth, False
        depth += 1
        around = np.concatenate([before[frontier], nexts[1, frontier], nexts[2, frontier]])
        around = np.unique(around[around >= 0])
        frontier = around[left[around]]
    by_pose = steps.reshape(rows, cols, HEADINGS).astype(np.float64)
    return by_pose[::-1, ::-1].transpose(2, 0, 1)


def _estimated(space: SearchSpace, shape: tuple[int, int], heading: int) -> NDArray[np.float64]:
    """Return about how many moves it takes until an offset is in view: turn, then go."""
    config = space.config
    row, col = np.mgrid[: shape[0], : shape[1]]
    row, col = row - (space.n_rows - 1), col - (space.n_cols - 1)
    far = np.maximum(np.hypot(row, col) - config.sensor_range_cells, 0.0) / config.step_cells
    ahead = heading * 2 * np.pi / HEADINGS
    off = np.abs((np.arctan2(row, col) - ahead + np.pi) % (2 * np.pi) - np.pi)
    steps: NDArray[np.float64] = far + np.round(np.degrees(off) / config.turn_deg)
    return steps
