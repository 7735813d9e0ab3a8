"""The greedy path: to the pose with the most discounted mass in view.

On maps of up to `NEAR_POSES` poses it is found by looking at every pose, breadth first; on larger
ones so are the poses of a window round the robot, and beyond it blocks of cells are looked at, the
way to which is estimated as if nothing stood in it.

Legend: P poses of the window; B blocks; G cells of the bordered map.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning._compile import inlined, int64, jit
from sloop_ppl.planning._path_map import Objective, PathMap, bordered_cell, next_pose
from sloop_ppl.planning._value_bound import ValueBound, moves_to, turns_to
from sloop_ppl.planning.pose import HEADINGS
from sloop_ppl.planning.space import SearchSpace

__all__ = ["NEAR_POSES", "Scouts", "greedy_path", "new_scouts"]

NEAR_POSES = 400_000
"""Poses that are looked at one by one: those of 223 x 223 cells."""


class Scouts(NamedTuple):
    """Room for the search of a greedy path.

    Attributes
    ----------
    steps, origin, queue
        How far each pose of the window is, from where and by which move it was reached, and the
        poses of the map in the order of finding, shape (P,).
    window
        First row and column of the window, which move with the robot, and its rows and columns.
    sums, most
        Sums over columns of cells, by column of the bordered map, and what a view in each block can
        hold at most, shape (B,); both are empty where the window is the map.
    """

    steps: NDArray[np.int32]
    origin: NDArray[np.int32]
    queue: NDArray[np.int32]
    window: NDArray[np.int64]
    sums: NDArray[np.float64]
    most: NDArray[np.float64]


def new_scouts(space: SearchSpace, n_blocks: int, reach: int) -> Scouts:
    """Return room for `greedy_path` on a map."""
    rows, cols = space.shape
    is_whole = space.n_cells * HEADINGS <= NEAR_POSES
    if not is_whole:
        side = math.isqrt(NEAR_POSES // HEADINGS)
        rows, cols = min(rows, side), min(cols, side)
    n_poses = rows * cols * HEADINGS
    return Scouts(
        steps=np.empty(n_poses, dtype=np.int32),
        origin=np.empty(n_poses, dtype=np.int32),
        queue=np.empty(n_poses, dtype=np.int32),
        window=np.array([0, 0, rows, cols], dtype=np.int64),
        sums=np.zeros(0 if is_whole else space.n_cols + 2 * reach),
        most=np.zeros(0 if is_whole else n_blocks),
    )


@inlined
def _view_mass(path_map: PathMap, objective: Objective, pose: int) -> float:
    """Return the sum of m over the view of a pose."""
    mass, centre, heading = 0.0, bordered_cell(path_map, pose), pose & 7
    for k in range(path_map.sizes[heading]):
        if len(path_map.hidden) == 0 or not path_map.hidden[pose, k]:
            mass += objective.mass[centre + path_map.fans[heading, k]]
    return mass


@inlined
def _place(path_map: PathMap, window: NDArray[np.int64], pose: int) -> int:
    """Return the number of a pose within the window, or -1 outside."""
    row = (pose >> 3) // path_map.n_cols - window[0]
    col = (pose >> 3) % path_map.n_cols - window[1]
    if row < 0 or row >= window[2] or col < 0 or col >= window[3]:
        return -1
    number: int = int64((row * window[3] + col) * 8 + (pose & 7))
    return number


@jit
def greedy_path(
    path_map: PathMap,
    objective: Objective,
    value_bound: ValueBound,
    start: int,
    scouts: Scouts,
    moves: NDArray[np.int64],
) -> int:
    """Fill in the moves to the pose with the most discounted mass in view; return how many.

    It is the path of the planner ``greedy``: to the first pose p, by number of moves n(p), that
    maximises ``discount ** (n(p) - 1) * sum of m over the view of p``, as far as `moves` goes.

    Notes
    -----
    On maps of more than `NEAR_POSES` poses, n(p) of a pose outside the window is an estimate, and
    the way there is turning towards it and going on: what stands in it is left out.
    """
    window = scouts.window
    # The robot in the middle, as far as the borders of the map allow.
    row, col = (start >> 3) // path_map.n_cols, (start >> 3) % path_map.n_cols
    window[0] = min(max(row - window[2] // 2, 0), path_map.n_rows - window[2])
    window[1] = min(max(col - window[3] // 2, 0), path_map.n_cols - window[3])
    # Breadth first: poses come off the queue in the order of n(p), and of equals the first wins.
    scouts.steps[:] = -1
    scouts.steps[_place(path_map, window, start)], scouts.queue[0] = 0, start
    head, tail, goal, best = 0, 1, start, 0.0
    discounted, steps = 1.0, 0
    is_over = False
    while head < tail:
        pose = int64(scouts.queue[head])
        here = _place(path_map, window, pose)
        head += 1
        if scouts.steps[here] > steps:
            steps += 1
            discounted *= objective.discount
            if discounted * objective.total <= best:  # no pose from here on can be better
                is_over = True
                break
        if pose != start:
            mass = _view_mass(path_map, objective, pose)
            # 1e-9: rounding of the sums of m must not prefer a later pose.
            if discounted * mass > best * (1 + 1e-9):
                goal, best = pose, discounted * mass
        for move in range(3):
            after = next_pose(path_map, move, pose)
            there = _place(path_map, window, after)
            if there >= 0 and scouts.steps[there] < 0:
                # Origin and move packed into one number, with room for 4 moves.
                scouts.steps[there], scouts.origin[there] = scouts.steps[here] + 1, 4 * pose + move
                scouts.queue[tail] = after
                tail += 1
    if not is_over and len(scouts.most) > 0:
        far = _far_goal(path_map, objective, value_bound, start, best, scouts)
        if far >= 0:
            return _way_to(path_map, value_bound, start, far, moves)
    length: int = int64(scouts.steps[_place(path_map, window, goal)])
    pose = goal
    for i in range(length - 1, -1, -1):  # from the goal back to the start
        origin = int64(scouts.origin[_place(path_map, window, pose)])
        if i < len(moves):
            moves[i] = origin % 4
        pose = origin // 4
    return length if length < len(moves) else len(moves)


@inlined
def _bound_views(
    path_map: PathMap, objective: Objective, value_bound: ValueBound, start: int, scouts: Scouts
) -> None:
    """Fill in at most how much discounted mass a view in each block can hold."""
    sums, most, reach = scouts.sums, scouts.most, path_map.reach
    width, side = path_map.n_cols + 2 * reach, 2 * reach + 1
    sums[:] = 0.0
    most[:] = 0.0
    # Every view lies within the square of (2 R + 1) ** 2 cells round its pose. The sums of the
    # squares slide: what comes in is added, what goes out is taken off.
    for row in range(path_map.n_rows + 2 * reach):
        square = 0.0
        for col in range(width):
            sums[col] += objective.mass[row * width + col]
            if row >= side:
                sums[col] -= objective.mass[(row - side) * width + col]
            square += sums[col]
            if col >= side:
                square -= sums[col - side]
            if row >= side - 1 and col >= side - 1:
                block = value_bound.block[(row - reach) * width + col - reach]
                most[block] = square if square > most[block] else most[block]
    row, col = (start >> 3) // path_map.n_cols, (start >> 3) % path_map.n_cols
    # A cell of a block is no nearer than its middle less half its diagonal.
    n_cells = path_map.n_rows * path_map.n_cols
    half = math.sqrt(n_cells / len(most)) + 1.0
    for block in range(len(most)):
        north = float(value_bound.blocks[block].row - row)
        east = float(value_bound.blocks[block].col - col)
        near = (math.sqrt(north * north + east * east) - half) / value_bound.estimate[1]
        most[block] *= objective.discount ** (near - 1.0 if near > 1.0 else 0.0)


@inlined
def _far_goal(
    path_map: PathMap,
    objective: Objective,
    value_bound: ValueBound,
    start: int,
    best: float,
    scouts: Scouts,
) -> int:
    """Return the pose outside the window that promises more than `best`, and the most; or -1."""
    _bound_views(path_map, objective, value_bound, start, scouts)
    most = scouts.most
    goal: int = int64(-1)
    first = int64(0)
    for block in range(len(most)):
        first = block if most[block] > most[first] else first
    # The most promising block first, so that few of the others have to be looked at.
    for others in range(2):
        for row in range(path_map.n_rows):
            for col in range(path_map.n_cols):
                pose = int64((row * path_map.n_cols + col) * 8)
                block = value_bound.block[bordered_cell(path_map, pose)]
                if (block == first) == (others == 1) or most[block] <= best * (1 + 1e-9):
                    continue
                if _place(path_map, scouts.window, pose) >= 0:
                    continue
                for heading in range(8):
                    mass = _view_mass(path_map, objective, pose + heading)
                    # The way is no shorter than none but the last move.
                    if mass <= best:
                        continue
                    n = _moves_between(path_map, value_bound, start, pose + heading)
                    value = objective.discount ** (n - 1.0 if n > 1.0 else 0.0) * mass
                    if value > best * (1 + 1e-9):
                        goal, best = pose + heading, value
    return goal


@inlined
def _moves_between(path_map: PathMap, value_bound: ValueBound, start: int, goal: int) -> float:
    """Return about how many moves it takes from a pose to another: turn, go, turn."""
    north = (goal >> 3) // path_map.n_cols - (start >> 3) // path_map.n_cols
    east = (goal >> 3) % path_map.n_cols - (start >> 3) % path_map.n_cols
    estimate = value_bound.estimate
    # The goal itself is to be reached, not to be in view.
    there = moves_to(estimate, start & 7, north, east) + estimate[0] / estimate[1]
    moves: float = there + turns_to(estimate[5 + (goal & 7)], goal & 7, north, east)
    return moves


@inlined
def _way_to(
    path_map: PathMap,
    value_bound: ValueBound,
    start: int,
    goal: int,
    moves: NDArray[np.int64],
) -> int:
    """Fill in moves towards a pose, turning towards it and going on; return how many."""
    pose, estimate = start, value_bound.estimate
    length: int = int64(0)
    goal_row, goal_col = (goal >> 3) // path_map.n_cols, (goal >> 3) % path_map.n_cols
    goes = False
    while length < len(moves):
        heading, chosen = pose & 7, int64(0)
        north = goal_row - (pose >> 3) // path_map.n_cols
        east = goal_col - (pose >> 3) % path_map.n_cols
        squared = float(north * north + east * east)
        # Once on its way it goes on until the goal is an eighth of a turn off, and straight on from
        # there after one turn: turning sooner, it would have to turn back.
        angle = heading * (2 * math.pi / HEADINGS)
        along = math.cos(angle) * east + math.sin(angle) * north
        if not (goes and along * math.sqrt(2.0) > math.sqrt(squared) * (1 + 1e-9)):
            least = turns_to(estimate[5 + heading], heading, north, east)
            for move in (1, 2):
                after = next_pose(path_map, move, pose) & 7
                left = turns_to(estimate[5 + after], after, north, east)
                if left < least:
                    chosen, least = move, left
        after = next_pose(path_map, chosen, pose)
        goes = chosen == 0
        if goes:
            # A step that goes no nearer: it has passed the goal, or something stands in the way.
            north = goal_row - (after >> 3) // path_map.n_cols
            east = goal_col - (after >> 3) % path_map.n_cols
            if float(north * north + east * east) >= squared:
                break
        moves[length] = chosen
        pose, length = after, length + 1
    return length
