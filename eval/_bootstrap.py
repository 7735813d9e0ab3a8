"""Bootstrap intervals for means of observations that come in clusters."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError

__all__ = ["DRAWS", "by_cluster", "clustered_interval"]

DRAWS = 10_000
"""How often the clusters are drawn again."""

_NUMBERS_AT_ONCE = 4_000_000


def clustered_interval(
    values: Sequence[float] | NDArray[np.float64],
    clusters: Sequence[Hashable],
    *,
    rng: np.random.Generator,
    draws: int = DRAWS,
    level: float = 0.95,
) -> tuple[float, float]:
    """Return a percentile interval for the mean of clustered values.

    Parameters
    ----------
    values
        One value per observation, finite.
    clusters
        The cluster of each observation, such as its configuration of objects.
    rng
        Draws the clusters; the same seed gives the same interval.
    draws
        How often, > 0.
    level
        Probability of the interval, in (0, 1).

    Returns
    -------
    tuple of float
        Lower and upper end. One cluster alone tells nothing of the spread between clusters: both
        ends are then the mean.

    Raises
    ------
    InputError
        When there is no value, or not one cluster per value.

    Notes
    -----
    Whole clusters are drawn with replacement, as many as there are, and all their observations
    with them (Davison and Hinkley 1997, sec. 3.8). Differences of two models on the same
    observations are one value each, which makes the interval a paired one. Clusters are taken in
    the order in which they first come, so nothing depends on hashes.

    Examples
    --------
    >>> import numpy as np
    >>> clustered_interval([1.0, 1.0, 3.0], ["a", "a", "b"], rng=np.random.default_rng(0))
    (1.0, 3.0)
    """
    sums, counts = by_cluster(values, clusters, "value")
    means = []
    step = max(1, _NUMBERS_AT_ONCE // len(sums))
    for start in range(0, draws, step):
        drawn = rng.integers(len(sums), size=(min(step, draws - start), len(sums)))
        means.append(sums[drawn].sum(1) / counts[drawn].sum(1))
    tail = (1 - level) / 2
    low, high = np.quantile(np.concatenate(means), [tail, 1 - tail])
    return float(low), float(high)


def by_cluster(
    values: Sequence[float] | NDArray[np.float64], clusters: Sequence[Hashable], what: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return sum and count of the values of each cluster, in the order they first come.

    Raises
    ------
    InputError
        When there is no value, or not one cluster per value.
    """
    table = np.asarray(values, dtype=np.float64)
    if table.ndim != 1 or len(table) == 0 or len(clusters) != len(table):
        raise InputError(
            f"There are {table.shape} {what}s and {len(clusters)} clusters; expected at least one "
            f"{what} and a cluster for each"
        )
    order = {cluster: i for i, cluster in enumerate(dict.fromkeys(clusters))}
    which = np.array([order[cluster] for cluster in clusters])
    sums, counts = np.bincount(which, weights=table), np.bincount(which)
    return sums.astype(np.float64), counts.astype(np.float64)
