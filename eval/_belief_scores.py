"""What a belief is worth, told where the target truly is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.eval.descriptions import Place
from sloop_ppl.inference import expected_distance_m
from sloop_ppl.maps import Grid

__all__ = [
    "LEAST_PROBABILITY",
    "LEVELS",
    "MIXED_IN",
    "BeliefScore",
    "Region",
    "ScoredTarget",
    "score_belief",
]

LEAST_PROBABILITY = 1e-300
"""The belief at the true cell counts as no less."""

MIXED_IN = 0.01
"""Share of the uniform belief that takes hard zeros out of a comparison."""

LEVELS = (0.5, 0.9)
"""Probabilities of the regions by which calibration is judged."""

NEAR_M = 15.0
_HPD = 0.9
_SAME = 1e-12


@dataclass(frozen=True)
class Region:
    """The smallest region of a belief that holds just so much of it, and whether the truth is in.

    Parameters
    ----------
    covers
        Probability, in [0, 1], that the true cell is in it; see Notes.
    area_m2
        Its area, square metres.

    Notes
    -----
    Cells are taken in order of their belief, ties in random order; of the last one only the part
    is taken that makes up the probability, so that a calibrated belief is covered just so often,
    and the true cell is in with that part's probability. `covers` averages over both draws.
    """

    covers: float
    area_m2: float


@dataclass(frozen=True)
class BeliefScore:
    """How good one belief about one target is.

    Parameters
    ----------
    log_score
        Natural log of the belief at the true cell, floored at 1e-300.
    rank
        How many cells have a higher belief than the true one, half of the ties counted.
    expected_distance_m
        Mean distance under the belief from the true place, metres.
    mass_15m
        Belief in the cells whose centres are within 15 m of the true place.
    in_hpd90
        Share, in [0, 1], of the ways to order tied cells in which the smallest set of cells that
        holds 90 % of the belief has the true cell in it; 0 or 1 without ties.
    log_score_mixed
        Log score with 1 % of the uniform belief mixed in.
    regions
        The region of each of `LEVELS`.
    """

    log_score: float
    rank: float
    expected_distance_m: float
    mass_15m: float
    in_hpd90: float
    log_score_mixed: float
    regions: tuple[Region, ...]


@dataclass(frozen=True)
class ScoredTarget:
    """The score of one model's belief about one target of one description.

    Parameters
    ----------
    description
        Id of the description.
    configuration
        The placement of objects it describes.
    target
        Id of the target.
    map
        Name of the map.
    relations
        Words of the gold relations of the target: the class of compass and frame words, the word
        itself of the others.
    score
        How good the belief is.
    """

    description: str
    configuration: str
    target: str
    map: str
    relations: tuple[str, ...]
    score: BeliefScore


def score_belief(belief: NDArray[np.float64], grid: Grid, truth: Place) -> BeliefScore:
    """Score a belief against the truth.

    Parameters
    ----------
    belief
        Probability of each cell, shape (H, W), summing to one.
    truth
        Where the target is.

    Notes
    -----
    Beliefs that differ by less than one part in 1e12 are tied: rounding makes no rank.
    """
    at_truth = float(belief[truth.cell])
    slack = at_truth * _SAME
    higher = belief > at_truth + slack
    tied = ~higher & (belief >= at_truth - slack)
    apart = np.hypot(grid.x_m[None, :] - truth.x_m, grid.y_m[:, None] - truth.y_m)
    return BeliefScore(
        log_score=float(np.log(max(at_truth, LEAST_PROBABILITY))),
        rank=float(higher.sum() + (tied.sum() - 1) / 2),
        expected_distance_m=expected_distance_m(belief, grid, (truth.x_m, truth.y_m)),
        mass_15m=float(belief[apart <= NEAR_M + 1e-6].sum()),
        in_hpd90=_share_inside(belief, int(higher.sum()), int(tied.sum())),
        log_score_mixed=float(np.log((1 - MIXED_IN) * at_truth + MIXED_IN / grid.size)),
        regions=_regions(belief, float(belief[higher].sum()), float(belief[tied].sum()), grid),
    )


def _regions(
    belief: NDArray[np.float64], higher: float, tied: float, grid: Grid
) -> tuple[Region, ...]:
    """Return the regions, given the belief in the cells above the true one and level with it."""
    order = np.sort(belief, axis=None)[::-1]
    held = np.concatenate([[0.0], np.cumsum(order)])
    found = []
    for level in LEVELS:
        whole = int(np.searchsorted(held, level, side="right")) - 1
        part = (level - held[whole]) / order[whole] if whole < len(order) else 0.0
        covers = min(1.0, max(0.0, (level - higher) / tied)) if tied > 0 else 0.0
        found.append(Region(covers, float(whole + part) * grid.cell_m**2))
    return tuple(found)


def _share_inside(belief: NDArray[np.float64], higher: int, tied: int) -> float:
    held = np.cumsum(np.sort(belief, axis=None)[::-1])
    needed = int(np.searchsorted(held, _HPD - 1e-12)) + 1
    return min(1.0, max(0.0, (needed - higher) / tied))
