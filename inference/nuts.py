"""NUTS over the fronts, component and cell enumerated out of the potential."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
import pyro
import torch
from numpy.typing import NDArray
from pyro.infer import MCMC, NUTS
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.inference.conditional import GivenFronts, given_fronts
from sloop_ppl.inference.engine import ENGINES, LogFactors
from sloop_ppl.maps import CityMap
from sloop_ppl.models import Preset, RelationTerm

__all__ = ["nuts", "seeded_torch"]


def nuts(
    terms: Sequence[tuple[RelationTerm, ...]],
    city: CityMap,
    model: Preset,
    *,
    log_prior: NDArray[np.float64],
    truths: Sequence[tuple[float, float]] | None = None,
    rng: np.random.Generator | None = None,
    warmup: int = 50,
    draws: int = 200,
) -> LogFactors:
    """Draw fronts from their posterior and average the posterior of component and cell.

    Parameters
    ----------
    terms, city, model, log_prior, truths : as for the exact engine.
    rng : seeds the chain; required.
    warmup, draws : steps of the chain that are dropped and kept, > 0.

    Raises
    ------
    InputError : when `rng` is missing, or frames are points or shared.

    Notes
    -----
    The factor is E[L(k, s, psi) / Z(psi)] over the chain, whose product with the prior over cells
    is the mean posterior. Angles are not wrapped: the potential has period 2 pi. A cross-check
    for single modes; a chain may miss the second front of a street.
    """
    if rng is None:
        raise InputError("Engine 'nuts' draws; give rng=numpy.random.default_rng(seed)")
    evidence, targets = given_fronts(terms, city, model, truths)
    check_continuous("nuts", targets, evidence.shared.grounds)
    tables = []
    for target, log_cells in zip(targets, torch.from_numpy(log_prior), strict=True):
        fronts = torch.zeros(1, 0, dtype=torch.float64)
        if target.terms:
            with seeded_torch(rng):
                fronts = _chain(target, log_cells, warmup, draws)
        tables.append(posterior_factor(target, log_cells, fronts))
    return LogFactors(evidence.components, evidence.shared, np.stack(tables))


def _chain(target: GivenFronts, log_cells: Tensor, warmup: int, draws: int) -> Tensor:
    def potential(parameters: dict[str, Tensor]) -> Tensor:
        fronts = parameters["fronts"][None]
        log_p = target.log_factor(fronts)[0] + log_cells
        return -(torch.logsumexp(log_p.reshape(-1), 0) + target.log_prior(fronts)[0])

    chain = MCMC(
        NUTS(potential_fn=potential, max_tree_depth=3),
        num_samples=draws,
        warmup_steps=warmup,
        initial_params={"fronts": likeliest_fronts(target)},
        disable_progbar=True,
    )
    chain.run()
    drawn: Tensor = chain.get_samples()["fronts"]
    return drawn


def likeliest_fronts(target: GivenFronts) -> Tensor:
    """Return the mean of the weightiest part of each front's prior, shape (J,)."""
    parts = [prior.parts for prior in target.priors]
    means = [max(p, key=lambda part: part.weight).mean_rad if p else 0.0 for p in parts]
    return torch.tensor(means, dtype=torch.float64)


def posterior_factor(target: GivenFronts, log_cells: Tensor, fronts: Tensor) -> NDArray[np.float64]:
    """Return log E[L / Z] over fronts drawn from their posterior, shape (C, K, S)."""
    with torch.no_grad():
        parts = []
        for chunk in fronts.split(64):
            factor = target.log_factor(chunk)
            log_z = torch.logsumexp((factor + log_cells).flatten(1), 1)
            parts.append(torch.logsumexp(factor - log_z[:, None, None, None], 0))
        mean = torch.logsumexp(torch.stack(parts), 0) - math.log(len(fronts))
    table: NDArray[np.float64] = mean.numpy()
    return table


def check_continuous(engine: str, targets: Sequence[GivenFronts], shared: tuple[str, ...]) -> None:
    """Refuse frames an engine with gradients cannot move through.

    Raises
    ------
    InputError : when some frame is a point, or frames are shared.
    """
    if shared:
        raise InputError(f"Engine '{engine}' takes no shared frames; use exact or enumerate")
    for target in targets:
        if any(math.isinf(part.kappa) for prior in target.priors for part in prior.parts):
            raise InputError(
                f"Engine '{engine}' needs frames with a density and got a point; use a model such "
                "as bayes, or the exact engine"
            )


@contextmanager
def seeded_torch(rng: np.random.Generator) -> Iterator[None]:
    """Seed torch's and Pyro's global generators from `rng`, and restore them afterwards."""
    before = pyro.util.get_rng_state()
    pyro.set_rng_seed(int(rng.integers(2**31)))
    try:
        yield
    finally:
        pyro.util.set_rng_state(before)


ENGINES.add("nuts", nuts)
