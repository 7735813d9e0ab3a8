"""A distribution over angles that sit on a grid, so that Pyro can enumerate them."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from pyro.distributions import TorchDistribution, constraints
from torch import Tensor

__all__ = ["Atoms"]


class Atoms(TorchDistribution):
    """Angles with a probability each; the value of a site is the angle itself, radians.

    Parameters
    ----------
    values : the angles, shape (B,).
    log_mass : their log probabilities, shape (B,).

    Notes
    -----
    A value between the angles counts as the one nearest to it, so that a site can be conditioned
    on any angle.
    """

    arg_constraints = {"log_mass": constraints.real_vector}  # noqa: RUF012 - torch's interface
    support = constraints.real
    has_enumerate_support = True

    def __init__(self, values: Tensor, log_mass: Tensor, validate_args: bool | None = None) -> None:
        self.values, self.log_mass = values, log_mass - torch.logsumexp(log_mass, -1)
        super().__init__(torch.Size(), validate_args=validate_args)

    def expand(
        self, batch_shape: Sequence[int], _instance: TorchDistribution | None = None
    ) -> Atoms:
        """Return the same distribution; batches of it are independent draws of one angle."""
        new = Atoms(self.values, self.log_mass, validate_args=False)
        new._batch_shape = torch.Size(batch_shape)
        return new

    def index(self, value: Tensor) -> Tensor:
        """Return the position of the angle nearest to each value, the shorter way round."""
        apart = torch.remainder(value[..., None] - self.values + torch.pi, 2 * torch.pi) - torch.pi
        return apart.abs().argmin(-1)

    def log_prob(self, value: Tensor) -> Tensor:
        """Return the log probability of the angle nearest to each value."""
        return self.log_mass[self.index(value)]

    def sample(self, sample_shape: Sequence[int] = ()) -> Tensor:
        """Draw angles."""
        shape = self._extended_shape(torch.Size(sample_shape))
        drawn = torch.multinomial(self.log_mass.exp(), max(shape.numel(), 1), replacement=True)
        return self.values[drawn].reshape(shape)

    def enumerate_support(self, expand: bool = True) -> Tensor:
        """Return all angles along a new first dimension."""
        values = self.values.reshape((-1,) + (1,) * len(self.batch_shape))
        return values.expand((-1, *self.batch_shape)) if expand else values
