"""Search over paths in machine code: what a robot that sees nothing would do next.

Targets stand still, so a path tells beforehand what it will have shown, up to the moment at which
a target is seen. Its worth can therefore be added up from the belief, without drawing targets: a
move at step t costs while something is left to be found, and what comes into view is found one
step later. `explore` grows a tree of such paths level by level and goes on with the most promising
of each level.

Legend: V nodes; W candidates of a level; P poses; B blocks.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning.compile import inlined, jit
from sloop_ppl.planning.ground import Ground, Worth, after_move, cost
from sloop_ppl.planning.outlook import Outlook, block_worth, outlook_from
from sloop_ppl.planning.ranking import lift_last, sink_first
from sloop_ppl.planning.trail import PathTree, Trail, go_to, retreat

__all__ = ["Candidates", "PathTree", "explore", "worth_of_move"]


class Candidates(NamedTuple):
    """Extensions of the paths of one level, and a heap of them.

    Attributes
    ----------
    score : what the path is thought to be worth in all, shape (W,).
    pose, parent, move, gain, past, later : as in `PathTree`; `later` is the outlook, shape (W,).
    heap : candidates, the most promising first, shape (W,).
    level, node : at each pose, the level of the last node there and its number, shape (P,).
    before : at each node, the last one before it at the same pose and level, or -1, shape (V,).
    """

    score: NDArray[np.float64]
    pose: NDArray[np.int32]
    parent: NDArray[np.int32]
    move: NDArray[np.int32]
    gain: NDArray[np.float64]
    past: NDArray[np.float64]
    later: NDArray[np.float64]
    heap: NDArray[np.int32]
    level: NDArray[np.int32]
    node: NDArray[np.int32]
    before: NDArray[np.int32]


@inlined
def _glance(
    ground: Ground, worth: Worth, outlook: Outlook, trail: Trail, pose: int, n_blocks: int
) -> tuple[float, float]:
    """Return the mass that a pose shows and what the rest promises from there."""
    cell_number, heading = pose >> 3, pose & 7
    row, col = cell_number // ground.n_cols, cell_number % ground.n_cols
    gain, home = 0.0, ground.home[pose]
    later = outlook_from(outlook, pose, ground.n_cols)
    for k in range(ground.sizes[heading]):
        if len(ground.hidden) > 0 and ground.hidden[pose, k]:
            continue
        cell = home + ground.fans[heading, k]
        seen = worth.mass[cell] * trail.factor[cell] * worth.hit
        if seen > 0.0:
            gain += seen
            later -= seen * block_worth(outlook, outlook.block[cell], pose, row, col)
    for i in range(n_blocks):
        block = trail.blocks[i]
        later -= trail.lost[block] * block_worth(outlook, block, pose, row, col)
    return gain, later


@inlined
def _extend(
    ground: Ground,
    worth: Worth,
    outlook: Outlook,
    tree: PathTree,
    node: int,
    weight: float,
    trail: Trail,
    n_blocks: int,
    found: Candidates,
    count: int,
) -> int:
    """Add what may follow a node, to which the trail leads, to the candidates; count them.

    Where the sensor is exact, nothing comes of standing still, nor of turning back from a look that
    showed less than the two turns cost.
    """
    pose, turned, barred = tree.pose[node], tree.move[node], -1
    paid = worth.right * tree.gain[node] >= -2.0 * worth.move * tree.left[node]
    if worth.hit >= 1.0 and node > 0 and turned > 0 and not paid:
        barred = 3 - turned
    for move in range(3):
        after = after_move(ground, pose, move)
        if move == barred or (worth.hit >= 1.0 and after == pose):
            continue
        gain, later = _glance(ground, worth, outlook, trail, after, n_blocks)
        now = cost(ground, worth, pose, move, tree.left[node])
        past = tree.past[node] + weight * (now + worth.discount * worth.right * gain)
        found.pose[count], found.parent[count], found.move[count] = after, node, move
        found.gain[count], found.past[count], found.later[count] = gain, past, later
        found.score[count] = past + weight * worth.discount * later
        found.heap[count] = count
        lift_last(found.heap, found.score, count + 1)
        count += 1
    return count


@inlined
def _repeats(tree: PathTree, found: Candidates, candidate: int, level: int) -> bool:
    """Tell whether a path to the same pose that has seen as much was kept already."""
    pose = found.pose[candidate]
    if found.level[pose] != level:
        return False
    left = tree.left[found.parent[candidate]] - found.gain[candidate]
    node = found.node[pose]
    while node >= 0:
        if abs(tree.left[node] - left) < 1e-12:
            return True
        node = found.before[node]
    return False


@inlined
def _keep(tree: PathTree, found: Candidates, candidate: int, level: int, node: int) -> None:
    """Make a node of a candidate."""
    pose, parent, move = found.pose[candidate], found.parent[candidate], found.move[candidate]
    tree.pose[node], tree.parent[node], tree.move[node] = pose, parent, move
    tree.child[parent, move] = node
    for m in range(3):
        tree.child[node, m] = -1
    tree.first[node] = move if parent == 0 else tree.first[parent]
    tree.gain[node], tree.past[node] = found.gain[candidate], found.past[candidate]
    tree.left[node] = tree.left[parent] - found.gain[candidate]
    tree.best[node], tree.visits[node] = found.later[candidate], 0
    found.before[node] = found.node[pose] if found.level[pose] == level else -1
    found.level[pose], found.node[pose] = level, node


@jit
def explore(
    ground: Ground,
    worth: Worth,
    outlook: Outlook,
    tree: PathTree,
    trail: Trail,
    found: Candidates,
    sims: int,
    depth: int,
    hint: NDArray[np.int32],
) -> tuple[int, int, int]:
    """Grow the tree; return how many nodes it has, the first of the last level, and simulations.

    A simulation goes on with one path by one move.

    Parameters
    ----------
    ground, worth, outlook : the map, what counts, and what is promised.
    tree : the tree; node 0 is the root, with its pose and left set.
    trail, found : room.
    sims : how many simulations to run, about.
    depth : how many moves the paths have.
    hint : moves of a path to go on with in any case, such as the rest of the last plan.
    """
    begin, end, weight, spent = 0, 1, 1.0, 0
    hinted, marked = 0, 0
    for level in range(depth):
        count = 0
        for node in range(begin, end):
            go_to(ground, worth, outlook, tree, trail, node, level, marked)
            marked, n_blocks = level, trail.ends[level, 1]
            before = count
            count = _extend(
                ground, worth, outlook, tree, node, weight, trail, n_blocks, found, count
            )
            tree.visits[node] = count - before
        spent += count
        levels = max(depth - level - 1, 1)
        width = (sims - spent) * (end - begin) // (levels * max(count, 1))
        width = min(max(width, 1), len(found.heap) // 3 - 4)
        musts = 0  # bit m: a path that begins with move m is still wanted; bit 3: the hint
        follower = -1
        for i in range(count):
            parent = found.parent[i]
            first = found.move[i] if parent == 0 else tree.first[parent]
            musts |= 1 << first
            if parent == hinted and level < len(hint) and found.move[i] == hint[level]:
                follower = i
        if follower >= 0:
            musts |= 8
        begin, size, hinted = end, end, -1
        for rest in range(count, 0, -1):
            wanted = (musts & 1) + (musts >> 1 & 1) + (musts >> 2 & 1) + (musts >> 3)
            if (size - begin >= width and wanted == 0) or size == len(tree.pose):
                break
            candidate = found.heap[0]
            sink_first(found.heap, found.score, rest)
            parent = found.parent[candidate]
            first = found.move[candidate] if parent == 0 else tree.first[parent]
            must = bool(musts >> first & 1) or candidate == follower
            if size - begin + wanted >= width and not must:
                continue
            if not must and _repeats(tree, found, candidate, level):
                continue
            musts &= ~(1 << first)
            if candidate == follower:
                musts, hinted = musts & 7, size
            _keep(tree, found, candidate, level, size)
            size += 1
        end = size
        weight *= worth.discount
        if begin == end:
            break
    retreat(worth, outlook, trail, marked, 0)
    _back_up(ground, worth, tree, begin, end)
    return end, begin, spent


@inlined
def _back_up(ground: Ground, worth: Worth, tree: PathTree, begin: int, end: int) -> None:
    """Give each node the worth of the best path through it that was followed to the end."""
    for node in range(end):
        tree.whole[node] = node >= begin
    for node in range(end - 1, 0, -1):
        parent = tree.parent[node]
        tree.visits[parent] += tree.visits[node]
        if tree.whole[node]:
            value = worth_of_move(ground, worth, tree, parent, tree.move[node])
            if not tree.whole[parent] or value > tree.best[parent]:
                tree.best[parent], tree.whole[parent] = value, True


@inlined
def worth_of_move(ground: Ground, worth: Worth, tree: PathTree, node: int, move: int) -> float:
    """Return the worth of a move at a node whose child is there."""
    child = tree.child[node, move]
    later = worth.right * tree.gain[child] + tree.best[child]
    now = cost(ground, worth, tree.pose[node], move, tree.left[node])
    return float(now + worth.discount * later)
