"""Turn a user's prior over cells into one checked log table per target."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import Grid

__all__ = ["log_priors"]


def log_priors(prior: Any, targets: Sequence[str], grid: Grid) -> dict[str, NDArray[np.float64]]:
    """Return target -> log prior over cells, shape (S,).

    Parameters
    ----------
    prior : None for uniform; an array (H, W) for all targets; or a mapping of target to array.
        Weights need not sum to one.
    targets : ids of the targets.
    grid : the cells.

    Raises
    ------
    InputError : when a table has the wrong shape, a negative, NaN or infinite weight, or no
        positive one.
    UnknownName : when a mapping names a target that is not there.
    """
    uniform = np.full(grid.size, -np.log(grid.size))
    if prior is None:
        return dict.fromkeys(targets, uniform)
    if isinstance(prior, Mapping):
        for name in prior:
            if name not in targets:
                raise UnknownName("target of the prior", str(name), targets)
        tables = {t: _checked(prior[t], t, grid) if t in prior else uniform for t in targets}
    else:
        shared = _checked(prior, "all targets", grid)
        tables = dict.fromkeys(targets, shared)
    return tables


def _checked(table: Any, target: str, grid: Grid) -> NDArray[np.float64]:
    weights = np.asarray(table, dtype=np.float64)
    if weights.shape != grid.shape:
        raise InputError(f"Prior of {target} has shape {weights.shape}; expected {grid.shape}")
    if not np.isfinite(weights).all() or (weights < 0).any():
        raise InputError(f"Prior of {target} holds NaN, infinite or negative weights")
    if not (weights > 0).any():
        raise InputError(f"Prior of {target} is zero everywhere; expected a positive weight")
    with np.errstate(divide="ignore"):
        log_p: NDArray[np.float64] = np.log(weights / weights.sum()).reshape(-1)
    return log_p
