"""Measures of a belief against the true place, by name.

Shape legend: H, W grid.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.eval.descriptions import Place
from sloop_ppl.inference.summaries import expected_distance_m
from sloop_ppl.maps import Grid
from sloop_ppl.registry import Registry

__all__ = [
    "LEAST_PROBABILITY",
    "METRICS",
    "MIXED_IN",
    "Metric",
    "json_names",
    "level_with",
    "probability_within",
    "summarised",
]

Belief: TypeAlias = NDArray[np.float64]
Metric: TypeAlias = Callable[[Belief, Grid, Place], float]
"""Takes a belief, shape (H, W), summing to one; the grid; and the true `Place`, whose field `area`
has the cells that are searched (None for all). Returns a number."""

LEAST_PROBABILITY = 1e-300
"""The belief at the true cell counts as no less."""

MIXED_IN = 0.01
"""Share of the uniform belief that takes hard zeros out of a comparison."""

_SAME = 1e-12
_ROUNDING_M = 1e-6

METRICS: Registry[Metric] = Registry("metric")
"""What ``sloop eval quality`` measures of each belief; a metric of one's own is added to it."""


def summarised(name: str, values: Sequence[float]) -> float:
    """Return a metric over many targets: the median of a rank and of ``median_*``, else the mean.

    Parameters
    ----------
    name
        Name of the metric.
    values
        Its value for each target, at least one.
    """
    middle = name == "rank" or name.startswith("median_")
    return float(np.median(values) if middle else np.mean(values))


def level_with(belief: Belief, truth: Place) -> tuple[int, int, int]:
    """Return how many cells of the area are above the true one, level with it, and there at all.

    Notes
    -----
    The true cell is level with itself. Beliefs that differ by less than one part in 1e12 are tied:
    rounding makes no rank.
    """
    at_truth = float(belief[truth.cell])
    inside = belief if truth.area is None else belief[truth.area]
    slack = at_truth * _SAME
    above = inside > at_truth + slack
    tied = ~above & (inside >= at_truth - slack)
    return int(above.sum()), int(tied.sum()), int(inside.size)


def log_score(belief: Belief, grid: Grid, truth: Place) -> float:  # noqa: ARG001
    """Return the natural log of the belief at the true cell, floored at 1e-300."""
    return math.log(max(float(belief[truth.cell]), LEAST_PROBABILITY))


def mean_log_score_mixed(belief: Belief, grid: Grid, truth: Place) -> float:  # noqa: ARG001
    """Return the log score with 1 % of the belief that is uniform over the area mixed in."""
    _, _, n = level_with(belief, truth)
    return math.log((1 - MIXED_IN) * float(belief[truth.cell]) + MIXED_IN / n)


def rank(belief: Belief, grid: Grid, truth: Place) -> float:  # noqa: ARG001
    """Return how many cells have a higher belief than the true one, half of the ties counted."""
    above, tied, _ = level_with(belief, truth)
    return above + (tied - 1) / 2


def mapscore(belief: Belief, grid: Grid, truth: Place) -> float:
    """Return R = 1 - 2 r, r the share of the area that is searched before the true cell.

    Notes
    -----
    Source: MapScore (Sava et al. 2016), cells in order of belief, half of the ties before it. r is
    a share of the other cells, so that the first cell has exactly 1, the last -1, and a belief that
    is uniform 0; theirs counts half of the true cell too, which is off by 1 / cells.
    """
    _, _, n = level_with(belief, truth)
    return 1.0 if n == 1 else 1.0 - 2.0 * rank(belief, grid, truth) / (n - 1)


def probability_within(radius_m: float) -> Metric:
    """Return the metric of the belief in the cells whose centres are so near the true place.

    It is the probability of area (POA) of a disc around it.
    """

    def within(belief: Belief, grid: Grid, truth: Place) -> float:
        return float(belief[_distance_m(grid, truth) <= radius_m + _ROUNDING_M].sum())

    within.__doc__ = f"Return the belief within {radius_m:g} m of the true place."
    return within


def median_error_m(belief: Belief, grid: Grid, truth: Place) -> float:
    """Return the distance from the true place to the most probable cell, metres.

    Of cells that tie for it the mean is taken, so that no order of cells matters.
    """
    modal = belief >= belief.max() * (1 - _SAME)
    return float(_distance_m(grid, truth)[modal].mean())


def mean_distance_m(belief: Belief, grid: Grid, truth: Place) -> float:
    """Return the mean distance under the belief from the true place, metres."""
    return expected_distance_m(belief, grid, (truth.x_m, truth.y_m))


def _distance_m(grid: Grid, truth: Place) -> NDArray[np.float64]:
    apart: NDArray[np.float64] = np.hypot(
        grid.x_m[None, :] - truth.x_m, grid.y_m[:, None] - truth.y_m
    )
    return apart


def json_names(metrics: Mapping[str, Any]) -> dict[str, str]:
    """Return name of a metric -> its key in what ``sloop eval quality --json`` prints."""
    return {name: _KEYS.get(name, name) for name in metrics}


_KEYS = {"log_score": "mean_log_score", "rank": "median_rank"}

METRICS.add("log_score", log_score)
METRICS.add("mean_log_score_mixed", mean_log_score_mixed)
METRICS.add("rank", rank)
METRICS.add("expected_distance_m", mean_distance_m)
METRICS.add("mapscore", mapscore)
for _radius_m in (25, 50, 100):
    METRICS.add(f"poa_{_radius_m}m", probability_within(_radius_m))
METRICS.add("median_error_m", median_error_m)
