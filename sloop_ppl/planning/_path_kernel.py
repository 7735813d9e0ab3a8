"""The path search in machine code: what a robot that detects nothing would do next.

Targets stand still, so a path tells beforehand what it will have shown, up to the moment at which
a target is detected. Its value is therefore a sum over the belief, for which no targets are drawn.
A path visits poses p_1, p_2, .. at steps 1, 2, ..; with hit rate h, mass m of a cell and the share
f of it that the path has left, the detection mass of a step, the remaining mass, and the return are

    D_t = sum over cells c in view of p_t of  h * m_c * f_c
    L_t = L_(t-1) - D_t,  L_0 = expected number of targets
    G_t = G_(t-1) + g ** (t-1) * (r_t * min(L_(t-1), 1) + g * R * D_t)

with discount g, reward r_t of the move and R of a right find, one step after the detection. What
follows is promised by the value bound V, less what the path has seen. `explore` grows a tree of
such paths level by level and goes on with those of the highest ``G_t + g ** t * V_t``.

Legend: N nodes; C candidates of a level; P poses; T levels.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning._compile import inlined, int64, jit
from sloop_ppl.planning._path_map import (
    Objective,
    PathMap,
    PathState,
    cost,
    go_to,
    next_pose,
    undo,
)
from sloop_ppl.planning._value_bound import ValueBound, bound_from, target_bound

__all__ = [
    "NODE",
    "Candidates",
    "explore",
    "lift_last",
    "new_candidates",
    "new_tree",
    "sink_first",
]

NODE = np.dtype(
    [
        ("pose", np.int64),
        ("parent", np.int64),
        ("move", np.int64),
        ("child", np.int64, (3,)),
        ("first", np.int64),
        ("detected", np.float64),
        ("remaining", np.float64),
        ("past", np.float64),
        ("ahead", np.float64),
        ("visits", np.int64),
        ("twin", np.int64),
        ("complete", np.int64),
    ]
)
"""A node of the tree; node 0 is the robot's pose, and the levels follow one another.

pose, parent, move
    Where it is, the node before it, and the move between.
child
    Node after each move, -1 where the path was not gone on with.
first
    The first move of the path to it.
detected, remaining, past
    D, L and G of the path to it.
ahead
    Value-to-go: V at first and, once paths below it are complete, that of the best of them.
visits
    How many simulations began at it or below.
twin
    The node before it at the same pose and level, or -1.
complete
    1 when a path through it was followed to the horizon.
"""

CANDIDATE = np.dtype(
    [
        ("pose", np.int64),
        ("parent", np.int64),
        ("move", np.int64),
        ("detected", np.float64),
        ("past", np.float64),
        ("ahead", np.float64),
    ]
)
"""A path one move longer than a node's; fields as in `NODE`."""

KEPT = np.dtype([("stamp", np.int32), ("node", np.int32)])
"""The stamp of the last node that was kept at a pose, and its number; no two levels have the same
stamp, nor have those of two trees, so that nothing has to be cleared between them."""


class Candidates(NamedTuple):
    """Extensions of the paths of one level, and a heap of them.

    Attributes
    ----------
    paths
        Array of `CANDIDATE`, shape (C,).
    score
        What each path is thought to be worth in all, ``G + g ** t * V``, shape (C,).
    heap
        Candidates, the most promising first, shape (C,).
    kept
        Array of `KEPT`, shape (P,).
    """

    paths: NDArray[Any]
    score: NDArray[np.float64]
    heap: NDArray[np.int64]
    kept: NDArray[Any]


def new_tree(size: int) -> NDArray[Any]:
    """Return room for a tree."""
    return np.zeros(size, dtype=NODE)


def new_candidates(size: int, n_poses: int) -> Candidates:
    """Return room for the candidates of a level."""
    return Candidates(
        paths=np.zeros(size, dtype=CANDIDATE),
        score=np.zeros(size),
        heap=np.zeros(size, dtype=np.int64),
        kept=np.zeros(n_poses, dtype=KEPT),
    )


# A heap of numbers in place, the highest score first; of equal scores the lower number.


@inlined
def _above(score: NDArray[np.float64], a: int, b: int) -> bool:
    return score[a] > score[b] or (score[a] == score[b] and a < b)


@inlined
def lift_last(heap: NDArray[np.int64], score: NDArray[np.float64], size: int) -> None:
    """Bring the last of the heap to its place."""
    place = size - 1
    item = heap[place]
    while place > 0:
        up = (place - 1) // 2
        if not _above(score, item, heap[up]):
            break
        heap[place] = heap[up]
        place = up
    heap[place] = item


