"""The rules of the search, and what holds of all poses at once, as arrays made of the search space.

Legend: A = 3 moves; O outcomes of a move; K cells of the largest fan; R largest offset in a fan;
P poses, numbered ``(row * W + column) * 8 + heading``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning.pose import HEADINGS
from sloop_ppl.planning.sensors import MaskSensor
from sloop_ppl.planning.space import SearchSpace

__all__ = [
    "Reach",
    "SearchData",
    "blocked_moves",
    "hidden_cells",
    "likeliest_poses",
    "next_poses",
    "reach_from",
    "reach_of",
    "search_data",
    "visible_mass",
]


class SearchData(NamedTuple):
    """What the functions of the search's domain know; the types are the same for all settings.

    Attributes
    ----------
    n_rows, n_cols, n_targets, max_finds, n_finds
        Numbers of what their names say; `n_finds` is that of the find actions.
    reach
        R.
    n_outcomes
        O.
    offsets
        Rows north, columns east and eighths of a turn of each outcome, by ``(move * 8 + heading) *
        O + outcome``, shape (A * 8 * O, 3).
    chance
        Probability of each outcome, most probable first, shape (A * 8 * O,).
    blocked
        True where a no-fly building stops an outcome at a pose, shape (A, O, P) or (0, 0, 0).
    fan
        One plus the place of an offset in its fan, else 0, shape (8, 2 R + 1, 2 R + 1).
    fans, fan_sizes
        Offsets of each fan, shape (8, K, 2), and how many there are, (8,).
    hidden
        True where a place of the fan is hidden from a pose, shape (P, K) or (0, 0).
    aim
        Directions, as x and y, that a target must be anticlockwise of for a left turn to turn
        towards it, and for a right turn, by heading, shape (8, 2, 2).
    move, right, wrong, collision
        Rewards of a move, a right find, a wrong find, and a move that is stopped by a building.
    hit, false, sigma
        True positive rate, false positive rate, and noise of the reported cell in cells.
    published
        1 for the published rollout, 0 for the random one.
    steps
        Rows and columns of the most probable step forward by heading, shape (8, 2).
    plain
        1 where moves have one outcome each, the step no turn, the turns no step, and turns are the
        same from all headings, namely `left_turn` and `right_turn` eighths.
    """

    n_rows: int
    n_cols: int
    n_targets: int
    max_finds: int
    n_finds: int
    reach: int
    n_outcomes: int
    offsets: NDArray[np.int64]
    chance: NDArray[np.float64]
    blocked: NDArray[np.bool_]
    fan: NDArray[np.int32]
    fans: NDArray[np.int64]
    fan_sizes: NDArray[np.int64]
    hidden: NDArray[np.bool_]
    aim: NDArray[np.float64]
    move: float
    right: float
    wrong: float
    collision: float
    hit: float
    false: float
    sigma: float
    published: int
    steps: NDArray[np.int64]
    plain: int
    left_turn: int
    right_turn: int


def reach_of(space: SearchSpace) -> int:
    """Return R, how far the sensor sees in whole cells."""
    return max((max(abs(r), abs(c)) for fan in space.fans for r, c in fan), default=0)


def search_data(space: SearchSpace) -> SearchData:
    """Return a search space as arrays."""
    config = space.config
    offsets, chance = space.move_table.offsets, space.move_table.chance
    sensor = space.sensor
    if not isinstance(sensor, MaskSensor):
        raise TypeError(f"sensor {type(sensor).__name__} sees no mask")
    most, reach = max(len(fan) for fan in space.fans), reach_of(space)
    fan = np.zeros((HEADINGS, 2 * reach + 1, 2 * reach + 1), dtype=np.int32)
    fans = np.zeros((HEADINGS, most, 2), dtype=np.int64)
    for heading, cells in enumerate(space.fans):
        for place, (row, col) in enumerate(cells):
            # + 1, so that 0 says that an offset is not in view.
            fan[heading, row + reach, col + reach] = place + 1
            fans[heading, place] = row, col
    # What the quick rollout needs to know: one outcome, pure steps, turns alike from all headings.
    turns = offsets[1:, :, 0, 2]
    even = (turns == turns[:, :1]).all()
    still = not offsets[0, ..., 2].any() and not offsets[1:, ..., :2].any()
    return SearchData(
        n_rows=space.n_rows,
        n_cols=space.n_cols,
        n_targets=len(space.target_ids),
        max_finds=space.max_finds,
        n_finds=len(space.finds),
        reach=reach,
        n_outcomes=offsets.shape[2],
        offsets=offsets.reshape(-1, 3),
        chance=chance.ravel(),
        blocked=blocked_moves(space),
        fan=fan,
        fans=fans,
        fan_sizes=np.array([len(f) for f in space.fans], dtype=np.int64),
        hidden=hidden_cells(space),
        aim=_aim(offsets),
        move=float(config.move_reward),
        right=float(config.right_find_reward),
        wrong=float(config.wrong_find_reward),
        collision=float(config.collision_reward),
        hit=float(sensor.true_positive_rate),
        false=float(sensor.false_positive_rate),
        sigma=float(sensor.position_noise_cells),
        published=int(config.rollout != "random"),
        steps=np.ascontiguousarray(offsets[0, :, 0, :2]),
        plain=int(offsets.shape[2] == 1 and still and even),
        left_turn=int(turns[0, 0]),
        right_turn=int(turns[1, 0]),
    )


def next_poses(
    shape: tuple[int, int],
    offsets: NDArray[np.int64],
    blocked: NDArray[np.bool_] | None = None,
) -> NDArray[np.int32]:
    """Return the pose after each move from each pose, shape (A, P).

    Parameters
    ----------
    shape
        Rows and columns of the map; a move that leaves it leaves the pose.
    offsets
        Rows, columns and eighths of a turn of each move by heading, shape (A, 8, 3).
    blocked
        Where a move leaves the pose because of a building, shape (A, P); nowhere when None.
    """
    rows, cols = shape
    # int32 holds the poses of 16,000 x 16,000 cells at half the memory traffic of int64.
    poses = np.arange(rows * cols * HEADINGS, dtype=np.int32)
    nexts = np.empty((len(offsets), rows, cols, HEADINGS), dtype=np.int32)
    here = poses.reshape(rows, cols, HEADINGS)
    for move in range(len(offsets)):
        for heading in range(HEADINGS):
            dr, dc, turn = offsets[move, heading].tolist()
            row = np.arange(rows, dtype=np.int32)[:, None] + dr
            col = np.arange(cols, dtype=np.int32)[None, :] + dc
            inside = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
            there = (row * cols + col) * HEADINGS + (heading + turn) % HEADINGS
            nexts[move, :, :, heading] = np.where(inside, there, here[:, :, heading])
    flat = nexts.reshape(len(offsets), -1)
    return flat if blocked is None else np.where(blocked, poses, flat)


def _aim(offsets: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the direction half way to each turn, turned round for turns clockwise."""
    # A turn clockwise is written as 5 to 7 eighths; half of it must be counted the short way.
    turn = (offsets[1:, :, 0, 2] + 4) % HEADINGS - 4  # eighths in [-4, 4), shape (2, 8)
    angle = (np.arange(HEADINGS) + turn / 2).T * 2 * np.pi / HEADINGS
    sign = np.sign(turn).T[..., None]
    return np.ascontiguousarray(sign * np.stack([np.cos(angle), np.sin(angle)], axis=-1))


