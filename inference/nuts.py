"""NUTS over the fronts, component and cell enumerated out of the potential."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from pyro.infer import MCMC, NUTS
from torch import Tensor

from sloop_ppl.inference.conditional import GivenFronts
from sloop_ppl.inference.continuous import infer_by_fronts, likeliest_fronts
from sloop_ppl.inference.engine import ENGINES, LogFactors
from sloop_ppl.maps import CityMap
from sloop_ppl.models import Preset, RelationTerm

__all__ = ["nuts"]


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
    """Draw fronts from their posterior by NUTS.

    Parameters
    ----------
    terms, city, model, log_prior, truths, rng : and what they raise, as for
        :func:`sloop_ppl.inference.continuous.infer_by_fronts`.
    warmup, draws : steps of the chain that are dropped and kept, > 0.

    Notes
    -----
    Angles are not wrapped: the potential has period 2 pi. A cross-check for single modes; a chain
    may miss the second front of a street.
    """

    def chain(target: GivenFronts, log_cells: Tensor) -> Tensor:
        def potential(parameters: dict[str, Tensor]) -> Tensor:
            fronts = parameters["fronts"][None]
            log_p = target.log_factor(fronts)[0] + log_cells
            return -(torch.logsumexp(log_p.reshape(-1), 0) + target.log_prior(fronts)[0])

        run = MCMC(
            NUTS(potential_fn=potential, max_tree_depth=3),
            num_samples=draws,
            warmup_steps=warmup,
            initial_params={"fronts": likeliest_fronts(target)},
            disable_progbar=True,
        )
        run.run()
        drawn: Tensor = run.get_samples()["fronts"]
        return drawn

    return infer_by_fronts(
        "nuts", chain, terms, city, model, log_prior=log_prior, truths=truths, rng=rng
    )


ENGINES.add("nuts", nuts)