@inlined
def sink_first(heap: NDArray[np.int64], score: NDArray[np.float64], size: int) -> None:
    """Take the first off the heap, which then has one less."""
    item = heap[size - 1]
    place, down, last = 0, 1, size - 1
    while down < last:
        if down + 1 < last and _above(score, heap[down + 1], heap[down]):
            down += 1
        if not _above(score, heap[down], item):
            break
        heap[place] = heap[down]
        place, down = down, 2 * down + 1
    heap[place] = item


# Extending a path by a move, and keeping the best extensions.


@inlined
def _expand(
    path_map: PathMap,
    objective: Objective,
    value_bound: ValueBound,
    state: PathState,
    pose: int,
    n_blocks: int,
) -> tuple[float, float]:
    """Return the detection mass D of a pose and the value V that the rest promises from there."""
    # A pose is cell * 8 + heading. Cells seen before have f < 1 and give less; with h = 1, nothing.
    row, col = (pose >> 3) // path_map.n_cols, (pose >> 3) % path_map.n_cols
    detected, heading = 0.0, pose & 7
    centre = (row + path_map.reach) * (path_map.n_cols + 2 * path_map.reach) + col + path_map.reach
    # V = sum over blocks of (M_b - lost_b) * v(p, b), from the sum kept for the empty path.
    ahead = bound_from(value_bound, pose, path_map.n_cols)
    for k in range(path_map.sizes[heading]):
        if len(path_map.hidden) > 0 and path_map.hidden[pose, k]:
            continue
        cell = centre + path_map.fans[heading, k]
        seen = objective.mass[cell] * state.factor[cell] * objective.hit
        if seen > 0.0:
            detected += seen
            block = int64(value_bound.block[cell])
            ahead -= seen * target_bound(value_bound, block, pose, row, col)
    # What the path so far has taken from the blocks is taken off V, too.
    for i in range(n_blocks):
        block = state.lost[i].block
        ahead -= state.lost[block].mass * target_bound(value_bound, block, pose, row, col)
    return detected, ahead


@inlined
def _extend(
    path_map: PathMap,
    objective: Objective,
    value_bound: ValueBound,
    tree: NDArray[Any],
    state: PathState,
    found: Candidates,
    node: int,
    level: int,
    weight: float,
    count: int,
) -> int:
    """Add what may follow a node, to which the path state leads, to the candidates; count them.

    Where the sensor is exact, nothing comes of standing still, nor of turning back from a look that
    showed less than the two turns cost.
    """
    here, barred = tree[node], -1
    # A turn and its undoing cost -2 r L and have earned R D: where that is less, the path is worse
    # than the one without them.
    unpaid = objective.right * here.detected < -2.0 * objective.move * here.remaining
    if objective.hit >= 1.0 and node > 0 and here.move > 0 and unpaid:
        # left (1) undone by right (2), and the other way round
        barred = 3 - here.move
    for move in range(3):
        after = next_pose(path_map, move, here.pose)
        if move == barred or (objective.hit >= 1.0 and after == here.pose):
            continue
        n_blocks = state.levels[level].n_blocks
        detected, ahead = _expand(path_map, objective, value_bound, state, after, n_blocks)
        now = cost(path_map, objective, here.pose, move, here.remaining)
        # G_t of the module; `weight` is g ** (t - 1).
        past = here.past + weight * (now + objective.discount * objective.right * detected)
        path = found.paths[count]
        path.pose, path.parent, path.move = after, node, move
        path.detected, path.past, path.ahead = detected, past, ahead
        found.score[count] = past + weight * objective.discount * ahead
        found.heap[count] = count
        count += 1
        lift_last(found.heap, found.score, count)
    return count


@inlined
def _repeats(tree: NDArray[Any], found: Candidates, candidate: int, stamp: int) -> bool:
    """Tell whether a path to the same pose that has seen as much was kept already."""
    path = found.paths[candidate]
    last = found.kept[path.pose]
    if last.stamp != stamp:
        return False
    remaining = tree[path.parent].remaining - path.detected
    node = int64(last.node)
    while node >= 0:
        # Paths to one pose that have seen the same have the same L, but for the order of the sum.
        gap = tree[node].remaining - remaining
        if -1e-12 < gap < 1e-12:
            return True
        node = tree[node].twin
    return False


@inlined
def _keep(tree: NDArray[Any], found: Candidates, candidate: int, stamp: int, node: int) -> None:
    """Make a node of a candidate."""
    path = found.paths[candidate]
    parent, new, last = tree[path.parent], tree[node], found.kept[path.pose]
    new.pose, new.parent, new.move = path.pose, path.parent, path.move
    parent.child[path.move] = node
    for move in range(3):
        new.child[move] = -1
    # `twin` chains the nodes of one level at one pose, for `_repeats`.
    new.first = path.move if path.parent == 0 else parent.first
    new.detected, new.past, new.ahead = path.detected, path.past, path.ahead
    new.remaining, new.visits = parent.remaining - path.detected, 0
    new.twin = int64(last.node) if last.stamp == stamp else -1
    last.stamp, last.node = stamp, node


