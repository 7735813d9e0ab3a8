"""What a target in a block of cells would be worth from a pose, round no-fly buildings.

Legend: P poses; B blocks.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning.compile import jit
from sloop_ppl.planning.ground import Ground, ground_of
from sloop_ppl.planning.hindsight import known_worth
from sloop_ppl.planning.space import SearchSpace

__all__ = ["detour_worths"]


def detour_worths(space: SearchSpace, block: NDArray[np.int32]) -> NDArray[np.float32]:
    """Return the discounted return of driving until a block is in view and finding the target.

    Parameters
    ----------
    space : the search space, with its obstacles.
    block : block of each cell of the bordered map.

    Returns
    -------
    numpy.ndarray
        By pose and block, shape (P, B).
    """
    ground = ground_of(space)
    n_poses, n_blocks = len(ground.ahead), int(block.max()) + 1
    poses = np.arange(n_poses, dtype=np.int32)
    before = np.full(n_poses, -1, dtype=np.int32)
    moved = ground.ahead != poses
    before[ground.ahead[moved]] = poses[moved]
    worths = np.empty((n_poses, n_blocks), dtype=np.float32)
    steps, queue = np.empty(n_poses, dtype=np.int32), np.empty(n_poses, dtype=np.int32)
    for number in range(n_blocks):
        _flood(ground, before, block, number, steps, queue)
        steps[steps < 0] = n_poses
        worths[:, number] = known_worth(space.config, steps.astype(np.float64))
    return worths


@jit
def _flood(
    ground: Ground,
    before: NDArray[np.int32],
    block: NDArray[np.int32],
    wanted: int,
    steps: NDArray[np.int32],
    queue: NDArray[np.int32],
) -> None:
    """Fill in the fewest moves from every pose until a block is in view; -1 where it never is."""
    head, tail = 0, 0
    for pose in range(len(steps)):
        steps[pose] = -1
        home, heading = ground.home[pose], pose & 7
        for k in range(ground.sizes[heading]):
            if len(ground.hidden) > 0 and ground.hidden[pose, k]:
                continue
            if block[home + ground.fans[heading, k]] == wanted:
                steps[pose], queue[tail] = 0, pose
                tail += 1
                break
    while head < tail:
        pose = queue[head]
        head += 1
        base = pose - (pose & 7)
        around = (
            np.int64(before[pose]),
            base + ((pose + ground.turn) & 7),
            base + ((pose - ground.turn) & 7),
        )
        for k in range(3):
            other = around[k]
            if other >= 0 and steps[other] < 0:
                steps[other] = steps[pose] + 1
                queue[tail] = other
                tail += 1
