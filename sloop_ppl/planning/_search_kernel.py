"""The rules of the search in machine code: the same as the plain models', step by step.

Legend: N targets; S = 7 + 2 N numbers of a state.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning._compile import called, inlined, int64
from sloop_ppl.planning._native import (
    NativeFunctions,
    generic_rollout,
    register_native,
    uniform,
)
from sloop_ppl.planning._pomdp import Agent
from sloop_ppl.planning._search_tables import SearchData, search_data
from sloop_ppl.planning.belief import GridBelief
from sloop_ppl.planning.pose import HEADINGS
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import SearchObservation

__all__ = ["NativeSearch", "SearchBelief", "draw", "find", "in_view", "legal", "policy", "step"]

ROW, COL, HEADING, FOUND, FINDS, LOOKED, SEEN, CELLS = range(8)
"""Places in a state; from CELLS on come row and column of each target in turn. FOUND has one bit a
target; SEEN is the number of the first unfound target that was just reported, plus one, or zero."""

# A prime larger than the cells of most maps, by which the parts of a key are mixed.
_MIX = 1_000_003

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
    if place == 0:
        return False
    if len(data.hidden) == 0:
        return True
    pose = (state[ROW] * data.n_cols + state[COL]) * HEADINGS + state[HEADING]
    return not data.hidden[pose, place - 1]


@inlined
def draw(data: SearchData, belief: SearchBelief, state: State, random: Random) -> None:
    """Fill a state drawn from the belief."""
    for i in range(CELLS):
        state[i] = belief.robot[i]
    for i in range(data.n_targets):
        # The first cell whose cumulative belief exceeds u * total, u uniform: by bisection.
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
    """Return the bit mask of the actions that may be taken: a find only after a look."""
    if state[LOOKED]:
        return (1 << (3 + data.n_finds)) - 1
    return 0b111


@called
def _report(data: SearchData, state: State, row: int, col: int, random: Random) -> int:
    """Return the cell at which a noisy sensor reports a target, or -1."""
    at = -1
    if in_view(data, state, row, col) and uniform(random) < data.hit:
        at = row * data.n_cols + col
        if data.sigma > 0:
            at = _pick(data, state, row, col, data.sigma, random)
    elif data.false > 0 and uniform(random) < data.false:
        # Infinite sigma: all weights are exp(0) = 1, any cell in view is as likely.
        at = _pick(data, state, row, col, np.inf, random)
    return at


@called
def _pick(data: SearchData, state: State, row: int, col: int, sigma: float, random: Random) -> int:
    """Draw a cell in view with Gaussian weights around a cell; -1 when nothing is in view."""
    # w_k = exp(-d_k ** 2 / (2 sigma ** 2)). One pass: the k-th cell replaces the choice with
    # probability w_k / (w_1 + .. + w_k), which leaves each with w_k / (sum of all).
    at, total = -1, 0.0
    for k in range(data.fan_sizes[state[HEADING]]):
        r = state[ROW] + data.fans[state[HEADING], k, 0]
        c = state[COL] + data.fans[state[HEADING], k, 1]
        if 0 <= r < data.n_rows and 0 <= c < data.n_cols and in_view(data, state, r, c):
            square = (r - row) * (r - row) + (c - col) * (c - col)
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
    # The pose. An exact motion has one outcome, for which nothing is drawn.
    first = (action * HEADINGS + state[HEADING]) * data.n_outcomes
    outcome = 0
    if data.n_outcomes > 1:
        rest = uniform(random) - data.chance[first]
        while rest >= 0.0 and outcome < data.n_outcomes - 1:
            outcome += 1
            rest -= data.chance[first + outcome]
    row = state[ROW] + data.offsets[first + outcome, 0]
    col = state[COL] + data.offsets[first + outcome, 1]
    reward = data.move
    if 0 <= row < data.n_rows and 0 <= col < data.n_cols:  # else the robot stays where it is
        pose = (state[ROW] * data.n_cols + state[COL]) * HEADINGS + state[HEADING]
        if len(data.blocked) > 0 and data.blocked[action, outcome, pose]:
            reward = data.collision
        else:
            state[ROW], state[COL] = row, col
            state[HEADING] = (state[HEADING] + data.offsets[first + outcome, 2]) & 7
    # The look. The key of an observation is what was found, mixed with each target's report and,
    # where the motion is not exact, with the pose, which the robot knows.
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
        # + 2 makes -1, for not seen, and every cell a number above zero.
        key = key * _MIX + at + 2  # of up to two targets keys never clash
    if data.n_outcomes > 1:
        pose = (state[ROW] * data.n_cols + state[COL]) * HEADINGS + state[HEADING]
        key = key * _MIX + pose + 2
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
    # A find senses nothing: at = -1 for every target, of which -1 + 2 = 1 is mixed in.
    for _ in range(data.n_targets):
        key = key * _MIX + 1
    over = marks == (1 << data.n_targets) - 1 or state[FINDS] >= data.max_finds
    return reward, key, over


@inlined
def policy(data: SearchData, state: State, random: Random) -> int:
    """Return the next action of the published or the random rollout."""
    if data.published == 0:
        n = 3 + data.n_finds if state[LOOKED] else 3
        action: int = int64(uniform(random) * n)
        return action
    if state[SEEN] > 0:
        return 3 if data.n_finds == 1 else 2 + state[SEEN]
    heading = state[HEADING]
    dr, dc = data.steps[heading, 0], data.steps[heading, 1]
    row, col = state[ROW] + dr, state[COL] + dc
    pose = (state[ROW] * data.n_cols + state[COL]) * HEADINGS + heading
    free = 0 <= row < data.n_rows and 0 <= col < data.n_cols
    if len(data.blocked) > 0 and data.blocked[0, 0, pose]:
        free = False
    # A move is preferred when it serves some target at offset t = (east, north) that is left: the
    # step d when |t - d| < |t|, or 2 t.d > d.d; a turn when t lies beyond the direction a half way
    # to it, a x t > 0.
    mask = 0
    for i in range(data.n_targets):
        if state[FOUND] >> i & 1:
            continue
        north = state[CELLS + 2 * i] - state[ROW]
        east = state[CELLS + 2 * i + 1] - state[COL]
        if free and 2 * (north * dr + east * dc) > dr * dr + dc * dc:
            mask |= 1
        # 1e-9: a target exactly on the direction half way is left alone, whatever rounding does.
        if data.aim[heading, 0, 0] * north - data.aim[heading, 0, 1] * east > 1e-9:
            mask |= 2
        if data.aim[heading, 1, 0] * north - data.aim[heading, 1, 1] * east > 1e-9:
            mask |= 4
    if mask == 0:
        mask = 7
    # Which of the preferred moves, each as likely; mask >> 2 is 0 or 1.
    wanted = int64(uniform(random) * ((mask & 1) + (mask >> 1 & 1) + (mask >> 2)))
    for move in range(3):
        if mask >> move & 1:
            if wanted == 0:
                return move
            wanted -= 1
    return 0


def rollout(
    data: SearchData, state: State, level: int, depth: int, discount: float, random: Random
) -> float:
    """Return the discounted return of a rollout: `policy` and `step` with the pose at hand.

    Without noise a find of what was seen is right, and with plain moves the pose stays in
    registers, which saves half of the work.
    """
    noisy = data.hit < 1.0 or data.false > 0.0 or data.sigma > 0.0
    if data.published == 0 or noisy or data.plain == 0:
        return generic_rollout(data, state, level, depth, discount, random)
    row, col, heading = state[ROW], state[COL], state[HEADING]
    found, finds, seen = state[FOUND], state[FINDS], state[SEEN]
    total, weight = 0.0, 1.0
    walled = len(data.blocked) > 0
    covered = len(data.hidden) > 0
    while level < depth:
        if seen > 0:
            # What was seen is found, by the rule of finds.
            state[ROW], state[COL], state[HEADING] = row, col, heading
            state[FOUND], state[FINDS] = found, finds
            reward, _, over = find(data, state, 3 if data.n_finds == 1 else 2 + seen)
            total += weight * reward
            if over:
                return total
            found, finds, seen = state[FOUND], state[FINDS], 0
            weight *= discount
            level += 1
            continue
        # Which moves are preferred: as in `policy`.
        dr, dc = data.steps[heading, 0], data.steps[heading, 1]
        new_row, new_col = row + dr, col + dc
        free = 0 <= new_row < data.n_rows and 0 <= new_col < data.n_cols
        stopped = False
        if walled and free:
            stopped = data.blocked[0, 0, (row * data.n_cols + col) * HEADINGS + heading]
            free = not stopped
        left_x, left_y = data.aim[heading, 0, 0], data.aim[heading, 0, 1]
        right_x, right_y = data.aim[heading, 1, 0], data.aim[heading, 1, 1]
        far = dr * dr + dc * dc
        forward, left, right = 0, 0, 0
        for i in range(data.n_targets):
            if found >> i & 1:
                continue
            north = state[CELLS + 2 * i] - row
            east = state[CELLS + 2 * i + 1] - col
            forward |= free and 2 * (north * dr + east * dc) > far
            left |= left_x * north - left_y * east > 1e-9
            right |= right_x * north - right_y * east > 1e-9
        if forward + left + right == 0:
            forward, left, right = 1, 1, 1
        # One of them, each as likely, moves the robot: as in `step`.
        wanted = int64(uniform(random) * (forward + left + right))
        reward = data.move
        if wanted < forward:
            if free:
                row, col = new_row, new_col
            elif stopped:
                reward = data.collision
        elif wanted < forward + left:
            heading = (heading + data.left_turn) & 7
        else:
            heading = (heading + data.right_turn) & 7
        total += weight * reward
        weight *= discount
        level += 1
        # The first target in view, if there is one: as in `in_view`.
        for i in range(data.n_targets):
            if found >> i & 1 or seen > 0:
                continue
            north = state[CELLS + 2 * i] - row
            east = state[CELLS + 2 * i + 1] - col
            if -data.reach <= north <= data.reach and -data.reach <= east <= data.reach:
                place = data.fan[heading, north + data.reach, east + data.reach]
                if place > 0 and not (
                    covered
                    and data.hidden[(row * data.n_cols + col) * HEADINGS + heading, place - 1]
                ):
                    seen = i + 1
    return total


register_native(SearchData, NativeFunctions(draw, legal, step, policy, rollout))


class NativeSearch:
    """The search as a `NativeModel`."""

    def __init__(self, space: SearchSpace) -> None:
        self.space = space
        self.actions = space.actions
        self.state_size = CELLS + 2 * len(space.target_ids)
        self.data = search_data(space)

    def belief(self, agent: Agent) -> SearchBelief:
        """Return the agent's `GridBelief` as arrays."""
        grid: GridBelief = agent.belief
        seen = 0
        if agent.history:
            last: SearchObservation = agent.history[-1][1]
            unfound = (i for i, at in enumerate(last.seen) if at >= 0)
            seen = next(unfound, -1) + 1
        robot = grid.robot
        row, col = robot.cell
        numbers = (row, col, robot.heading, robot.found, robot.finds, int(robot.looked), seen)
        return SearchBelief(np.array(numbers, dtype=np.int64), np.cumsum(grid.flat, axis=1))

    def key(self, observation: SearchObservation) -> int:
        """Return the key that `step` gives for an observation."""
        key = observation.found
        for at in observation.seen:
            # Python does not overflow: masked to 64 bits here, and made signed at the end as int64.
            key = (key * _MIX + at + 2) & 0xFFFFFFFFFFFFFFFF
        if observation.pose >= 0:
            key = (key * _MIX + observation.pose + 2) & 0xFFFFFFFFFFFFFFFF
        return key - (1 << 64) if key >> 63 else key
