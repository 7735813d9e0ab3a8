"""What the path search runs on: map and objective as arrays, and what a path has seen of the map.

With hit rate h and mass m of a cell, a path leaves the share f of the mass; each look makes it
``f * (1 - h)``. Going on to a path beside it takes back and marks anew only where the two differ.

Legend: P poses, numbered ``(row * W + column) * 8 + heading``; K cells of the largest fan; R
largest offset in a fan; G cells of the bordered map, that is (H + 2 R) * (W + 2 R); B blocks; T
levels of the tree.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning._compile import inlined, int64, jit
from sloop_ppl.planning._search_tables import reach_of, search_data
from sloop_ppl.planning.space import SearchSpace

__all__ = [
    "Objective",
    "PathMap",
    "PathState",
    "bordered_cell",
    "cost",
    "detection_masses",
    "go_to",
    "new_path_state",
    "next_pose",
    "path_map_of",
    "undo",
]


class PathMap(NamedTuple):
    """Where moves lead and what is seen; the map has a border of R cells so that views fit.

    Attributes
    ----------
    offsets
        Rows, columns and eighths of a turn of each move's most probable outcome by heading, shape
        (3, 8, 3).
    collides
        True where that outcome hits a no-fly building, shape (3, P) or (0, 0).
    fans, sizes
        Offsets of the fan's cells in the bordered map by heading, shape (8, K), and how many there
        are, (8,).
    hidden
        True where a place of the fan is hidden from a pose, shape (P, K) or (0, 0).
    n_rows, n_cols
        Rows and columns of the map.
    reach
        R.
    """

    offsets: NDArray[np.int64]
    collides: NDArray[np.bool_]
    fans: NDArray[np.int32]
    sizes: NDArray[np.int64]
    hidden: NDArray[np.bool_]
    n_rows: int
    n_cols: int
    reach: int


class Objective(NamedTuple):
    """What counts: belief and rewards.

    Attributes
    ----------
    mass
        Expected number of targets m by cell of the bordered map, shape (G,).
    total
        Expected number of targets.
    hit
        Probability of detecting what is in view.
    move, collision, right
        Rewards.
    discount
        Discount factor per step.
    """

    mass: NDArray[np.float64]
    total: float
    hit: float
    move: float
    collision: float
    right: float
    discount: float


def path_map_of(space: SearchSpace) -> PathMap:
    """Return the map as arrays, with a border as wide as the sensor sees."""
    data, reach = search_data(space), reach_of(space)
    # A border R wide on all sides: a fan reaches cells that hold no mass instead of other rows.
    width = space.n_cols + 2 * reach
    # Of the outcomes of a move the first is the most probable, which is all the path search counts.
    blocked = np.ascontiguousarray(data.blocked[:, 0]) if len(data.blocked) else None
    return PathMap(
        offsets=np.ascontiguousarray(space.move_table.offsets[:, :, 0]),
        collides=np.zeros((0, 0), dtype=bool) if blocked is None else blocked,
        fans=(data.fans[:, :, 0] * width + data.fans[:, :, 1]).astype(np.int32),
        sizes=data.fan_sizes,
        hidden=data.hidden,
        n_rows=space.n_rows,
        n_cols=space.n_cols,
        reach=reach,
    )


# Reckoned where they are needed: as tables over all poses they would be what a large map costs.


@inlined
def next_pose(path_map: PathMap, move: int, pose: int) -> int:
    """Return the most probable pose after a move; what stops the robot leaves the pose."""
    if len(path_map.collides) > 0 and path_map.collides[move, pose]:
        return pose
    heading = pose & 7
    row = (pose >> 3) // path_map.n_cols + path_map.offsets[move, heading, 0]
    col = (pose >> 3) % path_map.n_cols + path_map.offsets[move, heading, 1]
    if row < 0 or row >= path_map.n_rows or col < 0 or col >= path_map.n_cols:
        return pose
    # & 7: the remainder of the division by 8, of negative numbers, too
    turned = (heading + path_map.offsets[move, heading, 2]) & 7
    after: int = int64((row * path_map.n_cols + col) * 8 + turned)
    return after


@inlined
def bordered_cell(path_map: PathMap, pose: int) -> int:
    """Return the index of a pose's cell in the bordered map."""
    row, col = (pose >> 3) // path_map.n_cols, (pose >> 3) % path_map.n_cols
    width = path_map.n_cols + 2 * path_map.reach
    cell: int = int64((row + path_map.reach) * width + col + path_map.reach)
    return cell


@inlined
def cost(path_map: PathMap, objective: Objective, pose: int, move: int, remaining: float) -> float:
    """Return the expected reward of a move, r * min(L, 1): it counts while L > 0 is left."""
    reward = objective.move
    if len(path_map.collides) > 0 and path_map.collides[move, pose]:
        reward = objective.collision
    # The search goes on, and the move is paid, with probability min(L, 1) at most: for one target
    # L is the probability that it was not detected yet.
    return reward * remaining if remaining < 1.0 else reward


@jit
def detection_masses(
    path_map: PathMap,
    mass: NDArray[np.float64],
    hit: float,
    poses: NDArray[np.int64],
    detected: NDArray[np.float64],
) -> None:
    """Fill in how many targets each pose of a path is expected to be the first to show.

    At pose t it is ``hit * sum of m over its view``, after which each m there becomes
    ``(1 - hit) * m``: `mass`, shape (G,), is changed. `detected` is all zeros before.
    """
    for i in range(len(poses)):
        pose = poses[i]
        centre, heading = bordered_cell(path_map, pose), pose & 7
        for k in range(path_map.sizes[heading]):
            if len(path_map.hidden) == 0 or not path_map.hidden[pose, k]:
                cell = centre + path_map.fans[heading, k]
                detected[i] += hit * mass[cell]
                mass[cell] *= 1.0 - hit


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
        # All ones: nothing was seen; `seen` has room for a whole view at each level.
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
    centre, heading = bordered_cell(path_map, pose), pose & 7
    for k in range(path_map.sizes[heading]):
        if len(path_map.hidden) > 0 and path_map.hidden[pose, k]:
            continue
        cell = centre + path_map.fans[heading, k]
        share = state.factor[cell]
        detected = objective.mass[cell] * share * objective.hit
        # Cells without mass are not marked: nothing would have to be taken back.
        if detected > 0.0:
            state.factor[cell] = share * (1.0 - objective.hit)
            state.seen[n_seen].cell, state.seen[n_seen].share = cell, share
            n_seen += 1
            block = block_of[cell]
            # The first loss of a block enters it into the list `lost[:n_blocks].block`.
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
    # Backwards: a cell that was seen twice gets back the share from before the first look.
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
    # The path to the node from the leaf up, and how many of its first levels are marked already.
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
