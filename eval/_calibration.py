"""Whether stated probabilities are the shares that are right."""

from __future__ import annotations

import itertools
import math
from collections.abc import Hashable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError

__all__ = ["BIN_SIZE", "Calibration", "CalibrationBin", "calibration"]

BIN_SIZE = 200
"""Fewest statements in a bin: the share that is right has a standard error of .035 at most."""

_DRAWS = 1000
_NUMBERS_AT_ONCE = 4_000_000
_NEAREST_TO_CERTAIN = 1e-3  # nearer to 0 or 1 the logit of one statement would decide the slope
_RIDGE = 1e-4  # keeps the slope finite where right and wrong do not overlap

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CalibrationBin:
    """Statements of about one probability.

    Parameters
    ----------
    n
        How many.
    stated
        Their mean probability.
    right
        Share of them that are right.
    """

    n: int
    stated: float
    right: float


@dataclass(frozen=True)
class Calibration:
    """How far stated probabilities are those of being right.

    Parameters
    ----------
    n
        Number of statements.
    right
        Share of them that are right.
    slope
        Of the logit of being right on the logit of the probability: 1 when calibrated, below 1
        when too sure. None when all state the same, or all are right, or none.
    slope_ci95
        Interval of it, from a bootstrap over clusters; None where there is no slope.
    brier, brier_constant
        Mean squared error of the probabilities, and of the share `right` stated of all.
    auc
        Probability that of two statements, one right and one wrong, the right one is stated with
        more confidence, ties counted half; None when all are right, or none.
    bins
        Statements in the order of their probabilities, `BIN_SIZE` or more to a bin, equal ones
        together.
    """

    n: int
    right: float
    slope: float | None
    slope_ci95: tuple[float, float] | None
    brier: float
    brier_constant: float
    auc: float | None
    bins: tuple[CalibrationBin, ...]

    def to_json(self) -> dict[str, Any]:
        """Return the value of the key ``confidence`` of ``sloop eval parse --json``."""
        fields = asdict(self)
        fields["slope_ci95"] = None if self.slope_ci95 is None else list(self.slope_ci95)
        fields["bins"] = list(fields["bins"])
        return fields


def calibration(
    stated: Sequence[float] | Array,
    right: Sequence[bool] | NDArray[np.bool_],
    clusters: Sequence[Hashable],
    *,
    rng: np.random.Generator,
    bin_size: int = BIN_SIZE,
) -> Calibration:
    """Judge stated probabilities by what was right.

    Parameters
    ----------
    stated
        Probability of each statement, in [0, 1].
    right
        Whether it is right.
    clusters
        What it belongs to, such as its description: statements of one are not independent.
    rng
        Draws the bootstrap of the slope.
    bin_size
        Fewest statements in a bin.

    Raises
    ------
    InputError
        When there is no statement, not one value of each for all, or a probability outside [0, 1].

    Notes
    -----
    The slope is that of Cox (1958): logit P(right) = a + b logit(stated), fitted by maximum
    likelihood with probabilities held .001 away from 0 and 1. Draws of the bootstrap without a
    slope (all right, or all stated alike) are left out.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> found = calibration(
    ...     [0.9] * 10 + [0.4] * 10, [1] * 9 + [0] + [1] * 4 + [0] * 6, range(20), rng=rng
    ... )
    >>> round(found.slope, 2), round(found.auc, 2), found.brier < found.brier_constant
    (1.0, 0.77, True)
    """
    p, y = np.asarray(stated, dtype=np.float64), np.asarray(right, dtype=np.float64)
    if p.ndim != 1 or not len(p) == len(y) == len(clusters) or len(p) == 0:
        raise InputError(
            f"There are {len(p)} probabilities, {len(y)} outcomes and {len(clusters)} clusters; "
            "expected at least one, and one of each for all"
        )
    if not ((p >= 0) & (p <= 1)).all():
        raise InputError("A stated probability is outside [0, 1]; expected a probability")
    share = float(y.mean())
    slope = _slopes(p, y, np.ones((1, len(p))))[0]
    interval = None if math.isnan(slope) else _interval(p, y, clusters, rng)
    return Calibration(
        n=len(p),
        right=share,
        slope=None if math.isnan(slope) else float(slope),
        slope_ci95=interval,
        brier=float(np.mean((p - y) ** 2)),
        brier_constant=share * (1 - share),
        auc=_auc(p, y),
        bins=tuple(_bins(p, y, bin_size)),
    )


