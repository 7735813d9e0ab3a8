"""Whether a relation is true, as a distribution that keeps its probability in log space."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from pyro.distributions import TorchDistribution, constraints
from torch import Tensor

from sloop_ppl.models.logspace import log1mexp

__all__ = ["TruthValue"]


class TruthValue(TorchDistribution):
    """A Bernoulli given the log of its probability.

    Parameters
    ----------
    log_g : log probability of truth, at most 0.

    Notes
    -----
    Pyro's Bernoulli clamps probabilities near the rounding error of one, which turns a log
    probability of -100 into -16.
    """

    arg_constraints = {"log_g": constraints.real}  # noqa: RUF012 - torch's interface
    support = constraints.boolean

    def __init__(self, log_g: Tensor, validate_args: bool | None = None) -> None:
        self.log_g = log_g
        super().__init__(log_g.shape, validate_args=validate_args)

    def expand(
        self, batch_shape: Sequence[int], _instance: TorchDistribution | None = None
    ) -> TruthValue:
        """Return the same distribution over a larger batch."""
        return TruthValue(self.log_g.expand(tuple(batch_shape)), validate_args=False)

    def sample(self, sample_shape: Sequence[int] = ()) -> Tensor:
        """Draw truth values, 0. or 1."""
        shape = self._extended_shape(torch.Size(sample_shape))
        uniform = torch.rand(shape, dtype=self.log_g.dtype)
        return (uniform.log() < self.log_g).to(self.log_g.dtype)

    def log_prob(self, value: Tensor) -> Tensor:
        """Return log g where the value is 1 and log(1 - g) where it is 0."""
        true = value > 0.5
        if bool(true.all()):
            return self.log_g.expand(torch.broadcast_shapes(self.log_g.shape, value.shape))
        return torch.where(true, self.log_g, log1mexp(self.log_g))
