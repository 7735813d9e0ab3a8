"""Arithmetic on tables of log probabilities: sums, complements, blurs and look-ups."""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from pyro.ops.indexing import vindex
from torch import Tensor

from sloop_ppl.maps import Grid

__all__ = ["LEAST_LOG", "log1mexp", "log_blur", "log_normalise", "look_up"]

LEAST_LOG = math.log(1e-300)
"""Log of the least probability that stands for an impossible phrase: near the least normal float64,
2e-308, since -inf less -inf is NaN."""


def log1mexp(log_p: Tensor) -> Tensor:
    """Return log(1 - exp(log_p)) for log_p <= 0, accurate near both ends; -inf at 0.

    Its gradient at 0 is 0: an impossible phrase tells nothing of the numbers that made it so.
    """
    near_one, one = log_p > -math.log(2), log_p == 0
    # Each branch sees only arguments it is accurate (and finite in gradient) for.
    small = torch.where(near_one & ~one, log_p, torch.full_like(log_p, -1.0))
    large = torch.where(near_one, torch.full_like(log_p, -1.0), log_p)
    log_q = torch.where(near_one, (-torch.expm1(small)).log(), torch.log1p(-large.exp()))
    return log_q.masked_fill(one, -math.inf)


def log_normalise(log_p: Tensor) -> Tensor:
    """Return log probabilities that sum to one over the last axis."""
    return log_p - torch.logsumexp(log_p, -1, keepdim=True)


def log_blur(log_p: Tensor, grid: Grid, sigma_m: float) -> Tensor:
    """Return the log of a table convolved with a Gaussian, mass kept inside the map.

    Parameters
    ----------
    log_p
        Log weights of the described cell, shape (..., S).
    sigma_m
        Standard deviation of the error in each direction, metres, > 0.

    Returns
    -------
    Tensor
        Log weights of the true cell, each described cell's mass spread over the cells inside the
        map, shape (..., S).
    """
    table = log_p.reshape(*log_p.shape[:-1], *grid.shape)
    peak = table.amax((-2, -1), keepdim=True)
    rows = _kernel(grid.n_rows, grid.cell_m, sigma_m)
    cols = _kernel(grid.n_cols, grid.cell_m, sigma_m)
    blurred = rows @ torch.exp(table - peak) @ cols.T
    return (blurred.clamp_min(1e-300).log() + peak).reshape(log_p.shape)


def _kernel(count: int, cell_m: float, sigma_m: float) -> Tensor:
    """Return P(true index | described index), columns sum to one, shape (count, count)."""
    index = torch.arange(count, dtype=torch.float64) * cell_m
    weights = torch.exp(-((index[:, None] - index) ** 2) / (2 * sigma_m**2))
    return weights / weights.sum(0)


def look_up(table: Tensor, index: Sequence[Tensor]) -> Tensor:
    """Return the table's entries at some indices, which broadcast against each other.

    Parameters
    ----------
    table
        Any table.
    index
        Whole numbers, one tensor for each axis of the table.

    Returns
    -------
    Tensor
        Shape of the indices broadcast together. Where each index is one number or all of an axis
        in order, as enumeration and plates make it, it is a view of the table. An axis of length
        one stands for what does not matter: any index finds its one entry.
    """
    view = table
    dims: list[int] = []
    for axis in reversed(range(table.dim())):
        dim = 0 if table.shape[axis] == 1 else _swept(index[axis], table.shape[axis])
        if dim is None or (dim and dim in dims):
            picked: Tensor = vindex(table, _within(table, index))
            return picked
        if dim:
            dims.insert(0, dim)
        else:
            view = _at(view, axis, index[axis])
    order = sorted(range(len(dims)), key=lambda axis: dims[axis])
    shape = [1] * max(part.dim() for part in index)
    for axis, dim in enumerate(dims):
        shape[dim] = view.shape[axis]
    return view.permute(order).reshape(shape)


def _at(view: Tensor, axis: int, index: Tensor) -> Tensor:
    """Return a table at one index of an axis; any index finds the one entry there is."""
    if view.shape[axis] == 1:
        return view.select(axis, 0)
    if type(index) is Tensor:
        return view.select(axis, int(index))
    # Pyro's `render_model` follows its own kind of tensor, but not through a Python number.
    return view.index_select(axis, index.reshape(1)).squeeze(axis)


def _within(table: Tensor, index: Sequence[Tensor]) -> tuple[Tensor, ...]:
    """Return the indices with those of axes of length one set to 0."""
    sizes = zip(index, table.shape, strict=True)
    return tuple(at * 0 if size == 1 else at for at, size in sizes)


def _swept(index: Tensor, size: int) -> int | None:
    """Return the dim, below 0, along which an index runs through an axis; 0 for one number."""
    if index.numel() == 1:
        return 0
    if index.numel() != size or max(index.shape) != size:
        return None
    if not torch.equal(index.reshape(-1), torch.arange(size)):
        return None
    return list(index.shape).index(size) - index.dim()
