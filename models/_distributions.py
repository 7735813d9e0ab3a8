"""Distributions of the program's sites that Pyro does not have as they are needed here."""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from pyro.distributions import Categorical, TorchDistribution, constraints
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.models._logspace import log1mexp
from sloop_ppl.models.frames import FrameDistribution, FramePart

__all__ = ["FrameDensity", "LogBernoulli", "categorical"]


def categorical(log_p: Tensor) -> Categorical:
    """Return a Categorical over the last axis, with at least two values.

    Pyro's enumeration drops axes of length one (pyro #3102), so a support of one value gets an
    impossible twin.
    """
    if log_p.shape[-1] == 1:
        log_p = torch.cat([log_p, torch.full_like(log_p, -math.inf)], -1)
    return Categorical(logits=log_p, validate_args=False)


class LogBernoulli(TorchDistribution):
    """A Bernoulli given the log of its probability.

    Parameters
    ----------
    log_p
        Log probability of 1, at most 0 up to what normalises it.

    Notes
    -----
    Pyro's Bernoulli clamps probabilities near the rounding error of one, which turns a log
    probability of -100 into -16; its logits are NaN at a log probability of 0.
    """

    arg_constraints = {"log_p": constraints.real}  # noqa: RUF012 - torch's interface
    support = constraints.boolean

    def __init__(self, log_p: Tensor, validate_args: bool | None = None) -> None:
        self.log_p = log_p
        super().__init__(log_p.shape, validate_args=validate_args)

    def expand(
        self, batch_shape: Sequence[int], _instance: TorchDistribution | None = None
    ) -> LogBernoulli:
        """Return the same distribution over a larger batch."""
        return LogBernoulli(self.log_p.expand(tuple(batch_shape)), validate_args=False)

    def sample(self, sample_shape: Sequence[int] = ()) -> Tensor:
        """Draw values, 0. or 1."""
        shape = self._extended_shape(torch.Size(sample_shape))
        uniform = torch.rand(shape, dtype=self.log_p.dtype)
        return (uniform.log() < self.log_p).to(self.log_p.dtype)

    def log_prob(self, value: Tensor) -> Tensor:
        """Return log p where the value is 1 and log(1 - p) where it is 0."""
        true = value > 0.5
        if value.numel() == 1 and bool(true):
            return self.log_p
        if bool(true.all()):
            return self.log_p.expand(torch.broadcast_shapes(self.log_p.shape, value.shape))
        return torch.where(true, self.log_p, log1mexp(self.log_p))


class FrameDensity(TorchDistribution):
    """A frame distribution as a density over angles, for engines that move through them.

    Parameters
    ----------
    frame
        Von Mises parts and a uniform lapse. A part that is a point can be drawn, but has no
        density.

    Notes
    -----
    Its support is the whole line: angles are not wrapped, and the density has period 2 pi.
    """

    arg_constraints = {}  # noqa: RUF012 - torch's interface
    support = constraints.real

    def __init__(
        self,
        frame: FrameDistribution,
        batch_shape: Sequence[int] = (),
        validate_args: bool | None = None,
    ) -> None:
        self.frame = frame
        super().__init__(torch.Size(batch_shape), validate_args=validate_args)

    def expand(
        self, batch_shape: Sequence[int], _instance: TorchDistribution | None = None
    ) -> FrameDensity:
        """Return the same distribution over a larger batch."""
        return FrameDensity(self.frame, batch_shape, validate_args=False)

    def sample(self, sample_shape: Sequence[int] = ()) -> Tensor:
        """Draw angles, radians."""
        shape = self._extended_shape(torch.Size(sample_shape))
        parts = self.frame.parts
        weights = torch.tensor([*(p.weight for p in parts), self.frame.lapse], dtype=torch.float64)
        drawn = torch.multinomial(weights, max(shape.numel(), 1), replacement=True)
        angles = math.pi * (2 * torch.rand(drawn.shape, dtype=torch.float64) - 1)
        for i, part in enumerate(parts):
            own = drawn == i
            angles[own] = _drawn(part, int(own.sum()))
        return angles.reshape(shape)

    def log_prob(self, value: Tensor) -> Tensor:
        """Return the log density at some angles.

        Raises
        ------
        InputError
            When a part is a point.
        """
        densities = []
        for part in self.frame.parts:
            kappa = torch.as_tensor(part.kappa, dtype=torch.float64)
            if bool(torch.isinf(kappa)):
                raise InputError(
                    "A frame is a point, which has no density; expected a model with spread "
                    "frames such as bayes, or frames='bins'"
                )
            level = math.log(2 * math.pi) + torch.special.i0e(kappa).log()
            weight = torch.as_tensor(part.weight, dtype=torch.float64).log()
            densities.append(weight + kappa * (torch.cos(value - part.mean_rad) - 1) - level)
        if self.frame.lapse:
            lapse = torch.as_tensor(self.frame.lapse, dtype=torch.float64).log()
            densities.append(torch.zeros_like(value) + lapse - math.log(2 * math.pi))
        log_p = torch.logsumexp(torch.stack(densities), 0)
        return log_p.expand(torch.broadcast_shapes(log_p.shape, self.batch_shape))


def _drawn(part: FramePart, count: int) -> Tensor:
    kappa = float(part.kappa)
    if math.isinf(kappa):
        return torch.full((count,), part.mean_rad, dtype=torch.float64)
    if kappa < 1e-9:
        return math.pi * (2 * torch.rand(count, dtype=torch.float64) - 1)
    mean, spread = (torch.tensor(x, dtype=torch.float64) for x in (part.mean_rad, kappa))
    drawn: Tensor = torch.distributions.VonMises(mean, spread).sample((count,))
    return drawn
