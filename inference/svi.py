"""Variational inference over the fronts, component and cell enumerated out of the bound."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyro
import pyro.distributions as dist
import torch
from numpy.typing import NDArray
from pyro import optim
from pyro.infer import SVI, Trace_ELBO
from pyro.infer.autoguide import AutoNormal, init_to_value
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.inference.conditional import GivenFronts, given_fronts
from sloop_ppl.inference.engine import ENGINES, LogFactors
from sloop_ppl.inference.nuts import (
    check_continuous,
    likeliest_fronts,
    posterior_factor,
    seeded_torch,
)
from sloop_ppl.maps import CityMap
from sloop_ppl.models import Preset, RelationTerm

__all__ = ["svi"]


def svi(
    terms: Sequence[tuple[RelationTerm, ...]],
    city: CityMap,
    model: Preset,
    *,
    log_prior: NDArray[np.float64],
    truths: Sequence[tuple[float, float]] | None = None,
    rng: np.random.Generator | None = None,
    steps: int = 300,
    draws: int = 500,
) -> LogFactors:
    """Fit a normal guide to each front and average the posterior of component and cell over it.

    Parameters
    ----------
    terms, city, model, log_prior, truths : as for the exact engine.
    rng : seeds the gradients; required.
    steps : gradient steps, > 0.
    draws : fronts drawn from the guide, > 0.

    Raises
    ------
    InputError : when `rng` is missing, or frames are points or shared.

    Notes
    -----
    The guide (Pyro's AutoNormal) has one mode, so it is a cross-check where fronts have one.
    """
    if rng is None:
        raise InputError("Engine 'svi' draws; give rng=numpy.random.default_rng(seed)")
    evidence, targets = given_fronts(terms, city, model, truths)
    check_continuous("svi", targets, evidence.shared.grounds)
    tables = []
    for target, log_cells in zip(targets, torch.from_numpy(log_prior), strict=True):
        fronts = torch.zeros(1, 0, dtype=torch.float64)
        if target.terms:
            with seeded_torch(rng), pyro.get_param_store().scope():
                fronts = _fit(target, log_cells, steps, draws)
        tables.append(posterior_factor(target, log_cells, fronts))
    return LogFactors(evidence.components, evidence.shared, np.stack(tables))


def _fit(target: GivenFronts, log_cells: Tensor, steps: int, draws: int) -> Tensor:
    count = len(target.priors)

    def program() -> Tensor:
        # The masked site only names the latent; its prior is part of the factor.
        unweighed = dist.Normal(0.0, 1e3).expand([count]).to_event(1).mask(False)
        fronts = pyro.sample("fronts", unweighed).double()[None]
        log_p = target.log_factor(fronts)[0] + log_cells
        pyro.factor("said", torch.logsumexp(log_p.reshape(-1), 0) + target.log_prior(fronts)[0])
        return fronts

    start = init_to_value(values={"fronts": likeliest_fronts(target).float()})
    guide = AutoNormal(program, init_loc_fn=start, init_scale=0.5)
    adam = optim.PyroOptim(torch.optim.Adam, {"lr": 0.03})
    fit = SVI(program, guide, adam, Trace_ELBO(num_particles=4))
    for _ in range(steps):
        fit.step()
    with torch.no_grad():
        drawn = [guide()["fronts"].double() for _ in range(draws)]
    return torch.stack(drawn)


ENGINES.add("svi", svi)
