"""Exact inference: enumerate component and cell of the Pyro program, frames summed out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyro
import torch
from numpy.typing import NDArray
from pyro import poutine
from pyro.infer import config_enumerate
from torch import Tensor

from sloop_ppl.inference.engine import ENGINES, LogFactors
from sloop_ppl.maps import CityMap
from sloop_ppl.models import Evidence, Preset, RelationTerm, gather_evidence, observation_model

__all__ = ["enumerated_log_factors", "exact"]


def exact(
    terms: Sequence[tuple[RelationTerm, ...]],
    city: CityMap,
    model: Preset,
    *,
    log_prior: NDArray[np.float64],
    truths: Sequence[tuple[float, float]] | None = None,
    rng: np.random.Generator | None = None,  # noqa: ARG001 - nothing is drawn
) -> LogFactors:
    """Weigh component and cell of each target exactly.

    Parameters
    ----------
    terms : per target, what was said of it.
    city : the map.
    model : the observation model.
    log_prior : log belief over cells, shape (N, S).
    truths : true places, for models that need them.
    rng : ignored.
    """
    with torch.no_grad():
        evidence = gather_evidence(terms, city, model, truths)
    factors = enumerated_log_factors(evidence, torch.from_numpy(log_prior))
    return LogFactors(evidence.components, evidence.shared, factors.numpy())


def enumerated_log_factors(evidence: Evidence, log_prior: Tensor) -> Tensor:
    """Run the Pyro program with its discrete sites enumerated; return (N, C, K, S).

    Notes
    -----
    The joint table is contracted from the enumerated trace: `TraceEnum_ELBO.compute_marginals`
    gives single marginals only. The priors of cells and of shared frames are left out of the
    result, so that zeros in them can be put back without dividing by zero.
    """
    c, n, k, _, s = evidence.log_truth.shape
    enumerated = poutine.enum(config_enumerate(observation_model), first_available_dim=-3)
    with pyro.validation_enabled(False), torch.no_grad():
        trace = poutine.trace(enumerated).get_trace(evidence, log_prior)
        trace.compute_log_prob(lambda name, _: name in ("component", "normaliser", "truth"))
    sites = trace.nodes
    # Enumerated dimensions are laid out from the right: shared, component, cell.
    log_joint: Tensor = (
        sites["component"]["log_prob"]
        + sites["normaliser"]["log_prob"]
        + sites["truth"]["log_prob"].sum(-1, keepdim=True)
    )
    full = (s, k, c, n, 1) if c > 1 else (s, k, n, 1)
    return log_joint.expand(full).reshape(s, k, c, n).permute(3, 2, 1, 0).contiguous()


ENGINES.add("exact", exact)
