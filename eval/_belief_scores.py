"""What a belief is worth, told where the target truly is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.eval.descriptions import Place
from sloop_ppl.eval.metrics import METRICS, Metric, level_with, probability_within
from sloop_ppl.maps import Grid

__all__ = [
    "LEVELS",
    "BeliefScore",
    "Region",
    "ScoredTarget",
    "score_belief",
]

LEVELS = (0.5, 0.9)
"""Probabilities of the regions by which calibration is judged."""

NEAR_M = 15.0
_HPD = 0.9


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
    log_score, rank, expected_distance_m, log_score_mixed
        See `sloop_ppl.eval.METRICS`.
    mass_15m
        Belief in the cells whose centres are within 15 m of the true place.
    in_hpd90
        Share, in [0, 1], of the ways to order tied cells in which the smallest set of cells that
        holds 90 % of the belief has the true cell in it; 0 or 1 without ties.
    regions
        The region of each of `LEVELS`.
    metrics
        Every metric that was asked for, by name.
    """

    log_score: float
    rank: float
    expected_distance_m: float
    mass_15m: float
    in_hpd90: float
    log_score_mixed: float
    regions: tuple[Region, ...]
    metrics: Mapping[str, float] = field(default_factory=dict)


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
    source
        The file the description is of; see `AnnotatedDescription.source`.
    """

    description: str
    configuration: str
    target: str
    map: str
    relations: tuple[str, ...]
    score: BeliefScore
    source: str = ""


def score_belief(
    belief: NDArray[np.float64],
    grid: Grid,
    truth: Place,
    metrics: Mapping[str, Metric] | None = None,
) -> BeliefScore:
    """Score a belief against the truth.

    Parameters
    ----------
    belief
        Probability of each cell, shape (H, W), summing to one.
    truth
        Where the target is, and the area that it is searched in.
    metrics
        Name -> what else is measured of it; those of `METRICS` when None.

    Notes
    -----
    Beliefs that differ by less than one part in 1e12 are tied: rounding makes no rank.
    """
    above, tied, _ = level_with(belief, truth)
    inside = np.sort(belief if truth.area is None else belief[truth.area], axis=None)[::-1]
    higher, level = float(inside[:above].sum()), float(inside[above : above + tied].sum())
    return BeliefScore(
        log_score=METRICS["log_score"](belief, grid, truth),
        rank=METRICS["rank"](belief, grid, truth),
        expected_distance_m=METRICS["expected_distance_m"](belief, grid, truth),
        mass_15m=probability_within(NEAR_M)(belief, grid, truth),
        in_hpd90=_share_inside(inside, above, tied),
        log_score_mixed=METRICS["mean_log_score_mixed"](belief, grid, truth),
        regions=_regions(inside, higher, level, grid),
        metrics={
            name: float(measure(belief, grid, truth))
            for name, measure in (METRICS if metrics is None else metrics).items()
        },
    )


def _regions(
    order: NDArray[np.float64], higher: float, tied: float, grid: Grid
) -> tuple[Region, ...]:
    """Return the regions, given the belief in the cells above the true one and level with it.

    Parameters
    ----------
    order
        Beliefs of the cells of the area, the greatest first.
    """
    held = np.concatenate([[0.0], np.cumsum(order)])
    found = []
    for level in LEVELS:
        whole = int(np.searchsorted(held, level, side="right")) - 1
        part = (level - held[whole]) / order[whole] if whole < len(order) else 0.0
        covers = min(1.0, max(0.0, (level - higher) / tied)) if tied > 0 else 0.0
        found.append(Region(covers, float(whole + part) * grid.cell_m**2))
    return tuple(found)


def _share_inside(order: NDArray[np.float64], higher: int, tied: int) -> float:
    held = np.cumsum(order)
    needed = int(np.searchsorted(held, _HPD - 1e-12)) + 1
    return min(1.0, max(0.0, (needed - higher) / tied))
