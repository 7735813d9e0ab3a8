"""Sum the frame out of any likelihood: in its own closed form, else by quadrature."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Protocol, runtime_checkable

import torch
from torch import Tensor
from torch.utils.checkpoint import checkpoint

from sloop_ppl.models.frames import FrameDistribution, FramePart
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.models.likelihoods._base import RelationLikelihood

__all__ = ["ClosedFormMarginal", "frame_marginal", "marginal_over", "summed_within"]

_DIRECTIONS = 1440  # a quarter of a degree; `marginal_over` says how exact that is
_FEWEST, _DOUBLINGS = 32, 5  # 32 and as many between them, doubled up to 1024 and as many again
_ELEMENTS = 1 << 19  # numbers of one chunk of log g, 4 MiB
# Narrower parts take directions of their own, within nine deviations of 1 / sqrt(kappa): from 9 on
# these lie within half a turn, 9 / 3 < pi, and leave out less than 1e-8 of the part.
_NARROW_KAPPA = 9.0


@runtime_checkable
class ClosedFormMarginal(Protocol):
    """A likelihood that knows its own expectation over a frame."""

    def log_marginal(self, term: GroundedRelation, frame: FrameDistribution) -> Tensor:
        """Return log E[g] over the frame of a frame relation, shape (S,)."""


def frame_marginal(
    likelihood: RelationLikelihood, term: GroundedRelation, frame: FrameDistribution
) -> Tensor:
    """Return log E[g] of a frame relation over the direction its ground faces, shape (S,).

    Parameters
    ----------
    likelihood
        Its own ``log_marginal`` is used when it has one, else quadrature.
    term
        A relation whose direction depends on the frame.
    frame
        Which way the ground faces.
    """
    if isinstance(likelihood, ClosedFormMarginal):
        return likelihood.log_marginal(term, frame)
    return marginal_over(frame, term.offset_rad, lambda angles: likelihood.log_g(term, angles))


@contextmanager
def summed_within(tolerance: float) -> Iterator[None]:
    """Let `marginal_over` take fewer directions in this block where they are enough.

    Parameters
    ----------
    tolerance
        How far two sums over n directions, those of one halfway between those of the other, may
        lie apart in any cell's log E[g]; their mean is taken, a sum over 2 n directions.

    Notes
    -----
    For learning, which asks for the same marginals hundreds of times. A smooth g takes 64
    directions and is then exact to rounding, one with a kink some hundreds, and one that jumps
    all 1440, as without this. It holds in this thread alone.
    """
    before = _TOLERANCE.set(tolerance)
    try:
        yield
    finally:
        _TOLERANCE.reset(before)


_TOLERANCE: ContextVar[float | None] = ContextVar("tolerance", default=None)


def marginal_over(
    frame: FrameDistribution, offset_rad: float, log_g: Callable[[Tensor], Tensor]
) -> Tensor:
    """Return log E[g] over a frame by quadrature; points are exact, memory is bounded.

    Parameters
    ----------
    frame
        Which way the ground faces.
    offset_rad
        Direction of the relation less that of the front, radians.
    log_g
        Directions of the relation, shape (B,) -> log g, shape (B, S).

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
    Gradients flow into whatever `log_g` and the parts' concentrations depend on. In a block of
    `summed_within` fewer directions are taken where they are enough.
    """
    tolerance = _TOLERANCE.get()
    if tolerance is not None:
        few = _few_directions(frame, offset_rad, log_g, tolerance)
        if few is not None:
            return few
    angles, log_weight = _nodes(frame, _DIRECTIONS, 0.5)
    return _summed(angles + offset_rad, log_weight, log_g)


def _few_directions(
    frame: FrameDistribution,
    offset_rad: float,
    log_g: Callable[[Tensor], Tensor],
    tolerance: float,
) -> Tensor | None:
    """Return log E[g] over as few directions as a tolerance allows; None when it takes all."""

    def over(count: int, shift: float) -> Tensor:
        angles, log_weight = _nodes(frame, count, shift)
        return _summed(angles + offset_rad, log_weight, log_g)

    count, total, before = _FEWEST, over(_FEWEST, 0.0), math.inf
    for more in reversed(range(_DOUBLINGS)):
        between = over(count, 0.5)
        apart = float((total.detach() - between.detach()).abs().max())
        total = torch.logaddexp(total, between) - math.log(2)
        if apart <= tolerance:
            return total
        # What is off by half as much, or a quarter, after each doubling will go on like that; if
        # even the last will not do, or all this is no number, no more are tried.
        if before < math.inf and not apart * (apart / before) ** more <= tolerance:
            return None
        count, before = 2 * count, apart
    return None


def _summed(angles: Tensor, log_weight: Tensor, log_g: Callable[[Tensor], Tensor]) -> Tensor:
    """Return the log of a weighted sum of g over directions, in bounded memory, shape (S,)."""
    first = log_g(angles[:1])
    total = first[0] + log_weight[0]
    step = max(1, _ELEMENTS // first.shape[-1])

    def over(some: Tensor, log_share: Tensor) -> Tensor:
        return torch.logsumexp(log_g(some) + log_share[:, None], 0)

    # What a gradient needs of many chunks would fill gigabytes over a map; it is made once more.
    again = total.requires_grad and len(angles) > 2 * step
    for start in range(1, len(angles), step):
        chunk = angles[start : start + step], log_weight[start : start + step]
        some = checkpoint(over, *chunk, use_reentrant=False) if again else over(*chunk)
        total = torch.logaddexp(total, some)
    return total


def _nodes(frame: FrameDistribution, count: int, shift: float) -> tuple[Tensor, Tensor]:
    """Return the fronts to visit and the log weight of each, shape (B,).

    Parameters
    ----------
    count
        Directions round the circle, and within each narrow part, > 0.
    shift
        Where the first lies, in steps from the circle's start.
    """
    circle = _circle(count, shift)
    spread = torch.zeros(count, dtype=torch.float64) + frame.lapse / count
    angles, weights = [], []
    for part in frame.parts:
        kappa = float(torch.as_tensor(part.kappa).detach())
        if math.isinf(kappa):
            angles.append(torch.as_tensor(part.mean_rad, dtype=torch.float64).reshape(1))
            weights.append(torch.as_tensor(part.weight, dtype=torch.float64).reshape(1))
        elif kappa <= _NARROW_KAPPA:
            spread = spread + part.weight * _density(part, circle)
        else:
            near = part.mean_rad + circle * (9 / math.sqrt(kappa) / math.pi)
            angles.append(near)
            weights.append(part.weight * _density(part, near))
    if bool((spread > 0).any()):
        angles.append(circle)
        weights.append(spread)
    return torch.cat(angles), torch.cat(weights).clamp_min(1e-300).log()


def _circle(count: int, shift: float) -> Tensor:
    steps = torch.arange(count, dtype=torch.float64) + shift
    return steps * (2 * math.pi / count) - math.pi


def _density(part: FramePart, angles: Tensor) -> Tensor:
    """Return a part's mass on equally spaced fronts, summing to one."""
    return torch.softmax(part.kappa * (torch.cos(angles - part.mean_rad) - 1), 0)
