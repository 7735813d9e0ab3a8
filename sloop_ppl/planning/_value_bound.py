"""An upper estimate of what can still be earned from a pose, by the mass that is left.

``V(p) = sum over blocks b of M_b * v(p, b)``: cells are gathered into blocks b, whose mass M_b
counts as if it were at their middle, and v is the clairvoyant bound, what one target is worth to
a robot that knows where it is. Where there are no-fly buildings it is the obstacle-aware bound. The
sum is taken once per pose and kept; what a path has detected is taken off it by the path search.

Legend: P poses; B blocks; G cells of the bordered map.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning._clairvoyant import (
    STRETCH,
    Origins,
    are_counted,
    clairvoyant_bounds,
    estimate_numbers,
    known_value,
    origins_of,
    rewards_of,
)
from sloop_ppl.planning._compile import inlined, int64, jit
from sloop_ppl.planning._path_map import PathMap, bordered_cell
from sloop_ppl.planning._search_tables import likeliest_poses, reach_of
from sloop_ppl.planning.pose import HEADINGS
from sloop_ppl.planning.space import SearchSpace

__all__ = [
    "ValueBound",
    "bound_from",
    "estimated_bound",
    "moves_to",
    "set_mass",
    "target_bound",
    "turns_to",
    "value_bound_of",
]

BLOCKS = 500
"""How many blocks of cells there may be."""

CHANGED = 64
"""Blocks that may have changed for the sums to be mended, not taken anew."""

AROUND_BYTES = 32 * 2**20
"""Room for the obstacle-aware bounds of each block from each pose."""

BLOCK = np.dtype([("row", np.int64), ("col", np.int64), ("mass", np.float64)])
"""The middle of a block, and the expected number of targets M_b in it."""

TAKEN = np.dtype([("sum", np.float64), ("pose", np.int32), ("known", np.bool_)], align=True)
"""At a pose: V, and whether it is known. `pose` is a list apart, of the poses where it is."""

_EIGHTH = 2 * math.pi / HEADINGS
_TAN_SIXTEENTH = math.tan(_EIGHTH / 2)

_NOTHING = 1e-12

_NONE = np.zeros((0, 0, 0), dtype=np.float32)
_NONE.flags.writeable = False  # as the tables are, of which there is one for all searches


class ValueBound(NamedTuple):
    """Mass by block, and what it promises.

    Attributes
    ----------
    bound
        Clairvoyant bound of one target at an offset, by heading, shape (8, 2 H - 1, 2 W - 1); on
        maps whose ways are estimated, not counted, (0, 0, 0): there it is reckoned when needed.
    estimate
        What it is reckoned from, see `estimate_numbers`, shape (13,).
    around
        Obstacle-aware bound by pose and block where there are no-fly buildings, shape (P, B) or
        (0, 0).
    block
        Block of each cell of the bordered map, shape (G,).
    blocks
        Array of `BLOCK`, shape (B,).
    taken, n_taken
        Array of `TAKEN`, shape (P,), and how many sums are known, shape (1,).
    """

    bound: NDArray[np.float32]
    estimate: NDArray[np.float64]
    around: NDArray[np.float32]
    block: NDArray[np.int32]
    blocks: NDArray[Any]
    taken: NDArray[Any]
    n_taken: NDArray[np.int64]


def value_bound_of(space: SearchSpace, path_map: PathMap) -> ValueBound:
    """Return the value bound of a map that holds nothing yet."""
    reach, n_poses = reach_of(space), space.n_cells * HEADINGS
    # float32 takes 4 bytes: P * B of them fit into AROUND_BYTES.
    most = max(min(BLOCKS, AROUND_BYTES // (4 * n_poses)), 1) if space.no_fly else BLOCKS
    # Square blocks of side**2 cells; ceil, so that there are no more than `most` of them.
    side = max(math.ceil(math.sqrt(space.n_cells / most)), 1)
    across = -(-space.n_cols // side)
    row = np.arange(space.n_rows + 2 * reach, dtype=np.int32) - reach
    col = np.arange(space.n_cols + 2 * reach, dtype=np.int32) - reach
    # Cells of the border, which hold no mass, count to the nearest block.
    inside_row, inside_col = row.clip(0, space.n_rows - 1), col.clip(0, space.n_cols - 1)
    block = (inside_row[:, None] // side * across + inside_col // side).ravel()
    middle_row, middle_col = np.mgrid[: -(-space.n_rows // side), :across] * side + side // 2
    blocks = np.zeros(middle_row.size, dtype=BLOCK)
    blocks["row"] = middle_row.clip(max=space.n_rows - 1).ravel()
    blocks["col"] = middle_col.clip(max=space.n_cols - 1).ravel()
    return ValueBound(
        bound=clairvoyant_bounds(space) if are_counted(space) else _NONE,
        estimate=estimate_numbers(space),
        around=_around_obstacles(space, path_map, block),
        block=block,
        blocks=blocks,
        taken=np.zeros(n_poses, dtype=TAKEN),
        n_taken=np.zeros(1, dtype=np.int64),
    )


@inlined
def estimated_bound(estimate: NDArray[np.float64], heading: int, north: int, east: int) -> float:
    """Return what one target at an offset is worth; see `estimate_moves` and `known_value`."""
    steps = STRETCH * moves_to(estimate, heading, north, east)
    discount = estimate[4]
    weight = math.exp(steps * math.log(discount))
    spent = (1.0 - weight) / (1.0 - discount) if discount < 1.0 else steps
    # As in the tables, which are float32.
    return float(np.float32(estimate[2] * spent + weight * estimate[3]))


@inlined
def moves_to(estimate: NDArray[np.float64], heading: int, north: int, east: int) -> float:
    """Return about how many moves it takes until an offset is in view: turn, then go."""
    far = math.sqrt(float(north * north + east * east)) - estimate[0]
    turns = turns_to(estimate[5 + heading], heading, north, east)
    return (far / estimate[1] if far > 0.0 else 0.0) + turns


@inlined
def turns_to(turn_rad: float, heading: int, north: int, east: int) -> float:
    """Return how many turns it takes to face an offset, or to leave a heading for it."""
    if turn_rad == _EIGHTH:
        # The eighth of a turn that is nearest to the bearing, without its arc tangent; no whole
        # numbers of cells lie on the border of two.
        eighth, n, e = int64(1), abs(north), abs(east)
        if n <= _TAN_SIXTEENTH * e:
            eighth = int64(0)
        elif e <= _TAN_SIXTEENTH * n:
            eighth = int64(2)
        eighth = 4 - eighth if east < 0 else eighth
        off = ((-eighth if north < 0 else eighth) - heading) & 7
        return float(off if off < 4 else 8 - off)
    angle = math.atan2(float(north), float(east)) - heading * _EIGHTH
    # The bearing is in (-pi, pi], the heading in [0, 2 pi).
    return float(round(abs(angle + 2 * math.pi if angle < -math.pi else angle) / turn_rad))


@inlined
def target_bound(value_bound: ValueBound, block: int, pose: int, row: int, col: int) -> float:
    """Return v(p, b), what one target in a block is worth from a pose, at `row` and `col`."""
    if len(value_bound.around) > 0:
        value: float = value_bound.around[pose, block]
    elif len(value_bound.bound) == 0:
        middle = value_bound.blocks[block]
        value = estimated_bound(value_bound.estimate, pose & 7, middle.row - row, middle.col - col)
    else:
        bound, middle = value_bound.bound, value_bound.blocks[block]
        # Offsets run from 1 - H to H - 1; the middle of the table is offset 0.
        north = middle.row - row + (bound.shape[1] - 1) // 2
        east = middle.col - col + (bound.shape[2] - 1) // 2
        value = bound[pose & 7, north, east]
    return value


@inlined
def bound_from(value_bound: ValueBound, pose: int, n_cols: int) -> float:
    """Return V(p), what all of the mass promises from a pose."""
    here = value_bound.taken[pose]
    # Summed when first asked for: of the 8 H W poses a search visits few.
    if not here.known:
        row, col = (pose >> 3) // n_cols, (pose >> 3) % n_cols
        total = 0.0
        for block in range(len(value_bound.blocks)):
            mass = value_bound.blocks[block].mass
            if mass > 0.0:
                total += mass * target_bound(value_bound, block, pose, row, col)
        here.sum, here.known = total, True
        value_bound.taken[value_bound.n_taken[0]].pose = pose
        value_bound.n_taken[0] += 1
    value: float = here.sum
    return value


@jit
def set_mass(value_bound: ValueBound, mass: NDArray[np.float64], n_cols: int) -> None:
    """Take other masses of the blocks, shape (B,); sums are kept where few changed but by a factor.

    After a look that showed nothing, all of the belief grows by one factor except in the few
    blocks in view. So ``V' = factor * V + sum over those blocks of (M'_b - factor * M_b) v(p, b)``.
    """
    blocks, taken = value_bound.blocks, value_bound.taken
    scale, changed = 0.0, 0
    for block in range(len(mass)):
        # The factor is the largest ratio: blocks in view have lost mass, others have grown alike.
        if blocks[block].mass > _NOTHING:
            ratio = mass[block] / blocks[block].mass
            scale = ratio if ratio > scale else scale
    for block in range(len(mass)):
        blocks[block].mass *= scale
        gap = mass[block] - blocks[block].mass
        changed += gap > _NOTHING or gap < -_NOTHING
    # A factor far from 1 would let the rounding of the mended sums grow; scale 0: all was empty.
    if changed > CHANGED or scale == 0.0 or not 1e-3 < scale < 1e3:
        for i in range(value_bound.n_taken[0]):
            taken[taken[i].pose].known = False
        value_bound.n_taken[0] = 0
        for block in range(len(mass)):
            blocks[block].mass = mass[block]
        return
    for i in range(value_bound.n_taken[0]):
        taken[taken[i].pose].sum *= scale
    for block in range(len(mass)):
        gap = mass[block] - blocks[block].mass
        blocks[block].mass = mass[block]
        # O(changed blocks * known poses) instead of O(all blocks * poses asked for again).
        if gap > _NOTHING or gap < -_NOTHING:
            for i in range(value_bound.n_taken[0]):
                pose = int64(taken[i].pose)
                row, col = (pose >> 3) // n_cols, (pose >> 3) % n_cols
                taken[pose].sum += gap * target_bound(value_bound, block, pose, row, col)


def _around_obstacles(
    space: SearchSpace, path_map: PathMap, block: NDArray[np.int32]
) -> NDArray[np.float32]:
    """Return the obstacle-aware bounds, shape (P, B), or none where nothing stops the robot.

    Each is the discounted return of moving, round no-fly buildings, until a cell of the block is
    in view, and finding the target.
    """
    if not space.no_fly:
        return np.zeros((0, 0), dtype=np.float32)
    rewards, origins = rewards_of(space), origins_of(likeliest_poses(space))
    n_poses, n_blocks = space.n_cells * HEADINGS, int(block.max()) + 1
    bounds = np.empty((n_poses, n_blocks), dtype=np.float32)
    steps, queue = np.empty(n_poses, dtype=np.int32), np.empty(n_poses, dtype=np.int32)
    for number in range(n_blocks):
        _flood(path_map, origins, block, number, steps, queue)
        # What never comes into view is as far away as can be: it is worth a search without end.
        steps[steps < 0] = n_poses
        bounds[:, number] = known_value(rewards, steps.astype(np.float64))
    return bounds


@jit
def _flood(
    path_map: PathMap,
    origins: Origins,
    block: NDArray[np.int32],
    wanted: int,
    steps: NDArray[np.int32],
    queue: NDArray[np.int32],
) -> None:
    """Fill in the fewest moves from every pose until a block is in view; -1 where it never is.

    It is a breadth-first search backwards from all the poses that see the block.
    """
    head, tail = 0, 0
    for pose in range(len(steps)):
        steps[pose] = -1
        centre, heading = bordered_cell(path_map, pose), pose & 7
        for k in range(path_map.sizes[heading]):
            if len(path_map.hidden) > 0 and path_map.hidden[pose, k]:
                continue
            if block[centre + path_map.fans[heading, k]] == wanted:
                steps[pose], queue[tail] = 0, pose
                tail += 1
                break
    # `queue[head:tail]` are the poses whose origins have not been looked at yet.
    while head < tail:
        pose = int64(queue[head])
        head += 1
        for i in range(origins.starts[pose], origins.starts[pose + 1]):
            other = int64(origins.poses[i])
            if steps[other] < 0:
                steps[other] = steps[pose] + 1
                queue[tail] = other
                tail += 1
