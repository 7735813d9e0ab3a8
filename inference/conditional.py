"""A target's log factors given the fronts its phrases take, for engines that draw fronts."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sloop_ppl.maps import CityMap
from sloop_ppl.models import (
    Evidence,
    FrameDistribution,
    Preset,
    RelationTerm,
    front_prior,
    gather_evidence,
    log_phrase_given_front,
)

__all__ = ["GivenFronts", "given_fronts"]


class GivenFronts:
    """What was said of one target as a function of the fronts of its frame phrases.

    Shape legend: J phrases with a front of their own, C settings of shared frames, K components,
    S cells, n draws.

    Parameters
    ----------
    evidence : the description, scored.
    target : position of the target in it.
    terms : what was said of the target.
    model : the observation model.
    """

    def __init__(
        self, evidence: Evidence, target: int, terms: tuple[RelationTerm, ...], model: Preset
    ) -> None:
        self._model = model
        own = [
            term
            for term in terms
            if front_prior(term, model) is not None and term.ground not in evidence.shared.grounds
        ]
        self.terms = tuple(own) if any(c.uses_frames for c in model.components) else ()
        priors = [front_prior(term, model) for term in self.terms]
        self.priors: tuple[FrameDistribution, ...] = tuple(p for p in priors if p is not None)
        rows = evidence.log_truth[:, target]
        weight = evidence.log_weight[target][None, :, None]
        self._fixed = weight + rows.sum(2) + evidence.log_normaliser[:, target]
        self._uses = torch.tensor([c.uses_frames for c in model.components])
        with torch.no_grad():
            self._marginal = [
                torch.logsumexp(self._phrase(j, *prior_bins(prior)), 0)
                for j, prior in enumerate(self.priors)
            ]

    def log_factor(self, fronts_rad: Tensor) -> Tensor:
        """Return the log factor for each draw of the fronts.

        Parameters
        ----------
        fronts_rad : shape (n, J).

        Returns
        -------
        Tensor
            Shape (n, C, K, S); its mean over draws from the priors is the exact factor.
        """
        total = self._fixed[None].expand(len(fronts_rad), -1, -1, -1)
        for j in range(len(self.terms)):
            given = log_phrase_given_front(self.terms[j], self._model, fronts_rad[:, j])
            change = given - self._marginal[j]
            total = total + torch.where(
                self._uses[None, None, :, None], change[:, None, None, :], 0.0
            )
        return total

    def log_prior(self, fronts_rad: Tensor) -> Tensor:
        """Return the log prior density of fronts, differentiable, shape (n,)."""
        total = torch.zeros(len(fronts_rad), dtype=torch.float64)
        for j, prior in enumerate(self.priors):
            parts = [
                math.log(part.weight)
                + part.kappa * (torch.cos(fronts_rad[:, j] - part.mean_rad) - 1)
                - math.log(2 * math.pi)
                - torch.special.i0e(torch.tensor(part.kappa, dtype=torch.float64)).log()
                for part in prior.parts
            ]
            if prior.lapse:
                level = math.log(prior.lapse / (2 * math.pi))
                parts.append(torch.full_like(fronts_rad[:, j], level))
            total = total + torch.logsumexp(torch.stack(parts), 0)
        return total

    def draw(self, n: int, rng: np.random.Generator) -> Tensor:
        """Draw fronts from their priors, shape (n, J)."""
        columns = [_draw(prior, n, rng) for prior in self.priors]
        return torch.from_numpy(np.stack(columns, 1) if columns else np.zeros((n, 0)))

    def _phrase(self, j: int, fronts: NDArray[np.float64], log_mass: Tensor) -> Tensor:
        given = log_phrase_given_front(self.terms[j], self._model, torch.from_numpy(fronts))
        return given + log_mass[:, None]


def prior_bins(prior: FrameDistribution) -> tuple[NDArray[np.float64], Tensor]:
    """Return angles that stand for a frame prior and their log probabilities."""
    fronts, mass = prior.bins(720)
    return fronts, torch.from_numpy(np.maximum(mass, 1e-300)).log()


def given_fronts(
    terms: Sequence[tuple[RelationTerm, ...]],
    city: CityMap,
    model: Preset,
    truths: Sequence[tuple[float, float]] | None,
) -> tuple[Evidence, list[GivenFronts]]:
    """Return the evidence of a description and, per target, its factors given fronts."""
    with torch.no_grad():  # the fronts may move; the model stands still
        evidence = gather_evidence(terms, city, model, truths)
    return evidence, [GivenFronts(evidence, i, said, model) for i, said in enumerate(terms)]


def _draw(prior: FrameDistribution, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Draw n fronts, spread evenly over the prior's mass: each by itself is a draw from it."""
    weights = np.array([*(part.weight for part in prior.parts), prior.lapse])
    edges = np.concatenate([[0.0], np.cumsum(weights / weights.sum())])
    level = (rng.permutation(n) + rng.random(n)) / n
    which = np.clip(np.searchsorted(edges, level, side="right") - 1, 0, len(weights) - 1)
    within = (level - edges[which]) / np.maximum(edges[which + 1] - edges[which], 1e-300)
    drawn: NDArray[np.float64] = math.pi * (2 * within - 1)
    for i, part in enumerate(prior.parts):
        chosen = which == i
        if math.isinf(part.kappa):
            drawn[chosen] = part.mean_rad
        else:
            drawn[chosen] = part.mean_rad + _von_mises_quantile(within[chosen], part.kappa)
    return drawn


def _von_mises_quantile(level: NDArray[np.float64], kappa: float) -> NDArray[np.float64]:
    """Return angles less the mean below which a von Mises distribution has this much mass."""
    reach = min(math.pi, 12 / math.sqrt(max(kappa, 1e-9)))
    angles = np.linspace(-reach, reach, 4097)
    density = np.exp(kappa * (np.cos(angles) - 1))
    mass = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2)])
    found: NDArray[np.float64] = np.interp(level, mass / mass[-1], angles)
    return found
