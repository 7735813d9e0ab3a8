"""All poses at once: where moves lead, how many moves away they are, how much belief they see."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning.pose import HEADINGS
from sloop_ppl.planning.space import SearchSpace

__all__ = ["Reach", "next_poses", "reach_from", "visible_mass"]


class Reach(NamedTuple):
    """How poses are reached from one pose.

    Attributes
    ----------
    steps
        Fewest moves to each pose, at least one; -1 where it cannot be reached.
    first
        Index of the first of those moves; ties go to the earlier action.
    """

    steps: NDArray[np.int32]
    first: NDArray[np.int8]


def next_poses(space: SearchSpace) -> NDArray[np.int32]:
    """Return the most probable pose after each move from each pose, shape (3, H * W * 8)."""
    poses = np.arange(space.n_cells * HEADINGS, dtype=np.int32)
    heading = poses % HEADINGS
    row, col = np.divmod(poses // HEADINGS, space.n_cols)
    after = []
    for index in range(3):
        rows, cols, turn = space.move_table.offsets[index, :, 0].T.astype(np.int32)
        new_row, new_col = row + rows[heading], col + cols[heading]
        inside_rows = (new_row >= 0) & (new_row < space.n_rows)
        free = inside_rows & (new_col >= 0) & (new_col < space.n_cols)
        if space.no_fly and (rows.any() or cols.any()):
            free[[pose for pose in poses.tolist() if space.moved(index, pose)[1]]] = False
        reached = (new_row * space.n_cols + new_col) * HEADINGS + (heading + turn[heading]) % 8
        after.append(np.where(free, reached, poses))
    return np.stack(after).astype(np.int32, copy=False)


def reach_from(pose: int, nexts: NDArray[np.int32]) -> Reach:
    """Return the fewest moves from one pose to every other, by breadth-first search.

    Parameters
    ----------
    pose
        Where the robot is.
    nexts
        What `next_poses` returned.
    """
    steps = np.full(nexts.shape[1], -1, dtype=np.int32)
    first = np.zeros(nexts.shape[1], dtype=np.int8)
    frontier, where = np.unique(nexts[:, pose], return_index=True)
    label = where.astype(np.int8)
    depth = 1
    while frontier.size:
        order = np.argsort(label, kind="stable")
        frontier, label = frontier[order], label[order]
        steps[frontier], first[frontier] = depth, label
        reached = nexts[:, frontier].T.ravel()
        labels = np.repeat(label, 3)
        new = steps[reached] < 0
        frontier, where = np.unique(reached[new], return_index=True)
        label = labels[new][where]
        depth += 1
    return Reach(steps, first)


def visible_mass(space: SearchSpace, tables: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return the expected number of targets in view from each pose, shape (H * W * 8,).

    Parameters
    ----------
    space
        The search space.
    tables
        Belief of each target to count, each of shape (H * W,).
    """
    if space.hides:
        total = np.sum(tables, axis=0)
        return np.array(
            [total[list(space.view(pose))].sum() for pose in range(space.n_cells * HEADINGS)]
        )
    reach = max((max(abs(dr), abs(dc)) for fan in space.fans for dr, dc in fan), default=0)
    padded = np.pad(np.sum(tables, axis=0).reshape(space.shape), reach)
    mass = np.zeros((*space.shape, HEADINGS))
    for heading, fan in enumerate(space.fans):
        for dr, dc in fan:
            mass[:, :, heading] += padded[
                reach + dr : reach + dr + space.n_rows, reach + dc : reach + dc + space.n_cols
            ]
    return mass.ravel()
