"""The rules of the search in machine code: the same as the plain models', step by step.

Legend: N targets.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning.compile import inlined, jit
from sloop_ppl.planning.native import uniform
from sloop_ppl.planning.native_data import SearchData
from sloop_ppl.planning.pose import HEADINGS

__all__ = ["SearchBelief", "draw", "find", "in_view", "legal", "policy", "step"]

ROW, COL, HEADING, FOUND, FINDS, LOOKED, SEEN, CELLS = range(8)
"""Places in a state; from CELLS on come row and column of each target in turn. SEEN is the number
of the first unfound target that was just reported, plus one, or zero."""

State = NDArray[np.int64]
Random = NDArray[np.uint64]


class SearchBelief(NamedTuple):
    """The robot's part of the state, shape (7,), and cumulative beliefs, shape (N, H * W)."""

    robot: NDArray[np.int64]
    cumulative: NDArray[np.float64]


@inlined
def in_view(data: SearchData, state: State, row: int, col: int) -> bool:
    """Tell whether a cell is in view from the robot's pose."""
    dr, dc = row - state[ROW], col - state[COL]
    if dr < -data.reach or dr > data.reach or dc < -data.reach or dc > data.reach:
        return False
    place = data.fan[state[HEADING], dr + data.reach, dc + data.reach]
    if place == 0 or len(data.hidden) == 0:
        return bool(place > 0)
    pose = (state[ROW] * data.n_cols + state[COL]) * HEADINGS + state[HEADING]
    return bool(not data.hidden[pose, place - 1])


@inlined
def draw(data: SearchData, belief: SearchBelief, state: State, random: Random) -> None:
    """Fill a state drawn from the belief."""
    for i in range(CELLS):
        state[i] = belief.robot[i]
    for i in range(data.n_targets):
        total = belief.cumulative[i]
        wanted = uniform(random) * total[-1]
        low, high = 0, len(total) - 1
        while low < high:
            middle = (low + high) // 2
            if total[middle] > wanted:
                high = middle
            else:
                low = middle + 1
        state[CELLS + 2 * i] = low // data.n_cols
        state[CELLS + 2 * i + 1] = low % data.n_cols


@inlined
def legal(data: SearchData, state: State) -> int:
    """Return the actions that may be taken: a find only after a look."""
    if state[LOOKED]:
        return (1 << (3 + data.n_finds)) - 1
    return 0b111


@jit
def _report(data: SearchData, state: State, row: int, col: int, random: Random) -> int:
    """Return the cell at which a noisy sensor reports a target, or -1."""
    at = -1
    if in_view(data, state, row, col) and uniform(random) < data.hit:
        at = row * data.n_cols + col
        if data.sigma > 0:
            at = _pick(data, state, row, col, data.sigma, random)
    elif data.false > 0 and uniform(random) < data.false:
        at = _pick(data, state, row, col, np.inf, random)
    return at


@jit
def _pick(data: SearchData, state: State, row: int, col: int, sigma: float, random: Random) -> int:
    """Draw a cell in view with Gaussian weights around a cell; -1 when nothing is in view."""
    at, total = -1, 0.0
    for k in range(data.fan_sizes[state[HEADING]]):
        r = state[ROW] + data.fans[state[HEADING], k, 0]
        c = state[COL] + data.fans[state[HEADING], k, 1]
        if 0 <= r < data.n_rows and 0 <= c < data.n_cols and in_view(data, state, r, c):
            square = float((r - row) ** 2 + (c - col) ** 2)
            weight = math.exp(-square / (2.0 * sigma * sigma))
            total += weight
            if uniform(random) * total < weight:
                at = r * data.n_cols + c
    return at


