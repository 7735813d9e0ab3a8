"""What a description, and where its target may be, tell about the frames that were used."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import torch
from numpy.typing import NDArray

from sloop_ppl.inference.summaries import circular_summary
from sloop_ppl.models import (
    FrameDistribution,
    FramePart,
    Preset,
    RelationTerm,
    SharedFrames,
    front_prior,
    log_phrase,
    log_phrase_given_front,
)

if TYPE_CHECKING:
    from sloop_ppl.inference.posterior import Posterior

__all__ = ["FrameSummary", "summarise_frame", "summarise_frames", "summarise_shared_frame"]

Ratio = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Posterior over prior density of fronts, up to a constant."""

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


@torch.no_grad()
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
    cells = np.flatnonzero(used > 1e-7 * max(used.max(), 1e-300))
    shares = torch.from_numpy(used[cells]).log() - log_phrase(term, model)[cells]

    def ratio(fronts: NDArray[np.float64]) -> NDArray[np.float64]:
        log_p = log_phrase_given_front(term, model, fronts)[:, cells]
        return np.asarray(unused + torch.exp(log_p + shares).sum(-1).numpy())

    return _summaries(term, _prior(term, model), ratio)


def summarise_shared_frame(
    term: RelationTerm, model: Preset, shared: SharedFrames, settings: NDArray[np.float64]
) -> tuple[FrameSummary, ...]:
    """Return the posterior of each part of a shared frame's prior, most probable first.

    Parameters
    ----------
    term : a frame relation whose ground's front is shared.
    model : the observation model.
    shared : the frames that are shared.
    settings : posterior of their joint settings, shape (C,).
    """
    prior = _prior(term, model)
    fronts = shared.fronts_rad[:, shared.grounds.index(term.ground)]
    angles, mass = prior.bins(len(np.unique(fronts)))
    posterior = np.array([settings[np.isclose(fronts, angle)].sum() for angle in angles])
    gain = posterior / np.maximum(mass, 1e-300)

    def ratio(at: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.interp(at, angles, gain, period=2 * math.pi)

    return _summaries(term, prior, ratio)


def summarise_frames(posterior: Posterior, target: str) -> tuple[FrameSummary, ...]:
    """Return the posterior of every frame that was used in speaking of a target.

    Parameters
    ----------
    posterior : what is believed.
    target : id of the target.
    """
    model, coupling = posterior.model, posterior._coupling
    uses = np.array([part.uses_frames for part in model.components])
    summaries: list[FrameSummary] = []
    for which, said in enumerate(posterior._said(target)):
        framed = [term for term in said.terms if term.needs_frame and uses.any()]
        joint = coupling.joint(target, which) if framed else np.zeros((1, len(uses), 0))
        for term in framed:
            if term.ground in said.shared.grounds:
                settings = coupling.settings(said)
                summaries += summarise_shared_frame(term, model, said.shared, settings)
            else:
                used, unused = joint[:, uses].sum((0, 1)), float(joint[:, ~uses].sum())
                summaries += summarise_frame(term, model, used, unused)
    return tuple(summaries)


def _prior(term: RelationTerm, model: Preset) -> FrameDistribution:
    prior = front_prior(term, model)
    return model.frame_prior(term) if prior is None else prior


def _summaries(
    term: RelationTerm, prior: FrameDistribution, ratio: Ratio
) -> tuple[FrameSummary, ...]:
    """Weigh each part of a prior by how much likelier its fronts have become."""
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
    ratio: Ratio,
) -> tuple[float, float, float | None]:
    """Return the unnormalised posterior weight, mean and concentration of one part."""
    if math.isinf(part.kappa):
        return part.weight * float(ratio(np.array([part.mean_rad]))[0]), part.mean_rad, None
    density = np.exp(part.log_density(angles))
    density /= density.sum()
    weighed = density * ratio(angles)
    mean, kappa = circular_summary(weighed, angles)
    return part.weight * float(weighed.sum()), mean, kappa
