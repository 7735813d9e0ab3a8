"""A whole published rollout of the search in machine code, with the pose at hand."""

from __future__ import annotations

from sloop_ppl.planning.compile import jit
from sloop_ppl.planning.native import roll_out, uniform
from sloop_ppl.planning.native_data import SearchData
from sloop_ppl.planning.native_rules import (
    CELLS,
    COL,
    FINDS,
    FOUND,
    HEADING,
    ROW,
    SEEN,
    Random,
    State,
    find,
)
from sloop_ppl.planning.pose import HEADINGS

__all__ = ["rollout"]


@jit
def rollout(
    data: SearchData, state: State, level: int, depth: int, discount: float, random: Random
) -> float:
    """Return the discounted return of a rollout: `policy` and `step` with the pose at hand.

    Without noise a find of what was seen is right, which saves half of the work.
    """
    if data.published == 0 or data.hit < 1.0 or data.false > 0.0 or data.sigma > 0.0:
        return roll_out(data, state, level, depth, discount, random)
    row, col, heading = state[ROW], state[COL], state[HEADING]
    found, finds, seen = state[FOUND], state[FINDS], state[SEEN]
    total, weight = 0.0, 1.0
    walled = len(data.blocked) > 0
    covered = len(data.hidden) > 0
    while level < depth:
        if seen > 0:
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
        dr, dc = data.steps[heading, 0], data.steps[heading, 1]
        new_row, new_col = row + dr, col + dc
        free = 0 <= new_row < data.n_rows and 0 <= new_col < data.n_cols
        hit_wall = False
        if walled and free:
            hit_wall = data.blocked[(row * data.n_cols + col) * HEADINGS + heading]
            free = not hit_wall
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
            right |= right_x * north - right_y * east < -1e-9
        if forward + left + right == 0:
            forward, left, right = 1, 1, 1
        wanted = int(uniform(random) * (forward + left + right))
        reward = data.move
        if wanted < forward:
            if free:
                row, col = new_row, new_col
            elif hit_wall:
                reward = data.collision
        elif wanted < forward + left:
            heading = (heading + data.turn) & 7
        else:
            heading = (heading - data.turn) & 7
        total += weight * reward
        weight *= discount
        level += 1
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
