"""Importance sampling: fronts drawn from their priors, component and cell enumerated."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.inference.conditional import GivenFronts, given_fronts
from sloop_ppl.inference.engine import ENGINES, LogFactors
from sloop_ppl.maps import CityMap
from sloop_ppl.models import Preset, RelationTerm

__all__ = ["DRAWS", "importance"]

DRAWS = 10_000
"""Draws per target."""

_CHUNK_NUMBERS = 4_000_000


def importance(
    terms: Sequence[tuple[RelationTerm, ...]],
    city: CityMap,
    model: Preset,
    *,
    log_prior: NDArray[np.float64],  # noqa: ARG001 - cells are enumerated, not drawn
    truths: Sequence[tuple[float, float]] | None = None,
    rng: np.random.Generator | None = None,
    draws: int = DRAWS,
) -> LogFactors:
    """Estimate the factors as the mean over fronts drawn from their priors.

    Parameters are those of :func:`sloop_ppl.inference.exact`, and

    Parameters
    ----------
    terms, city, model, log_prior, truths : as for the exact engine.
    rng : where fronts are drawn from; required.
    draws : how many fronts are drawn for each target, > 0.

    Raises
    ------
    InputError : when `rng` is missing.
    """
    if rng is None:
        raise InputError("Engine 'importance' draws; give rng=numpy.random.default_rng(seed)")
    evidence, targets = given_fronts(terms, city, model, truths)
    with torch.no_grad():
        tables = [_mean_factor(target, draws, rng) for target in targets]
    return LogFactors(evidence.components, evidence.shared, np.stack(tables))


def _mean_factor(target: GivenFronts, draws: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return the log of the mean factor over draws, shape (C, K, S)."""
    fronts = target.draw(draws if target.terms else 1, rng)
    one = target.log_factor(fronts[:1])
    step = max(1, _CHUNK_NUMBERS // one.numel())
    sums = [torch.logsumexp(target.log_factor(part), 0) for part in fronts.split(step)]
    mean = torch.logsumexp(torch.stack(sums), 0) - math.log(len(fronts))
    table: NDArray[np.float64] = mean.numpy()
    return table


ENGINES.add("importance", importance)
