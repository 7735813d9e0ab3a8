"""The mass that a path search counts: the expected number of targets by cell and by block.

Written as loops that pass once over the cells, because on large maps such passes are what a step
costs; sums are taken in the order in which numpy takes them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning._compile import jit

__all__ = ["add_mass", "eighth_power", "sum_by_block"]


@jit
def eighth_power(table: NDArray[np.float64], top: float, powers: NDArray[np.float64]) -> None:
    """Fill in ``(b / top) ** 8`` by cell, by squaring thrice."""
    for cell in range(len(table)):
        # Divided by the greatest first, so that the power does not underflow everywhere.
        value = table[cell] / top
        value *= value
        value *= value
        value *= value
        powers[cell] = value


@jit
def add_mass(
    mass: NDArray[np.float64],
    table: NDArray[np.float64],
    plain: float,
    powers: NDArray[np.float64],
    sharp: float,
    reach: int,
) -> None:
    """Add ``plain * b + sharp * powers`` to the inner cells of a bordered map.

    Parameters
    ----------
    mass
        What is added to, shape (H + 2 R, W + 2 R).
    table
        Belief b over the cells, shape (H W,).
    powers
        What `eighth_power` gave, shape (H W,); empty where `sharp` is 0.
    reach
        R.
    """
    rows, cols = mass.shape[0] - 2 * reach, mass.shape[1] - 2 * reach
    for row in range(rows):  # rows as arrays of their own, so that the inner loops are vectorised
        line = mass[row + reach, reach : reach + cols]
        b = table[row * cols : (row + 1) * cols]
        if len(powers) > 0:
            power = powers[row * cols : (row + 1) * cols]
            for col in range(cols):
                line[col] += plain * b[col] + sharp * power[col]
        else:
            for col in range(cols):
                line[col] += plain * b[col]


@jit
def sum_by_block(
    mass: NDArray[np.float64], block: NDArray[np.int32], sums: NDArray[np.float64]
) -> None:
    """Add the mass of each cell to the sum of its block, which is 0 before."""
    for cell in range(len(mass)):
        sums[block[cell]] += mass[cell]
