"""What is left to be earned from a pose, as one would estimate it who knew where the targets are.

The cells are gathered into blocks, whose mass counts as if it were at their middle. The sum over
all of them is taken once per pose and kept; what a path has seen is taken off it.

Legend: P poses; B blocks.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning.compile import inlined, jit
from sloop_ppl.planning.detours import detour_worths
from sloop_ppl.planning.ground import reach_of
from sloop_ppl.planning.hindsight import hindsight_bounds
from sloop_ppl.planning.pose import HEADINGS
from sloop_ppl.planning.space import SearchSpace

__all__ = ["Outlook", "believe", "block_worth", "outlook_from", "outlook_of"]

BLOCKS = 500
"""How many blocks of cells there may be."""

CHANGED = 64
"""Blocks that may have changed for the sums to be mended, not taken anew."""

DETOURS_BYTES = 32 * 2**20
"""Room for what each block is worth from each pose, where there are no-fly buildings."""

_NOTHING = 1e-12


class Outlook(NamedTuple):
    """Mass by block, and what it promises.

    Attributes
    ----------
    bound : worth of one target at an offset, for who knows where it is, by heading, shape
        (8, 2 H - 1, 2 W - 1).
    detours : the same by pose and block where there are no-fly buildings, shape (P, B) or (0, 0).
    rows, cols : the middle of each block, shape (B,).
    block : block of each cell of the bordered map, shape as that.
    mass : expected number of targets in each block, shape (B,).
    sums : what all of the mass promises from a pose, shape (P,), where it was taken.
    taken : the poses from which it was taken; the first `n_taken[0]` of them, shape (P,).
    known : True where it was taken, shape (P,).
    """

    bound: NDArray[np.float32]
    detours: NDArray[np.float32]
    rows: NDArray[np.int32]
    cols: NDArray[np.int32]
    block: NDArray[np.int32]
    mass: NDArray[np.float64]
    sums: NDArray[np.float64]
    taken: NDArray[np.int32]
    known: NDArray[np.bool_]
    n_taken: NDArray[np.int64]


def outlook_of(space: SearchSpace) -> Outlook:
    """Return the outlook on a map that holds nothing yet."""
    reach, n_poses = reach_of(space), space.n_cells * HEADINGS
    most = max(min(BLOCKS, DETOURS_BYTES // (4 * n_poses)), 1) if space.no_fly else BLOCKS
    side = max(math.ceil(math.sqrt(space.n_cells / most)), 1)
    across = -(-space.n_cols // side)
    row, col = np.mgrid[: space.n_rows + 2 * reach, : space.n_cols + 2 * reach] - reach
    inside_row, inside_col = row.clip(0, space.n_rows - 1), col.clip(0, space.n_cols - 1)
    middle_row, middle_col = np.mgrid[: -(-space.n_rows // side), :across] * side + side // 2
    block = (inside_row // side * across + inside_col // side).ravel().astype(np.int32)
    detours = detour_worths(space, block) if space.no_fly else np.zeros((0, 0), dtype=np.float32)
    return Outlook(
        bound=hindsight_bounds(space),
        detours=detours,
        rows=middle_row.clip(max=space.n_rows - 1).ravel().astype(np.int32),
        cols=middle_col.clip(max=space.n_cols - 1).ravel().astype(np.int32),
        block=block,
        mass=np.zeros(middle_row.size),
        sums=np.zeros(n_poses),
        taken=np.zeros(n_poses, dtype=np.int32),
        known=np.zeros(n_poses, dtype=bool),
        n_taken=np.zeros(1, dtype=np.int64),
    )


@inlined
def block_worth(outlook: Outlook, block: int, pose: int, row: int, col: int) -> float:
    """Return what one target in a block is worth from a pose, at `row` and `col`."""
    if len(outlook.detours) > 0:
        return float(outlook.detours[pose, block])
    rows, cols = (outlook.bound.shape[1] - 1) // 2, (outlook.bound.shape[2] - 1) // 2
    north, east = outlook.rows[block] - row, outlook.cols[block] - col
    return float(outlook.bound[pose & 7, north + rows, east + cols])


@inlined
def outlook_from(outlook: Outlook, pose: int, n_cols: int) -> float:
    """Return what all of the mass promises from a pose."""
    if not outlook.known[pose]:
        row, col = (pose >> 3) // n_cols, (pose >> 3) % n_cols
        total = 0.0
        for block in range(len(outlook.mass)):
            if outlook.mass[block] > 0.0:
                total += outlook.mass[block] * block_worth(outlook, block, pose, row, col)
        outlook.sums[pose], outlook.known[pose] = total, True
        outlook.taken[outlook.n_taken[0]] = pose
        outlook.n_taken[0] += 1
    return float(outlook.sums[pose])


@jit
def believe(outlook: Outlook, mass: NDArray[np.float64], n_cols: int) -> None:
    """Take other masses of the blocks; sums are kept where few blocks changed but by a factor.

    Parameters
    ----------
    outlook : changed.
    mass : expected number of targets in each block, shape (B,).
    n_cols : columns of the map.
    """
    scale, changed = 0.0, 0
    for block in range(len(mass)):
        if outlook.mass[block] > _NOTHING:
            scale = max(scale, mass[block] / outlook.mass[block])
    for block in range(len(mass)):
        outlook.mass[block] *= scale
        changed += abs(mass[block] - outlook.mass[block]) > _NOTHING
    if changed > CHANGED or scale == 0.0 or not 1e-3 < scale < 1e3:
        for i in range(outlook.n_taken[0]):
            outlook.known[outlook.taken[i]] = False
        outlook.n_taken[0] = 0
        for block in range(len(mass)):
            outlook.mass[block] = mass[block]
        return
    for i in range(outlook.n_taken[0]):
        outlook.sums[outlook.taken[i]] *= scale
    for block in range(len(mass)):
        gap = mass[block] - outlook.mass[block]
        outlook.mass[block] = mass[block]
        if abs(gap) > _NOTHING:
            for i in range(outlook.n_taken[0]):
                pose = outlook.taken[i]
                row, col = (pose >> 3) // n_cols, (pose >> 3) % n_cols
                outlook.sums[pose] += gap * block_worth(outlook, block, pose, row, col)
