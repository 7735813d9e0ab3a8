"""The generative model of a description, as a Pyro program."""

from __future__ import annotations

import pyro
import pyro.distributions as dist
import torch
from torch import Tensor

from sloop_ppl.models.evidence import Evidence
from sloop_ppl.models.lookup import look_up
from sloop_ppl.models.truth import TruthValue

__all__ = ["observation_model"]


def observation_model(evidence: Evidence, log_prior: Tensor) -> tuple[Tensor, Tensor]:
    """Draw a component and a cell for each target and observe that what was said is true.

    Shape legend: N targets, K components, L factors, S cells, C settings of shared frames.

    Parameters
    ----------
    evidence : what was said, scored at every cell, frames that are not shared summed out.
    log_prior : log belief over cells before anything was said, shape (N, S).

    Returns
    -------
    tuple of Tensor
        The component and the cell of each target, shape (N, 1) unless enumerated.

    Notes
    -----
    Source: SLOOP eq. (4), as a generative program: component z ~ Categorical(w), cell s ~
    Categorical(prior), truth_j ~ Bernoulli(g_z(r_j | ground_j, psi_j, s)) observed true. Frames
    psi_j of one phrase are independent given the cell and are summed out beforehand; those that
    phrases share are the site ``shared``. The ``normaliser`` factor makes a component a
    distribution over cells under a uniform map.
    """
    _, targets, _, factors, _ = evidence.log_truth.shape
    target = torch.arange(targets)[:, None]
    shared = torch.tensor(0)
    if evidence.shared.grounds:
        shared = pyro.sample("shared", dist.Categorical(logits=evidence.shared.log_prior))
    with pyro.plate("target", targets, dim=-2):
        component = pyro.sample("component", dist.Categorical(logits=evidence.log_weight[:, None]))
        cell = pyro.sample("cell", dist.Categorical(logits=log_prior[:, None]))
        index = (shared, target, component)
        pyro.factor("normaliser", look_up(evidence.log_normaliser, (*index, cell)))
        with pyro.plate("factor", factors, dim=-1):
            log_g = look_up(evidence.log_truth, (*index, torch.arange(factors), cell))
            pyro.sample("truth", TruthValue(log_g), obs=torch.ones(targets, factors))
    return component, cell
