"""The map, and what counts on it, as arrays for the search over paths.

Legend: P poses; K cells of the largest fan; R range of the sensor, rounded down; C cells that hold
the belief.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.search.compile import inlined

__all__ = ["Ground", "Worth", "mass_in_view"]


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


@inlined
def mass_in_view(ground: Ground, worth: Worth, factor: NDArray[np.float64], pose: int) -> float:
    """Return the mass in view from a pose."""
    total, home, heading = 0.0, ground.home[pose], pose & 7
    for k in range(ground.sizes[heading]):
        if len(ground.hidden) > 0 and ground.hidden[pose, k]:
            continue
        cell = home + ground.fans[heading, k]
        total += worth.mass[cell] * factor[cell]
    return total