def hidden_cells(space: SearchSpace) -> NDArray[np.bool_]:
    """Return which places of the fan are not in view from a pose, shape (P, K) or (0, 0)."""
    if not space.hides:
        return np.zeros((0, 0), dtype=bool)
    most = max(len(fan) for fan in space.fans)
    hidden = np.zeros((space.n_cells * HEADINGS, most), dtype=bool)
    fans = [np.array(fan, dtype=np.intp).reshape(-1, 2).T for fan in space.fans]
    reach = reach_of(space)
    # a border as wide as the sensor sees, so that each offset has a cell
    wide = np.zeros((space.n_rows + 2 * reach, space.n_cols + 2 * reach), dtype=bool)
    inner = wide[reach : reach + space.n_rows, reach : reach + space.n_cols]
    for pose in range(len(hidden)):
        row, col, heading = space.decode(pose)
        inner[:] = space.view_mask(space.pose_at(pose))
        rows, cols = fans[heading]
        hidden[pose, : len(rows)] = ~wide[row + reach + rows, col + reach + cols]
    return hidden


def blocked_moves(space: SearchSpace) -> NDArray[np.bool_]:
    """Return which outcomes of moves hit a no-fly building, shape (A, O, P) or (0, 0, 0)."""
    if not space.no_fly:
        return np.zeros((0, 0, 0), dtype=bool)
    offsets, n_poses = space.move_table.offsets, space.n_cells * HEADINGS
    blocked = np.zeros((len(offsets), offsets.shape[2], n_poses), dtype=bool)
    for move, heading, outcome in np.ndindex(*offsets.shape[:3]):
        rows, cols, _ = offsets[move, heading, outcome].tolist()
        # A turn on the spot hits nothing.
        if rows or cols:
            for pose in range(heading, n_poses, HEADINGS):
                blocked[move, outcome, pose] = space.blocks(pose, rows, cols)
    return blocked


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


def likeliest_poses(space: SearchSpace) -> NDArray[np.int32]:
    """Return the most probable pose after each move from each pose, shape (A, P)."""
    blocked = blocked_moves(space)[:, 0] if space.no_fly else None
    return next_poses(space.shape, space.move_table.offsets[:, :, 0], blocked)


def reach_from(pose: int, nexts: NDArray[np.int32]) -> Reach:
    """Return the fewest moves from one pose to every other, by breadth-first search.

    `nexts` is what `likeliest_poses` returned.
    """
    steps = np.full(nexts.shape[1], -1, dtype=np.int32)
    first = np.zeros(nexts.shape[1], dtype=np.int8)
    frontier, where = np.unique(nexts[:, pose], return_index=True)
    label = where.astype(np.int8)
    depth = 1
    while frontier.size:
        # Sorted by first move, np.unique keeps of equal poses the one with the earlier action.
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
    """Return the expected number of targets in view from each pose, shape (P,).

    `tables` are the beliefs of the targets to count, each of shape (H * W,).
    """
    if space.hides:
        total = np.sum(tables, axis=0)
        return np.array(
            [total[list(space.view(pose))].sum() for pose in range(space.n_cells * HEADINGS)]
        )
    reach = reach_of(space)
    # One shifted sum of the whole map for each place in the fan instead of one sum per pose.
    padded = np.pad(np.sum(tables, axis=0).reshape(space.shape), reach)
    mass = np.zeros((*space.shape, HEADINGS))
    for heading, fan in enumerate(space.fans):
        for dr, dc in fan:
            mass[:, :, heading] += padded[
                reach + dr : reach + dr + space.n_rows, reach + dc : reach + dc + space.n_cols
            ]
    return mass.ravel()
