"""What a description, and where its target may be, tell about the frames that were used."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from sloop_ppl.inference.summaries import circular_summary
from sloop_ppl.models import FramePart, Preset, RelationTerm
from sloop_ppl.models.evidence import asserted_log_g, log_denied

__all__ = ["FrameSummary", "summarise_frame"]

_BINS = 360


@dataclass(frozen=True)
class FrameSummary:
    """One part of the posterior over the direction a ground faces.

    Parameters
    ----------
    ground : id of the landmark.
    relation : the relation whose frame it is.
    mean_rad : mean direction of the ground's front, radians anticlockwise from east.
    kappa : concentration of the part; None for a point.
    p : posterior probability of the part; what is missing to one is the lapse.
    """

    ground: str
    relation: str
    mean_rad: float
    kappa: float | None
    p: float


def summarise_frame(
    term: RelationTerm,
    model: Preset,
    used: NDArray[np.float64],
    unused: float,
) -> tuple[FrameSummary, ...]:
    """Return the posterior of each part of a frame's prior, most probable first.

    Parameters
    ----------
    term : a frame relation.
    model : the observation model.
    used : posterior probability of each cell jointly with a component that uses the frame,
        shape (S,).
    unused : posterior probability of the components that do not; they leave the prior.

    Notes
    -----
    p(psi | said) = p(psi) [unused + sum_s used(s) g(s, psi) / E_psi g(s, psi)].
    """
    prior = model.frame_prior(term)
    cells = np.flatnonzero(used > 1e-7 * max(used.max(), 1e-300))
    marginal = asserted_log_g(term, model)
    if term.negated:
        marginal = log_denied(marginal)
    shares = torch.from_numpy(used[cells]).log() - marginal[cells]

    def ratio(fronts: NDArray[np.float64]) -> NDArray[np.float64]:
        directions = torch.from_numpy(fronts + term.offset_rad)
        log_g = model.likelihood.log_g(term, directions)[:, cells]
        if term.negated:
            log_g = log_denied(log_g)
        return np.asarray(unused + torch.exp(log_g + shares).sum(-1).numpy())

    angles = np.linspace(-math.pi, math.pi, _BINS, endpoint=False)
    parts = [_part(part, angles, ratio) for part in prior.parts]
    lapse = prior.lapse * float(ratio(angles).mean()) if prior.lapse else 0.0
    total = sum(weight for weight, _, _ in parts) + lapse
    summaries = [
        FrameSummary(term.ground, term.relation, mean, kappa, weight / total)
        for weight, mean, kappa in parts
    ]
    return tuple(sorted(summaries, key=lambda s: -s.p))


def _part(
    part: FramePart,
    angles: NDArray[np.float64],
    ratio: Callable[[NDArray[np.float64]], NDArray[np.float64]],
) -> tuple[float, float, float | None]:
    """Return the unnormalised posterior weight, mean and concentration of one part."""
    if math.isinf(part.kappa):
        return part.weight * float(ratio(np.array([part.mean_rad]))[0]), part.mean_rad, None
    density = np.exp(part.log_density(angles))
    density /= density.sum()
    weighed = density * ratio(angles)
    mean, kappa = circular_summary(weighed, angles)
    return part.weight * float(weighed.sum()), mean, kappa
