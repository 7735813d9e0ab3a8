"""What the engines that move fronts continuously share: a start, an answer and its evidence."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.special import ive
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.inference.conditional import GivenFronts, given_fronts
from sloop_ppl.inference.engine import LogFactors
from sloop_ppl.inference.summaries import circular_summary
from sloop_ppl.inference.torch_seed import seeded_torch
from sloop_ppl.maps import CityMap
from sloop_ppl.models import Preset, RelationTerm

__all__ = ["FindFronts", "infer_by_fronts", "likeliest_fronts"]

FindFronts = Callable[[GivenFronts, Tensor], Tensor]
"""Takes a target and its log prior over cells, (S,); gives fronts from their posterior, (n, J)."""

_CHUNK = 64
_EVIDENCE_DRAWS = 2000


def infer_by_fronts(
    engine: str,
    find: FindFronts,
    terms: Sequence[tuple[RelationTerm, ...]],
    city: CityMap,
    model: Preset,
    *,
    log_prior: NDArray[np.float64],
    truths: Sequence[tuple[float, float]] | None,
    rng: np.random.Generator | None,
) -> LogFactors:
    """Average the posterior of component and cell over fronts from their posterior.

    Parameters
    ----------
    engine : its name, for messages.
    find : finds the fronts of one target; torch is seeded and kept to one thread around it.
    terms, city, model, log_prior, truths : as for :func:`sloop_ppl.inference.exact`.
    rng : seeds the engine; required.

    Raises
    ------
    InputError : when `rng` is missing, or frames are points or shared.

    Notes
    -----
    The factor is Z E[L(k, s, psi) / Z(psi)] over the fronts, where Z(psi) is the sum of L times
    the prior over cells. Its product with that prior is the mean posterior, and sums to the
    evidence Z, which is estimated by importance sampling: half the draws from the fronts' prior,
    half from von Mises distributions fitted to the fronts that were found.
    """
    if rng is None:
        raise InputError(f"Engine '{engine}' draws; give rng=numpy.random.default_rng(seed)")
    evidence, targets = given_fronts(terms, city, model, truths)
    _check_continuous(engine, targets, evidence.shared.grounds)
    tables = []
    for target, log_cells in zip(targets, torch.from_numpy(log_prior), strict=True):
        with seeded_torch(rng):
            if target.terms:
                fronts = find(target, log_cells)
                log_z = _log_evidence(target, log_cells, fronts, rng)
                tables.append(_mean_posterior(target, log_cells, fronts) + log_z)
            else:
                tables.append(target.log_factor(torch.zeros(1, 0).double())[0].numpy())
    return LogFactors(evidence.components, evidence.shared, np.stack(tables))


def likeliest_fronts(target: GivenFronts) -> Tensor:
    """Return the mean of the weightiest part of each front's prior, shape (J,)."""
    parts = [prior.parts for prior in target.priors]
    means = [max(p, key=lambda part: part.weight).mean_rad if p else 0.0 for p in parts]
    return torch.tensor(means, dtype=torch.float64)


def _mean_posterior(target: GivenFronts, log_cells: Tensor, fronts: Tensor) -> NDArray[np.float64]:
    """Return log E[L / Z] over fronts drawn from their posterior, shape (C, K, S)."""
    with torch.no_grad():
        parts = []
        for chunk in fronts.split(_CHUNK):
            factor = target.log_factor(chunk)
            log_z = torch.logsumexp((factor + log_cells).flatten(1), 1)
            parts.append(torch.logsumexp(factor - log_z[:, None, None, None], 0))
        mean = torch.logsumexp(torch.stack(parts), 0) - math.log(len(fronts))
    table: NDArray[np.float64] = mean.numpy()
    return table


def _log_evidence(
    target: GivenFronts, log_cells: Tensor, fronts: Tensor, rng: np.random.Generator
) -> float:
    """Return the log of the mean of Z(psi) over the fronts' prior, by importance sampling."""
    half = _EVIDENCE_DRAWS // 2
    fits = [_fitted(column) for column in fronts.numpy().T]
    drawn = np.stack([rng.vonmises(mean, kappa, half) for mean, kappa in fits], 1)
    proposed = torch.cat([target.draw(half, rng), torch.from_numpy(drawn)])
    log_fit = torch.zeros(len(proposed), dtype=torch.float64)
    for (mean, kappa), angles in zip(fits, proposed.T, strict=True):
        level = math.log(2 * math.pi * ive(0, kappa))
        log_fit = log_fit + kappa * (torch.cos(angles - mean) - 1) - level
    log_prior = target.log_prior(proposed)
    log_proposal = torch.logaddexp(log_prior, log_fit) - math.log(2)
    with torch.no_grad():
        log_z = [
            torch.logsumexp((target.log_factor(chunk) + log_cells).flatten(1), 1)
            for chunk in proposed.split(_CHUNK)
        ]
    weights = torch.cat(log_z) + log_prior - log_proposal
    return float(torch.logsumexp(weights, 0)) - math.log(len(proposed))


def _fitted(angles: NDArray[np.float64]) -> tuple[float, float]:
    """Return mean and concentration of angles, no narrower than a spread of a degree."""
    mean, kappa = circular_summary(np.ones(len(angles)), angles)
    return mean, min(kappa, 3000.0)


def _check_continuous(engine: str, targets: Sequence[GivenFronts], shared: tuple[str, ...]) -> None:
    """Refuse frames an engine with gradients cannot move through."""
    if shared:
        raise InputError(f"Engine '{engine}' takes no shared frames; use exact or enumerate")
    for target in targets:
        if any(math.isinf(part.kappa) for prior in target.priors for part in prior.parts):
            raise InputError(
                f"Engine '{engine}' needs frames with a density and got a point; use a model such "
                "as bayes, or the exact engine"
            )
