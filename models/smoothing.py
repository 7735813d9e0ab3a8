"""Blur a table over cells by an error that all phrases of a description share."""

from __future__ import annotations

import torch
from torch import Tensor

from sloop_ppl.maps import Grid

__all__ = ["log_blur"]


def log_blur(log_p: Tensor, grid: Grid, sigma_m: float) -> Tensor:
    """Return the log of a table convolved with a Gaussian, mass kept inside the map.

    Parameters
    ----------
    log_p : log weights of the described cell, shape (..., S).
    grid : the cells.
    sigma_m : standard deviation of the error in each direction, metres, > 0.

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
