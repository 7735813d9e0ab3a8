"""What a target is worth to a robot that knows where it is: the clairvoyant (hindsight) bound.

Legend: H, W grid; P poses; A = 3 moves.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning._search_tables import next_poses
from sloop_ppl.planning.obstacles import Offsets
from sloop_ppl.planning.pose import HEADINGS
from sloop_ppl.planning.space import SearchSpace

__all__ = [
    "Origins",
    "Rewards",
    "are_counted",
    "clairvoyant_bounds",
    "estimate_numbers",
    "known_value",
    "origins_of",
    "rewards_of",
]

STRETCH = 1.6
"""How much longer than the shortest way the way is taken to be: one who does not know strays.

From 1.3 to 2 it makes no difference to what the plans are worth.
"""

FLOOD_POSES = 2_000_000
"""Poses up to which shortest ways are counted; beyond they are estimated."""


class Rewards(NamedTuple):
    """Rewards of a move and of a right find, and the discount factor per step."""

    move: float
    right: float
    discount: float


class Origins(NamedTuple):
    """The moves backwards: from where each pose is reached.

    Attributes
    ----------
    starts
        Where the origins of each pose begin, and where they end at last, shape (P + 1,).
    poses
        The origins of all poses, one pose after another.
    """

    starts: NDArray[np.int64]
    poses: NDArray[np.int32]


def rewards_of(space: SearchSpace) -> Rewards:
    """Return the rewards of a search."""
    config = space.config
    return Rewards(config.move_reward, config.right_find_reward, config.discount)


def clairvoyant_bounds(space: SearchSpace) -> NDArray[np.float32]:
    """Return the discounted return of driving to a known target and finding it, by offset.

    Obstacles are left out.

    Returns
    -------
    numpy.ndarray
        By heading, rows north (from 1 - H) and columns east (from 1 - W), shape
        (8, 2 H - 1, 2 W - 1).
    """
    moves = np.ascontiguousarray(space.move_table.offsets[:, :, 0]).tobytes()
    return _bounds((space.n_rows, space.n_cols), moves, space.fans, rewards_of(space))


@lru_cache(maxsize=2)
def _bounds(
    shape: tuple[int, int], moves: bytes, fans: tuple[Offsets, ...], rewards: Rewards
) -> NDArray[np.float32]:
    # Bytes, because an array cannot be a key of the cache.
    offsets = np.frombuffer(moves, dtype=np.int64).reshape(3, HEADINGS, 3)
    wide = 2 * shape[0] - 1, 2 * shape[1] - 1
    counted = count_moves(wide, offsets, fans) if _are_few(shape) else None
    bounds = np.empty((HEADINGS, *wide), dtype=np.float32)
    for heading in range(HEADINGS):  # one by one, for the sake of memory
        if counted is None:
            least = estimate_moves(wide, offsets, fans, heading)
        else:
            least = counted[heading].astype(np.float64)
        bounds[heading] = known_value(rewards, least)
    bounds.flags.writeable = False
    return bounds


def _are_few(shape: tuple[int, int]) -> bool:
    return (2 * shape[0] - 1) * (2 * shape[1] - 1) * HEADINGS <= FLOOD_POSES


def are_counted(space: SearchSpace) -> bool:
    """Tell whether shortest ways are counted on a map; on larger ones they are estimated."""
    return _are_few(space.shape)


def estimate_numbers(space: SearchSpace) -> NDArray[np.float64]:
    """Return what `estimate_moves` and `known_value` go by, for one offset at a time.

    Returns
    -------
    numpy.ndarray
        How far the sensor sees and the length of a step, cells; the reward of a move and of a
        right find; the discount; and the angle of a turn by heading, radians; shape (13,).
    """
    reach, step = _reach_and_step(space.move_table.offsets[:, :, 0], space.fans)
    turns = [_turn_rad(space.move_table.offsets[:, :, 0], h) for h in range(HEADINGS)]
    return np.array([reach, step, *rewards_of(space), *turns])


def known_value(rewards: Rewards, moves: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the discounted return of so many moves, stretched, and a find after them.

    With n stretched moves it is ``r * (1 - g ** n) / (1 - g) + g ** n * R``.
    """
    steps = STRETCH * moves
    weight = rewards.discount**steps
    # With g = 1 the geometric sum is n itself.
    spent = (1 - weight) / (1 - rewards.discount) if rewards.discount < 1 else steps
    value: NDArray[np.float64] = rewards.move * spent + weight * rewards.right
    return value


