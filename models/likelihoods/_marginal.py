"""Sum the frame out of any likelihood: in its own closed form, else by quadrature."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol, runtime_checkable

import torch
from torch import Tensor

from sloop_ppl.models.frames import FrameDistribution, FramePart
from sloop_ppl.models.likelihoods._base import RelationLikelihood
from sloop_ppl.models.terms import RelationTerm

__all__ = ["ClosedFormMarginal", "frame_marginal", "marginal_over"]

_DIRECTIONS = 1440
_ELEMENTS = 1 << 19
_NARROW_KAPPA = 9.0  # narrower parts take directions of their own


@runtime_checkable
class ClosedFormMarginal(Protocol):
    """A likelihood that knows its own expectation over a frame."""

    def log_marginal(self, term: RelationTerm, frame: FrameDistribution) -> Tensor:
        """Return log E[g] over the frame of a frame relation, shape (S,)."""


def frame_marginal(
    likelihood: RelationLikelihood, term: RelationTerm, frame: FrameDistribution
) -> Tensor:
    """Return log E[g] of a frame relation over the direction its ground faces, shape (S,).

    Parameters
    ----------
    likelihood : its own ``log_marginal`` is used when it has one, else quadrature.
    term : a relation whose direction depends on the frame.
    frame : which way the ground faces.
    """
    if isinstance(likelihood, ClosedFormMarginal):
        return likelihood.log_marginal(term, frame)
    return marginal_over(frame, term.offset_rad, lambda angles: likelihood.log_g(term, angles))


def marginal_over(
    frame: FrameDistribution, offset_rad: float, log_g: Callable[[Tensor], Tensor]
) -> Tensor:
    """Return log E[g] over a frame by quadrature; points are exact, memory is bounded.

    Parameters
    ----------
    frame : which way the ground faces.
    offset_rad : direction of the relation less that of the front, radians.
    log_g : directions of the relation, shape (B,) -> log g, shape (B, S).

    Returns
    -------
    Tensor
        Shape (S,).

    Notes
    -----
    1440 directions round the circle, equally far apart: exact to rounding for smooth g, and to
    1e-6 in g for one with a kink such as max(0, cos). Parts narrower than kappa 9 take their
    own 1440 directions within nine standard deviations. A g that jumps in direction converges
    only like the width of a step: give such a likelihood a ``log_marginal`` of its own.
    Gradients flow into whatever `log_g` and the parts' concentrations depend on.
    """
    fronts, log_weight = _nodes(frame)
    angles = fronts + offset_rad
    first = log_g(angles[:1])
    total = first[0] + log_weight[0]
    step = max(1, _ELEMENTS // first.shape[-1])
    for start in range(1, len(angles), step):
        chunk = slice(start, start + step)
        some = torch.logsumexp(log_g(angles[chunk]) + log_weight[chunk, None], 0)
        total = torch.logaddexp(total, some)
    return total


def _nodes(frame: FrameDistribution) -> tuple[Tensor, Tensor]:
    """Return the fronts to visit and the log weight of each, shape (B,)."""
    circle = _circle()
    spread = torch.zeros(_DIRECTIONS, dtype=torch.float64) + frame.lapse / _DIRECTIONS
    fronts, weights = [], []
    for part in frame.parts:
        kappa = float(torch.as_tensor(part.kappa).detach())
        if math.isinf(kappa):
            fronts.append(torch.as_tensor(part.mean_rad, dtype=torch.float64).reshape(1))
            weights.append(torch.as_tensor(part.weight, dtype=torch.float64).reshape(1))
        elif kappa <= _NARROW_KAPPA:
            spread = spread + part.weight * _density(part, circle)
        else:
            near = part.mean_rad + circle * (9 / math.sqrt(kappa) / math.pi)
            fronts.append(near)
            weights.append(part.weight * _density(part, near))
    if bool((spread > 0).any()):
        fronts.append(circle)
        weights.append(spread)
    return torch.cat(fronts), torch.cat(weights).clamp_min(1e-300).log()


def _circle() -> Tensor:
    steps = torch.arange(_DIRECTIONS, dtype=torch.float64) + 0.5
    return steps * (2 * math.pi / _DIRECTIONS) - math.pi


def _density(part: FramePart, fronts: Tensor) -> Tensor:
    """Return a part's mass on equally spaced fronts, summing to one."""
    return torch.softmax(part.kappa * (torch.cos(fronts - part.mean_rad) - 1), 0)
