"""Intervals and tests for rewards: Student's t, sign flips by cluster, and Holm's correction."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from sloop_ppl.eval._bootstrap import by_cluster
from sloop_ppl.eval._tables import Estimate

__all__ = ["FEWEST", "holm", "sign_flip_p", "t_estimate"]

FEWEST = 5
"""Fewer values than this get no t-interval."""

_FLIPS = 20_000
_EXACT = 14


def t_estimate(values: Sequence[float]) -> Estimate:
    """Return the mean with its 95 % interval under a normal distribution of unknown width.

    Parameters
    ----------
    values
        At least one; fewer than five get no interval.

    Examples
    --------
    >>> t_estimate([1.0, 2.0, 3.0, 4.0, 5.0]).text()
    '3 [1, 5]'
    """
    table = np.asarray(values, dtype=np.float64)
    mean = float(table.mean())
    if len(table) < FEWEST:
        return Estimate(mean)
    half = float(stats.t.ppf(0.975, len(table) - 1) * table.std(ddof=1) / math.sqrt(len(table)))
    return Estimate(mean, mean - half, mean + half)


def sign_flip_p(
    differences: Sequence[float] | NDArray[np.float64],
    clusters: Sequence[Hashable],
    *,
    rng: np.random.Generator,
) -> float:
    """Return how probable a mean as far from zero is when clusters could as well be negated.

    Parameters
    ----------
    differences
        Paired differences, at least one.
    clusters
        The cluster of each; its differences change sign together.
    rng
        Draws the signs where there are more than 14 clusters; fewer are enumerated.

    Returns
    -------
    float
        Two-sided p in (0, 1]. Of drawn signs, the observed ones count as one draw.

    Raises
    ------
    InputError
        When there is no difference, or not one cluster per difference.

    Notes
    -----
    Exact under the hypothesis that each cluster's sum is symmetric about zero (Good 2005,
    sec. 3.2).

    Examples
    --------
    >>> sign_flip_p([1, 1, 1], ["a", "b", "c"], rng=np.random.default_rng(0))
    0.25
    """
    sums, _ = by_cluster(differences, clusters, "difference")
    n = len(sums)
    least = abs(float(sums.sum())) * (1 - 1e-12)
    if n <= _EXACT:
        signs = 1.0 - 2.0 * (np.arange(2**n)[:, None] >> np.arange(n) & 1)
        return float((np.abs(signs @ sums) >= least).mean())
    signs = rng.integers(0, 2, size=(_FLIPS, n), dtype=np.int8) * 2.0 - 1.0
    return float((1 + (np.abs(signs @ sums) >= least).sum()) / (1 + _FLIPS))


def holm(p_values: Sequence[float]) -> list[float]:
    """Return p-values corrected by Holm's method for the family they make up, in their order.

    Notes
    -----
    Source: Holm (1979), A simple sequentially rejective multiple test procedure.

    Examples
    --------
    >>> holm([0.01, 0.04, 0.03])
    [0.03, 0.06, 0.06]
    """
    order = sorted(range(len(p_values)), key=lambda i: p_values[i])
    corrected, most = [0.0] * len(p_values), 0.0
    for place, index in enumerate(order):
        most = max(most, min(1.0, (len(p_values) - place) * p_values[index]))
        corrected[index] = most
    return corrected
