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

from sloop_ppl.inference.conditional import GivenFronts
from sloop_ppl.inference.continuous import infer_by_fronts, likeliest_fronts
from sloop_ppl.inference.engine import ENGINES, LogFactors
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
    """Fit a normal guide to each front and draw fronts from it.

    Parameters
    ----------
    terms, city, model, log_prior, truths, rng : and what they raise, as for
        :func:`sloop_ppl.inference.continuous.infer_by_fronts`.
    steps : gradient steps, > 0.
    draws : fronts drawn from the guide, > 0.

    Notes
    -----
    The guide (Pyro's AutoNormal) has one mode and no uniform tails, so it is a cross-check where
    fronts have one mode and little lapse; with a lapse of .15 beliefs are up to .2 in total
    variation from exact.
    """

    def fit(target: GivenFronts, log_cells: Tensor) -> Tensor:
        with pyro.get_param_store().scope():
            return _fit(target, log_cells, steps, draws)

    return infer_by_fronts(
        "svi", fit, terms, city, model, log_prior=log_prior, truths=truths, rng=rng
    )


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
    stepper = SVI(program, guide, adam, Trace_ELBO(num_particles=4))
    for _ in range(steps):
        stepper.step()
    with torch.no_grad():
        drawn = [guide()["fronts"].double() for _ in range(draws)]
    return torch.stack(drawn)


ENGINES.add("svi", svi)
