"""Search over paths in machine code: what a robot that sees nothing would do next.

Targets stand still, so a path tells beforehand what it will have shown, up to the moment at which
a target is seen. Its worth can therefore be added up from the belief, without drawing targets: a
move at step t costs while something is left to be found, and what comes into view is found one
step later. `explore` grows a tree of such paths; a leaf is worth what a belief-greedy walk earns
from there, and a node as much as the best that was found below it.

Legend: P poses; V nodes; G goals; K cells of the largest fan; R range of the sensor, rounded down.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.search.compile import inlined, jit

__all__ = ["Ground", "PathTree", "Worth", "explore", "flood", "look_around", "pick_goals"]


class Ground(NamedTuple):
    """Where moves lead and what is seen; the map has a border of R cells so that views fit.

    Attributes
    ----------
    nexts : pose after each move, shape (3, P).
    before : pose from which a step forward leads here, or -1, shape (P,).
    home : index of each pose's cell in the bordered map, shape (P,).
    fans : offsets of the fan's cells in the bordered map by heading, shape (8, K).
    sizes : how many they are, shape (8,).
    hidden : True where a place of the fan is hidden from a pose, shape (P, K) or (0, 0).
    collides : True where a step forward hits a no-fly building, shape (P,) or (0,).
    width : columns of the bordered map.
    turn : eighths of a turn that a turn goes.
    """

    nexts: NDArray[np.int32]
    before: NDArray[np.int32]
    home: NDArray[np.int32]
    fans: NDArray[np.int32]
    sizes: NDArray[np.int32]
    hidden: NDArray[np.bool_]
    collides: NDArray[np.bool_]
    width: int
    turn: int


class Worth(NamedTuple):
    """What counts: belief, rewards and horizon.

    Attributes
    ----------
    mass : expected number of targets by cell of the bordered map.
    hit : probability of detecting what is in view.
    move, collision, right : rewards.
    powers : the discount factor to the power 0, 1, ..., at least as many as steps of any path.
    horizon : steps to which a walk is followed.
    depth : steps to which the tree grows.
    exploration : weight of the exploration bonus.
    cells : row, column and index in the bordered map of the cells that hold the mass, shape (C, 3).
    bound : worth of one target at an offset, for who knows where it is, by heading, shape
        (8, 2 H - 1, 2 W - 1).
    hindsight : share of what one who knew the target's place would earn in the worth of a leaf.
    """

    mass: NDArray[np.float64]
    hit: float
    move: float
    collision: float
    right: float
    powers: NDArray[np.float64]
    horizon: int
    depth: int
    exploration: float
    cells: NDArray[np.int32]
    bound: NDArray[np.float32]
    hindsight: float


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
def _in_view(ground: Ground, worth: Worth, factor: NDArray[np.float64], pose: int) -> float:
    """Return the mass in view from a pose."""
    total, home, heading = 0.0, ground.home[pose], pose & 7
    for k in range(ground.sizes[heading]):
        if len(ground.hidden) > 0 and ground.hidden[pose, k]:
            continue
        cell = home + ground.fans[heading, k]
        total += worth.mass[cell] * factor[cell]
    return total


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
            score = worth.powers[far] * _in_view(ground, worth, tree.factor, goals[g])
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
                    shown = _in_view(ground, worth, tree.factor, after)
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
        seen[pose] = _in_view(ground, worth, factor, pose)


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
                    seen[pose] = _in_view(ground, worth, factor, pose)
    for cell in range(len(factor)):
        factor[cell] = 1.0
    return count
