"""The map, and what counts on it, as arrays for the search over paths.

Legend: P poses; K cells of the largest fan; R range of the sensor, rounded down; B blocks of cells.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning.compile import inlined
from sloop_ppl.planning.native_data import search_data
from sloop_ppl.planning.pose import HEADINGS
from sloop_ppl.planning.pose_tables import next_poses
from sloop_ppl.planning.space import SearchSpace

__all__ = ["Ground", "Worth", "after_move", "cost", "ground_of", "mass_in_view", "reach_of"]


class Ground(NamedTuple):
    """Where moves lead and what is seen; the map has a border of R cells so that views fit.

    Attributes
    ----------
    ahead : pose after a step forward, shape (P,).
    home : index of each pose's cell in the bordered map, shape (P,).
    fans : offsets of the fan's cells in the bordered map by heading, shape (8, K).
    sizes : how many they are, shape (8,).
    hidden : True where a place of the fan is hidden from a pose, shape (P, K) or (0, 0).
    collides : True where a step forward hits a no-fly building, shape (P,) or (0,).
    n_cols : columns of the map.
    turn : eighths of a turn that a turn goes.
    """

    ahead: NDArray[np.int32]
    home: NDArray[np.int32]
    fans: NDArray[np.int32]
    sizes: NDArray[np.int32]
    hidden: NDArray[np.bool_]
    collides: NDArray[np.bool_]
    n_cols: int
    turn: int


class Worth(NamedTuple):
    """What counts: belief and rewards.

    Attributes
    ----------
    mass : expected number of targets by cell of the bordered map.
    total : expected number of targets.
    hit : probability of detecting what is in view.
    move, collision, right : rewards.
    discount : discount factor per step.
    """

    mass: NDArray[np.float64]
    total: float
    hit: float
    move: float
    collision: float
    right: float
    discount: float


@inlined
def mass_in_view(ground: Ground, worth: Worth, factor: NDArray[np.float64], pose: int) -> float:
    """Return the mass in view from a pose."""
    total, home, heading = 0.0, ground.home[pose], pose & 7
    for k in range(ground.sizes[heading]):
        if len(ground.hidden) > 0 and ground.hidden[pose, k]:
            continue
        cell = home + ground.fans[heading, k]
        total += worth.mass[cell] * factor[cell]
    return total


@inlined
def after_move(ground: Ground, pose: int, move: int) -> int:
    """Return the pose after a move."""
    if move == 0:
        return int(ground.ahead[pose])
    return pose - (pose & 7) + ((pose + (ground.turn if move == 1 else -ground.turn)) & 7)


@inlined
def cost(ground: Ground, worth: Worth, pose: int, move: int, left: float) -> float:
    """Return the expected reward of a move; it counts while something is left."""
    reward = worth.move
    if move == 0 and len(ground.collides) > 0 and ground.collides[pose]:
        reward = worth.collision
    return reward * min(left, 1.0)


def reach_of(space: SearchSpace) -> int:
    """Return the width of the border: how far the sensor sees, in whole cells."""
    return math.floor(space.config.sensor_range_cells + 1e-9)


def ground_of(space: SearchSpace) -> Ground:
    """Return the map as arrays, with a border as wide as the sensor sees."""
    data, reach = search_data(space), reach_of(space)
    width = space.n_cols + 2 * reach
    row, col = np.divmod(
        np.arange(space.n_cells * HEADINGS, dtype=np.int32) // HEADINGS, space.n_cols
    )
    return Ground(
        ahead=next_poses(space)[0].copy(),
        home=((row + reach) * width + col + reach).astype(np.int32),
        fans=(data.fans[:, :, 0] * width + data.fans[:, :, 1]).astype(np.int32),
        sizes=data.fan_sizes.astype(np.int32),
        hidden=data.hidden,
        collides=data.blocked,
        n_cols=space.n_cols,
        turn=data.turn,
    )
