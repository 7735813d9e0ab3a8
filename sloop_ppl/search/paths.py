"""Search over paths in machine code: what a robot that sees nothing would do next.

Targets stand still, so a path tells beforehand what it will have shown, up to the moment at which
a target is seen. Its worth can therefore be added up from the belief, without drawing targets: a
move at step t costs while something is left to be found, and what comes into view is found one
step later. `explore` grows a tree of such paths; a leaf is worth what a belief-greedy walk earns
from there, and a node as much as the best that was found below it.

Legend: P poses; V nodes; G goals.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.search.compile import inlined, jit
from sloop_ppl.search.ground import Ground, Worth, mass_in_view

__all__ = ["PathTree", "explore"]


class PathTree(NamedTuple):
    """Paths from the robot's pose; node 0 is the root.

    Attributes
    ----------
    pose, parent, move : where a node is, the node before it, and the move between, shape (V,).
    child : node after each move, -1 where there is none yet, shape (V, 3).
    visits : how many simulations went through it, shape (V,).
    gain : expected number of targets that are first seen on entering it, shape (V,).
    left : expected number of targets that are left, shape (V,).
    best : worth of what follows, as far as it is known, shape (V,).
    factor : share of each cell's mass that is left on the present path, bordered map.
    log : cells that the present path changed; `old` is what their factor was.
    """

    pose: NDArray[np.int32]
    parent: NDArray[np.int32]
    move: NDArray[np.int32]
    child: NDArray[np.int32]
    visits: NDArray[np.int32]
    gain: NDArray[np.float64]
    left: NDArray[np.float64]
    best: NDArray[np.float64]
    factor: NDArray[np.float64]
    log: NDArray[np.int32]
    old: NDArray[np.float64]


@inlined
def _look(
    ground: Ground, worth: Worth, tree: PathTree, pose: int, logged: int
) -> tuple[float, int]:
    """Take what is in view from a pose off the map; return how much it was and the log's length."""
    total, home, heading = 0.0, ground.home[pose], pose & 7
    for k in range(ground.sizes[heading]):
        if len(ground.hidden) > 0 and ground.hidden[pose, k]:
            continue
        cell = home + ground.fans[heading, k]
        share = tree.factor[cell]
        seen = worth.mass[cell] * share
        if seen > 0.0:
            total += seen
            tree.log[logged], tree.old[logged] = cell, share
            logged += 1
            tree.factor[cell] = share * (1.0 - worth.hit)
    return total * worth.hit, logged


@inlined
def _cost(ground: Ground, worth: Worth, pose: int, move: int, left: float) -> float:
    """Return the expected reward of a move; it counts while something is left."""
    reward = worth.move
    if move == 0 and len(ground.collides) > 0 and ground.collides[pose]:
        reward = worth.collision
    return reward * min(left, 1.0)


@jit
def _walk(
    ground: Ground,
    worth: Worth,
    tree: PathTree,
    goals: NDArray[np.int32],
    fields: NDArray[np.int16],
    pose: int,
    left: float,
    level: int,
    logged: int,
) -> tuple[float, int]:
    """Return what a belief-greedy walk earns, and the log's length.

    It drives to the goal with the most discounted mass in view, then to the next, and sees what
    comes into view on the way; of equally short ways it takes the one that shows more.
    """
    total, weight = 0.0, 1.0
    enough = 1e-3 * tree.left[0]
    while level < worth.horizon and left > enough:
        goal, best = -1, 1e-6 * left
        for g in range(len(goals)):
            far = fields[g, pose]
            if far <= 0:
                continue
            score = worth.powers[far] * mass_in_view(ground, worth, tree.factor, goals[g])
            if score > best:
                goal, best = g, score
        if goal < 0:
            break
        far = fields[goal, pose]
        while far > 0 and level < worth.horizon:
            move, most = -1, -1.0
            for m in range(3):
                after = ground.nexts[m, pose]
                if fields[goal, after] == far - 1:
                    shown = mass_in_view(ground, worth, tree.factor, after)
                    if shown > most:
                        move, most = m, shown
            total += weight * _cost(ground, worth, pose, move, left)
            pose = ground.nexts[move, pose]
            gain, logged = _look(ground, worth, tree, pose, logged)
            weight *= worth.powers[1]
            total += weight * worth.right * gain
            left -= gain
            level += 1
            far -= 1
    if worth.powers[1] < 1.0:  # what is never found goes on costing
        total += weight * worth.move * min(left, 1.0) / (1.0 - worth.powers[1])
    return total, logged


