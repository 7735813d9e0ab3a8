"""What one path has seen, marked on the map: the state that the path search moves about its tree.

With hit rate h and mass m of a cell, a path leaves the share f of the mass; each look makes it
``f * (1 - h)``. Going on to a path beside it takes back and marks anew only where the two differ.

Legend: B blocks; T levels; G cells of the bordered map.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning._compile import inlined
from sloop_ppl.planning._path_map import Objective, PathMap

__all__ = ["PathState", "go_to", "new_path_state", "undo"]

SEEN = np.dtype([("cell", np.int64), ("share", np.float64)])
"""A cell that the path has seen, and the share f of its mass that was left before."""

LOST = np.dtype([("mass", np.float64), ("block", np.int64)])
"""Mass that a block has lost to the path. `block` is a list apart, of the blocks that have."""

LEVEL = np.dtype(
    [("n_seen", np.int64), ("n_blocks", np.int64), ("node", np.int64), ("wanted", np.int64)]
)
"""How many cells and blocks the path has seen, its node, and room for another path."""


class PathState(NamedTuple):
    """What one path has seen.

    Attributes
    ----------
    factor
        Share f of each cell's mass that is left, shape (G,); all ones at the root.
    lost
        Array of `LOST`, shape (B,).
    seen
        Array of `SEEN`, in the order in which cells were seen.
    levels
        Array of `LEVEL`, shape (T + 1,).
    """

    factor: NDArray[np.float64]
    lost: NDArray[Any]
    seen: NDArray[Any]
    levels: NDArray[Any]


def new_path_state(n_cells: int, n_blocks: int, depth: int, most: int) -> PathState:
    """Return the state of the empty path; `most` is the number of cells of the largest view."""
    return PathState(
        factor=np.ones(n_cells),
        lost=np.zeros(n_blocks, dtype=LOST),
        seen=np.zeros((depth + 1) * most, dtype=SEEN),
        levels=np.zeros(depth + 1, dtype=LEVEL),
    )


@inlined
def _see(
    path_map: PathMap,
    objective: Objective,
    block_of: NDArray[np.int32],
    state: PathState,
    pose: int,
    level: int,
) -> None:
    """Mark what the pose at a level of the path shows: f becomes f * (1 - h) in its view."""
    before, now = state.levels[level - 1], state.levels[level]
    n_seen, n_blocks = before.n_seen, before.n_blocks
    centre, heading = path_map.cell[pose], pose & 7
    for k in range(path_map.sizes[heading]):
        if len(path_map.hidden) > 0 and path_map.hidden[pose, k]:
            continue
        cell = centre + path_map.fans[heading, k]
        share = state.factor[cell]
        detected = objective.mass[cell] * share * objective.hit
        if detected > 0.0:
            state.factor[cell] = share * (1.0 - objective.hit)
            state.seen[n_seen].cell, state.seen[n_seen].share = cell, share
            n_seen += 1
            block = block_of[cell]
            if state.lost[block].mass == 0.0:
                state.lost[n_blocks].block = block
                n_blocks += 1
            state.lost[block].mass += detected
    now.n_seen, now.n_blocks = n_seen, n_blocks


@inlined
def undo(
    objective: Objective, block_of: NDArray[np.int32], state: PathState, level: int, to: int
) -> None:
    """Take back what the levels above `to` have marked, the last first."""
    old, new = state.levels[level], state.levels[to]
    for i in range(old.n_seen - 1, new.n_seen - 1, -1):
        cell, share = state.seen[i].cell, state.seen[i].share
        state.factor[cell] = share
        state.lost[block_of[cell]].mass -= objective.mass[cell] * share * objective.hit
    for i in range(new.n_blocks, old.n_blocks):
        state.lost[state.lost[i].block].mass = 0.0  # what rounding has left


@inlined
def go_to(
    path_map: PathMap,
    objective: Objective,
    block_of: NDArray[np.int32],
    tree: NDArray[Any],
    state: PathState,
    node: int,
    level: int,
    marked: int,
) -> None:
    """Mark what the path to a node at some level has seen, where `marked` levels of one are."""
    levels = state.levels
    for i in range(level, 0, -1):
        levels[i].wanted = node
        node = tree[node].parent
    same = 0
    while same < level and same < marked and levels[same + 1].wanted == levels[same + 1].node:
        same += 1
    undo(objective, block_of, state, marked, same)
    for i in range(same + 1, level + 1):
        levels[i].node = levels[i].wanted
        _see(path_map, objective, block_of, state, tree[levels[i].node].pose, i)