def _interval(
    p: Array, y: Array, clusters: Sequence[Hashable], rng: np.random.Generator
) -> tuple[float, float] | None:
    order = {cluster: i for i, cluster in enumerate(dict.fromkeys(clusters))}
    which = np.array([order[cluster] for cluster in clusters])
    even = np.full(len(order), 1 / len(order))
    slopes = []
    step = max(1, _NUMBERS_AT_ONCE // len(p))
    for start in range(0, _DRAWS, step):
        times = rng.multinomial(len(order), even, size=min(step, _DRAWS - start))
        slopes.append(_slopes(p, y, times[:, which].astype(np.float64)))
    drawn = np.concatenate(slopes)
    drawn = drawn[~np.isnan(drawn)]
    if not len(drawn):
        return None
    low, high = np.quantile(drawn, [0.025, 0.975])
    return float(low), float(high)


def _slopes(p: Array, y: Array, weights: Array, *, rounds: int = 50) -> Array:
    """Return the slope for each row of weights, shape (draws,), by Newton's method; nan for none.

    Equal statements are counted together first, so that a round costs (draws, different p).
    """
    levels, level = np.unique(
        np.clip(p, _NEAREST_TO_CERTAIN, 1 - _NEAREST_TO_CERTAIN), return_inverse=True
    )
    member = np.zeros((len(p), len(levels)))
    member[np.arange(len(p)), level] = 1
    n, good = weights @ member, (weights * y) @ member
    x = np.log(levels) - np.log1p(-levels)
    a, b = np.zeros(len(weights)), np.zeros(len(weights))
    for _ in range(rounds):
        q = 1 / (1 + np.exp(-np.clip(a[:, None] + b[:, None] * x, -30, 30)))
        spread = n * q * (1 - q)
        error = good - n * q
        g_a, g_b = error.sum(1), error @ x - _RIDGE * b
        h_aa, h_ab, h_bb = spread.sum(1) + _RIDGE, spread @ x, spread @ x**2 + _RIDGE
        scale = h_aa * h_bb - h_ab**2
        step_a, step_b = (h_bb * g_a - h_ab * g_b) / scale, (h_aa * g_b - h_ab * g_a) / scale
        longest = np.maximum(1, np.maximum(np.abs(step_a), np.abs(step_b)))
        a, b = a + step_a / longest, b + step_b / longest
        if max(np.abs(step_a).max(), np.abs(step_b).max()) < 1e-9:
            break
    total, all_good = n.sum(1), good.sum(1)
    is_defined = ((n > 0).sum(1) > 1) & (all_good > 0) & (all_good < total)
    return np.where(is_defined, b, np.nan)


def _auc(p: Array, y: Array) -> float | None:
    """Return the normalised Mann-Whitney statistic, ties counted half."""
    levels, level = np.unique(p, return_inverse=True)
    good = np.bincount(level, weights=y, minlength=len(levels))
    bad = np.bincount(level, weights=1 - y, minlength=len(levels))
    if not good.sum() or not bad.sum():
        return None
    below = np.cumsum(bad) - bad
    return float((good * (below + bad / 2)).sum() / (good.sum() * bad.sum()))


def _bins(p: Array, y: Array, size: int) -> list[CalibrationBin]:
    order = np.argsort(p, kind="stable")
    p, y = p[order], y[order]
    # A bin may end where the next probability is another one, or at the end.
    ends = [*(np.flatnonzero(np.diff(p) > 0) + 1), len(p)]
    cuts = [0]
    for end in ends:
        if end - cuts[-1] >= size:
            cuts.append(int(end))
    if len(cuts) == 1:
        cuts.append(len(p))
    cuts[-1] = len(p)  # what is left over goes to the last bin
    return [
        CalibrationBin(b - a, float(p[a:b].mean()), float(y[a:b].mean()))
        for a, b in itertools.pairwise(cuts)
    ]