def origins_of(nexts: NDArray[np.int32]) -> Origins:
    """Return the moves backwards, given the pose after each move, shape (A, P)."""
    flat, n_poses = nexts.ravel(), nexts.shape[1]
    counts = np.bincount(flat, minlength=n_poses)
    # Compressed rows (CSR): sorted by where a move leads; modulo P leaves where it came from.
    poses = (np.argsort(flat, kind="stable") % n_poses).astype(np.int32)
    return Origins(np.concatenate([[0], np.cumsum(counts)]), poses)


def count_moves(
    shape: tuple[int, int], offsets: NDArray[np.int64], fans: tuple[Offsets, ...]
) -> NDArray[np.int32]:
    """Return the fewest moves until an offset is in view, by breadth-first search.

    It goes backwards from the poses that see the middle cell of a grid.

    Parameters
    ----------
    shape
        Odd numbers of offsets, rows and columns.
    offsets
        Rows, columns and eighths of a turn of each move by heading, shape (A, 8, 3).

    Returns
    -------
    numpy.ndarray
        By heading and offset, shape (8, rows, columns).
    """
    rows, cols = shape
    starts, origins = origins_of(next_poses(shape, offsets))
    middle_row, middle_col = rows // 2, cols // 2
    frontier = np.array(
        [
            ((middle_row - dr) * cols + middle_col - dc) * HEADINGS + heading
            for heading, fan in enumerate(fans)
            for dr, dc in fan
            if 0 <= middle_row - dr < rows and 0 <= middle_col - dc < cols
        ],
        dtype=np.int64,
    )
    n_poses = rows * cols * HEADINGS
    # rows + cols stands for what is never brought into view.
    steps = np.full(n_poses, rows + cols, dtype=np.int32)
    left = np.ones(n_poses, dtype=bool)
    depth = 0
    while frontier.size:
        steps[frontier], left[frontier] = depth, False
        depth += 1
        # All origins of the frontier: one range of `origins` for each of its poses.
        begins, counts = starts[frontier], starts[frontier + 1] - starts[frontier]
        shift = np.repeat(begins - np.cumsum(counts) + counts, counts)
        around = np.unique(origins[shift + np.arange(len(shift))]).astype(np.int64)
        frontier = around[left[around]]
    # From a pose at (r, c) the middle is at the offset (middle - r, middle - c).
    return steps.reshape(rows, cols, HEADINGS)[::-1, ::-1].transpose(2, 0, 1)


def estimate_moves(
    shape: tuple[int, int], offsets: NDArray[np.int64], fans: tuple[Offsets, ...], heading: int
) -> NDArray[np.float64]:
    """Return about how many moves it takes until an offset is in view: turn, then go.

    Parameters and what is returned are those of `count_moves`, for one heading.
    """
    row, col = np.mgrid[: shape[0], : shape[1]]
    row, col = row - shape[0] // 2, col - shape[1] // 2
    reach, step = _reach_and_step(offsets, fans)
    # Straight ahead in steps of the length of a move east, until the target is within reach.
    far = np.maximum(np.hypot(row, col) - reach, 0.0) / step
    ahead = heading * 2 * np.pi / HEADINGS
    # The angle off the heading, wrapped to [-pi, pi), in turns.
    off = np.abs((np.arctan2(row, col) - ahead + np.pi) % (2 * np.pi) - np.pi)
    steps: NDArray[np.float64] = far + np.round(off / _turn_rad(offsets, heading))
    return steps


def _reach_and_step(offsets: NDArray[np.int64], fans: tuple[Offsets, ...]) -> tuple[float, float]:
    """Return how far the sensor sees, and the length of a move east, cells."""
    reach = max((float(np.hypot(*cell)) for fan in fans for cell in fan), default=0.0)
    return reach, max(float(np.hypot(*offsets[0, 0, :2])), 1.0)


def _turn_rad(offsets: NDArray[np.int64], heading: int) -> float:
    return max(int(offsets[1, heading, 2]), 1) * 2 * np.pi / HEADINGS