@jit
def _know(worth: Worth, tree: PathTree, pose: int) -> float:
    """Return what one would earn from a pose who knew where the targets that are left are."""
    rows, cols = (worth.bound.shape[1] + 1) // 2, (worth.bound.shape[2] + 1) // 2
    row, col, heading = (pose >> 3) // cols, (pose >> 3) % cols, pose & 7
    total = 0.0
    for i in range(len(worth.cells)):
        cell = worth.cells[i, 2]
        share = worth.mass[cell] * tree.factor[cell]
        north = worth.cells[i, 0] - row + rows - 1
        east = worth.cells[i, 1] - col + cols - 1
        total += share * worth.bound[heading, north, east]
    return total


@inlined
def _worth_of(ground: Ground, worth: Worth, tree: PathTree, node: int, move: int) -> float:
    """Return the worth of a move at a node whose child is there."""
    child = tree.child[node, move]
    later = worth.right * tree.gain[child] + tree.best[child]
    now = _cost(ground, worth, tree.pose[node], move, tree.left[node])
    return float(now + worth.powers[1] * later)


@inlined
def _allowed(ground: Ground, worth: Worth, tree: PathTree, node: int, move: int) -> bool:
    """Tell whether a move may lead anywhere new: no turning back, no step that is blocked."""
    if move == 0:
        return bool(worth.hit < 1.0 or ground.nexts[0, tree.pose[node]] != tree.pose[node])
    return bool(worth.hit < 1.0 or node == 0 or tree.move[node] + move != 3)


@jit
def explore(
    ground: Ground,
    worth: Worth,
    tree: PathTree,
    goals: NDArray[np.int32],
    fields: NDArray[np.int16],
    size: int,
    sims: int,
    hint: NDArray[np.int32],
) -> int:
    """Run simulations and return the number of nodes.

    Parameters
    ----------
    ground, worth : the map, and what counts.
    tree : the tree; node 0 is the root, with its pose, left and best set.
    goals, fields : poses worth driving to, shape (G,), and moves to each, shape (G, P).
    size : how many nodes the tree has.
    sims : how many simulations to run.
    hint : moves that the first simulations follow, such as the rest of the last plan.
    """
    for sim in range(sims):
        node, level, logged = 0, 0, 0
        while level < worth.depth:
            move, bound = -1, -math.inf
            if sim < len(hint) and level < len(hint) and level <= sim:
                move = hint[level]
            else:
                log_visits = math.log(tree.visits[node] + 1.0)
                scale = worth.exploration * min(tree.left[node], 1.0)
                for m in range(3):
                    if not _allowed(ground, worth, tree, node, m):
                        continue
                    child = tree.child[node, m]
                    if child < 0:
                        move = m
                        break
                    bonus = scale * math.sqrt(log_visits / tree.visits[child])
                    value = _worth_of(ground, worth, tree, node, m) + bonus
                    if value > bound:
                        move, bound = m, value
            if move < 0:
                break
            child = tree.child[node, move]
            level += 1
            if child >= 0:
                _, logged = _look(ground, worth, tree, tree.pose[child], logged)
                node = child
                continue
            child, size = size, size + 1
            pose = ground.nexts[move, tree.pose[node]]
            gain, logged = _look(ground, worth, tree, pose, logged)
            tree.child[node, move] = child
            tree.pose[child], tree.parent[child], tree.move[child] = pose, node, move
            tree.gain[child], tree.left[child] = gain, tree.left[node] - gain
            value = 0.0
            if worth.hindsight > 0.0:
                value = worth.hindsight * _know(worth, tree, pose)
            if worth.hindsight < 1.0:
                walked, logged = _walk(
                    ground, worth, tree, goals, fields, pose, tree.left[child], level, logged
                )
                value += (1.0 - worth.hindsight) * walked
            tree.best[child] = value
            node = child
            break
        tree.visits[node] += 1
        while node > 0:
            node = tree.parent[node]
            tree.visits[node] += 1
            best = -math.inf
            for m in range(3):
                if tree.child[node, m] >= 0:
                    best = max(best, _worth_of(ground, worth, tree, node, m))
            tree.best[node] = best
        for i in range(logged - 1, -1, -1):
            tree.factor[tree.log[i]] = tree.old[i]
    return size