@inlined
def step(data: SearchData, state: State, action: int, random: Random) -> tuple[float, int, bool]:
    """Change the state by an action and return reward, key of the observation, and the end."""
    state[SEEN] = 0
    if action >= 3:
        return find(data, state, action)
    reward = data.move
    if action == 0:
        row = state[ROW] + data.steps[state[HEADING], 0]
        col = state[COL] + data.steps[state[HEADING], 1]
        if 0 <= row < data.n_rows and 0 <= col < data.n_cols:
            pose = (state[ROW] * data.n_cols + state[COL]) * HEADINGS + state[HEADING]
            if len(data.blocked) > 0 and data.blocked[pose]:
                reward = data.collision
            else:
                state[ROW], state[COL] = row, col
    elif action == 1:
        state[HEADING] = (state[HEADING] + data.turn) & 7
    else:
        state[HEADING] = (state[HEADING] - data.turn) & 7
    state[LOOKED] = 1
    noisy = data.hit < 1.0 or data.false > 0.0 or data.sigma > 0.0
    key = state[FOUND]
    for i in range(data.n_targets):
        at = -1
        if not state[FOUND] >> i & 1:
            row, col = state[CELLS + 2 * i], state[CELLS + 2 * i + 1]
            if noisy:
                at = _report(data, state, row, col, random)
            elif in_view(data, state, row, col):
                at = row * data.n_cols + col
            if at >= 0 and state[SEEN] == 0:
                state[SEEN] = i + 1
        key = _mix(key, at)
    return reward, key, False


@inlined
def find(data: SearchData, state: State, action: int) -> tuple[float, int, bool]:
    """Change the state by a find; return as `step` does."""
    marks = state[FOUND]
    if state[LOOKED]:
        for i in range(data.n_targets):
            if (data.n_finds == 1 or action == 3 + i) and in_view(
                data, state, state[CELLS + 2 * i], state[CELLS + 2 * i + 1]
            ):
                marks |= 1 << i
    reward = data.right if marks != state[FOUND] else data.wrong
    state[FOUND] = marks
    state[FINDS] += 1
    key = marks
    for _ in range(data.n_targets):
        key = _mix(key, -1)
    over = marks == (1 << data.n_targets) - 1 or state[FINDS] >= data.max_finds
    return reward, key, over


@inlined
def _mix(key: int, at: int) -> int:
    """Return the key with one more target's report; keys of up to two targets never clash."""
    return int(np.int64(key) * np.int64(1_000_003) + np.int64(at) + np.int64(2))


@inlined
def policy(data: SearchData, state: State, random: Random) -> int:
    """Return the next action of the published or the random rollout."""
    if data.published == 0:
        n = 3 + data.n_finds if state[LOOKED] else 3
        return int(uniform(random) * n)
    if state[SEEN] > 0:
        return 3 if data.n_finds == 1 else 2 + state[SEEN]
    heading = state[HEADING]
    dr, dc = data.steps[heading, 0], data.steps[heading, 1]
    row, col = state[ROW] + dr, state[COL] + dc
    pose = (state[ROW] * data.n_cols + state[COL]) * HEADINGS + heading
    free = 0 <= row < data.n_rows and 0 <= col < data.n_cols
    if len(data.blocked) > 0 and data.blocked[pose]:
        free = False
    mask = 0
    for i in range(data.n_targets):
        if state[FOUND] >> i & 1:
            continue
        north = state[CELLS + 2 * i] - state[ROW]
        east = state[CELLS + 2 * i + 1] - state[COL]
        if free and 2 * (north * dr + east * dc) > dr * dr + dc * dc:
            mask |= 1
        if data.aim[heading, 0, 0] * north - data.aim[heading, 0, 1] * east > 1e-9:
            mask |= 2
        if data.aim[heading, 1, 0] * north - data.aim[heading, 1, 1] * east < -1e-9:
            mask |= 4
    if mask == 0:
        mask = 7
    wanted = int(uniform(random) * ((mask & 1) + (mask >> 1 & 1) + (mask >> 2)))
    for action in range(3):
        if mask >> action & 1:
            if wanted == 0:
                return action
            wanted -= 1
    return 0