@inlined
def _back_up(
    path_map: PathMap, objective: Objective, tree: NDArray[Any], begin: int, end: int
) -> None:
    """Give each node the value-to-go of the best path through it that was followed to the end.

    ``ahead = max over children of  r * min(L, 1) + g * (R * D_child + ahead_child)``.
    """
    for node in range(end):
        tree[node].complete = 1 if node >= begin else 0
    for number in range(end - 1, 0, -1):  # children come after their parents
        node, parent = tree[number], tree[tree[number].parent]
        parent.visits += node.visits
        if node.complete:
            now = cost(path_map, objective, parent.pose, node.move, parent.remaining)
            value = now + objective.discount * (objective.right * node.detected + node.ahead)
            if not parent.complete or value > parent.ahead:
                parent.ahead, parent.complete = value, 1


@jit
def explore(
    path_map: PathMap,
    objective: Objective,
    value_bound: ValueBound,
    tree: NDArray[Any],
    state: PathState,
    found: Candidates,
    sims: int,
    depth: int,
    hint: NDArray[np.int64],
    stamp: int,
) -> tuple[int, int, int]:
    """Grow the tree; return how many nodes it has, the first of the last level, and simulations.

    A simulation goes on with one path by one move.

    Parameters
    ----------
    tree
        Array of `NODE`, shape (N,); node 0 is the root, with its pose and remaining mass set.
    sims
        How many simulations to run, about.
    hint
        Moves of a path to go on with in any case, such as the rest of the last plan.
    stamp
        The first of T stamps that no tree has had before, > 0.
    """
    # numba compiles a function anew for a constant argument; int64 makes variables of these.
    begin, end, marked, weight, spent = int64(0), int64(1), int64(0), 1.0, 0
    block_of, hinted = value_bound.block, 0
    for level in range(depth):
        # All extensions of the level's paths.
        count = int64(0)
        for node in range(begin, end):
            go_to(path_map, objective, block_of, tree, state, node, level, marked)
            marked, before = level, count
            count = _extend(
                path_map, objective, value_bound, tree, state, found, node, level, weight, count
            )
            tree[node].visits = count - before
        spent += count
        # How many to keep, so that the simulations that are left suffice for the levels below.
        levels = depth - level - 1 if level < depth - 1 else 1
        # A kept path brings count / (end - begin) extensions, each a simulation, on each level
        # below: width * levels * count / (end - begin) = sims - spent.
        width = (sims - spent) * (end - begin) // (levels * (count if count > 0 else 1))
        width = width if width > 1 else 1
        # Every kept path has up to 3 extensions, which must fit into the heap, with room for the 4
        # that may be wanted above the width: one for each first move, and the hint.
        most = len(found.heap) // 3 - 4
        width = width if width < most else most
        # Some are kept in any case: the best beginning with each first move, and the hint's.
        musts = 0  # bit m: a path that begins with move m is still wanted; bit 3: the hint
        follower = -1
        for i in range(count):
            path = found.paths[i]
            first = path.move if path.parent == 0 else tree[path.parent].first
            musts |= 1 << first
            if path.parent == hinted and level < len(hint) and path.move == hint[level]:
                follower = i
        if follower >= 0:
            musts |= 8
        begin, hinted = end, -1
        for rest in range(count, 0, -1):
            # Places are held free for those that are wanted but have not come off the heap yet.
            wanted = (musts & 1) + (musts >> 1 & 1) + (musts >> 2 & 1) + (musts >> 3)
            if (end - begin >= width and wanted == 0) or end == len(tree):
                break
            candidate = found.heap[0]
            sink_first(found.heap, found.score, rest)
            path = found.paths[candidate]
            first = path.move if path.parent == 0 else tree[path.parent].first
            must = musts >> first & 1 or candidate == follower
            if end - begin + wanted >= width and not must:
                continue
            # The best of each first move is kept even where another path has led to the same.
            if not must and _repeats(tree, found, candidate, stamp + level):
                continue
            musts &= ~(1 << first)
            if candidate == follower:
                musts, hinted = musts & 7, end
            _keep(tree, found, candidate, stamp + level, end)
            end += 1
        weight *= objective.discount
        if begin == end:
            break
    undo(objective, block_of, state, marked, int64(0))
    _back_up(path_map, objective, tree, begin, end)
    return end, begin, spent
