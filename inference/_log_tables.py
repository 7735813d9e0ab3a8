"""Tables of log weights with named axes, and their products."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import torch
from torch import Tensor

__all__ = ["LogTable", "product_of"]


@dataclass(frozen=True, eq=False)
class LogTable:
    """A table of log weights with one named axis for each latent.

    Parameters
    ----------
    latents
        Names of the latents, one for each axis.
    values
        The log weights.
    """

    latents: tuple[str, ...]
    values: Tensor

    @property
    def sizes(self) -> dict[str, int]:
        """Length of each latent's axis."""
        return dict(zip(self.latents, self.values.shape, strict=True))

    def aligned(self, latents: Sequence[str]) -> Tensor:
        """Return the values with the axes of some latents, of length one where it has none."""
        kept = [name for name in latents if name in self.latents]
        table = self.values.permute([self.latents.index(name) for name in kept])
        if len(kept) == len(latents):
            return table
        sizes = self.sizes
        return table.reshape([sizes.get(name, 1) for name in latents])

    def summed(self, name: str) -> LogTable:
        """Return the table with one latent summed out."""
        axis = self.latents.index(name)
        rest = (*self.latents[:axis], *self.latents[axis + 1 :])
        if self.values.shape[axis] == 1:
            return LogTable(rest, self.values.squeeze(axis))
        return LogTable(rest, torch.logsumexp(self.values, axis))


def product_of(tables: Sequence[LogTable]) -> LogTable:
    """Return the product of some tables: the sum of their log weights, axes matched by name."""
    latents = tuple(dict.fromkeys(name for table in tables for name in table.latents))
    total = reduce(torch.add, (table.aligned(latents) for table in tables))
    return LogTable(latents, total)
