"""Poses worth driving to, and how far they are from everywhere."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.search.compile import jit
from sloop_ppl.search.ground import Ground, Worth, mass_in_view

__all__ = ["flood", "look_around", "pick_goals"]


@jit
def flood(ground: Ground, goal: int, field: NDArray[np.int16], queue: NDArray[np.int32]) -> None:
    """Fill in the fewest moves from every pose to a goal; -1 where there is no way."""
    for pose in range(len(field)):
        field[pose] = -1
    field[goal], queue[0] = 0, goal
    head, tail = 0, 1
    while head < tail:
        pose = queue[head]
        head += 1
        base = pose - (pose & 7)
        around = (
            np.int64(ground.before[pose]),
            base + ((pose + ground.turn) & 7),
            base + ((pose - ground.turn) & 7),
        )
        for k in range(3):
            other = around[k]
            if other >= 0 and field[other] < 0:
                field[other] = field[pose] + 1
                queue[tail] = other
                tail += 1


@jit
def look_around(
    ground: Ground, worth: Worth, factor: NDArray[np.float64], seen: NDArray[np.float64]
) -> None:
    """Fill in the mass in view from every pose."""
    for pose in range(len(seen)):
        seen[pose] = mass_in_view(ground, worth, factor, pose)


@jit
def pick_goals(
    ground: Ground,
    worth: Worth,
    factor: NDArray[np.float64],
    seen: NDArray[np.float64],
    steps: NDArray[np.int16],
    reach: int,
    goals: NDArray[np.int32],
) -> int:
    """Pick poses that see much of what those picked before do not; return how many.

    Parameters
    ----------
    ground, worth : the map, and what counts.
    factor : all ones, bordered map; changed and restored.
    seen : mass in view from every pose, as `look_around` fills it in; changed.
    steps : moves from the robot to every pose, or an underestimate.
    reach : R.
    goals : room for the goals.
    """
    n_cells = len(seen) // 8
    n_cols = ground.width - 2 * reach
    count, least = 0, 0.0
    while count < len(goals):
        goal, best = -1, 0.0
        for pose in range(len(seen)):
            if seen[pose] > best and steps[pose] >= 0:
                score = seen[pose] * worth.powers[steps[pose] // 2]
                if score > best:
                    goal, best = pose, score
        if goal < 0 or best < least:
            break
        if count == 0:
            least = best * 1e-4
        goals[count] = goal
        count += 1
        home = ground.home[goal]
        for k in range(ground.sizes[goal & 7]):
            if len(ground.hidden) == 0 or not ground.hidden[goal, k]:
                factor[home + ground.fans[goal & 7, k]] = 0.0
        row, col = (goal >> 3) // n_cols, (goal >> 3) % n_cols
        rows = n_cells // n_cols
        for r in range(max(row - 2 * reach, 0), min(row + 2 * reach + 1, rows)):
            for c in range(max(col - 2 * reach, 0), min(col + 2 * reach + 1, n_cols)):
                for heading in range(8):
                    pose = (r * n_cols + c) * 8 + heading
                    seen[pose] = mass_in_view(ground, worth, factor, pose)
    for cell in range(len(factor)):
        factor[cell] = 1.0
    return count
