"""The way to the pose that promises most belief in view, as the planner ``greedy`` drives."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning.compile import jit
from sloop_ppl.planning.ground import Ground, Worth, after_move, mass_in_view

__all__ = ["Ways", "drive", "no_ways"]


class Ways(NamedTuple):
    """Room for a breadth-first search over P poses: how far, from where, and in which order."""

    steps: NDArray[np.int32]
    origin: NDArray[np.int32]
    queue: NDArray[np.int32]


def no_ways(n_poses: int) -> Ways:
    """Return room for `drive`."""
    return Ways(*(np.empty(n_poses, dtype=np.int32) for _ in range(3)))


@jit
def drive(
    ground: Ground,
    worth: Worth,
    factor: NDArray[np.float64],
    start: int,
    ways: Ways,
    moves: NDArray[np.int32],
) -> int:
    """Fill in the moves to the pose with the most discounted mass in view; return how many.

    Parameters
    ----------
    ground, worth : the map, and what counts.
    factor : all ones, bordered map.
    start : the robot's pose.
    ways : room.
    moves : room for the moves; a longer way is cut.
    """
    ways.steps[:] = -1
    ways.steps[start], ways.queue[0] = 0, start
    head, tail, goal, best = 0, 1, start, 0.0
    discounted, steps = 1.0, 0
    while head < tail:
        pose = ways.queue[head]
        head += 1
        if ways.steps[pose] > steps:
            steps += 1
            discounted *= worth.discount
            if discounted * worth.total <= best:
                break
        if pose != start:
            score = discounted * mass_in_view(ground, worth, factor, pose)
            if score > best * (1 + 1e-9):
                goal, best = pose, score
        for move in range(3):
            after = after_move(ground, pose, move)
            if ways.steps[after] < 0:
                ways.steps[after], ways.origin[after] = ways.steps[pose] + 1, 4 * pose + move
                ways.queue[tail] = after
                tail += 1
    length = ways.steps[goal]
    pose = goal
    for i in range(length - 1, -1, -1):
        if i < len(moves):
            moves[i] = ways.origin[pose] % 4
        pose = ways.origin[pose] // 4
    return int(min(length, len(moves)))
