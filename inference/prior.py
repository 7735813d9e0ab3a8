"""Turn a user's prior over cells into one checked log table per target."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl._cell_axes import in_order
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import CityMap, Grid, SearchArea
from sloop_ppl.models import cell_prior

__all__ = ["log_priors"]


def log_priors(
    prior: Any, targets: Sequence[str], city: CityMap, area: SearchArea | None = None
) -> dict[str, NDArray[np.float64]]:
    """Return target -> log prior over cells, shape (S,).

    Parameters
    ----------
    prior
        None for uniform; a name, file or function that :func:`sloop_ppl.models.cell_prior` takes;
        an array (H, W) of weights, row 0 in the south, or an xarray one, whose coordinates x and y
        tell where its cells are; or a mapping of target to one of these. Weights need not sum to
        one; a target that a mapping leaves out is anywhere.
    targets
        Ids of the targets.
    city
        The map.
    area
        Where targets are searched for; a target is nowhere else. The whole map when None.

    Raises
    ------
    InputError
        When a table has the wrong shape, a negative, NaN or infinite weight, or no positive one,
        or none in the area; when a file cannot be read or is of another map.
    UnknownName
        When a mapping names a target that is not there, or there is no prior of a name.
    """
    if area is not None:
        whole = log_priors(prior, targets, city)
        return {target: area.log_restricted(table) for target, table in whole.items()}
    if not isinstance(prior, Mapping):
        return _for_each(prior, targets, city)
    for name in prior:
        if name not in targets:
            raise UnknownName("target of the prior", str(name), targets)
    return {t: _for_each(prior.get(t), (t,), city)[t] for t in targets}


def _for_each(prior: Any, targets: Sequence[str], city: CityMap) -> dict[str, NDArray[np.float64]]:
    """Return the log prior of each target from one prior for all."""
    if prior is None:
        return dict.fromkeys(targets, np.full(city.grid.size, -np.log(city.grid.size)))
    if isinstance(prior, str | Path) or callable(prior):
        weigh = cell_prior(prior)
        name = getattr(weigh, "name", prior if isinstance(prior, str | Path) else None)
        label = "" if name is None else f" ('{name}')"
        return {t: _checked(weigh(city, t), f"{t}{label}", city.grid) for t in targets}
    whose = targets[0] if len(targets) == 1 else "all targets"
    return dict.fromkeys(targets, _checked(prior, whose, city.grid))


def _checked(table: Any, whose: str, grid: Grid) -> NDArray[np.float64]:
    table = in_order(table, f"Prior of {whose}", grid)
    try:
        weights = np.asarray(table, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise InputError(
            f"Prior of {whose} is a {type(table).__name__}; expected weights of shape "
            f"{grid.shape}, a name, a file, or a function of a map and a target's id"
        ) from error
    if weights.shape != grid.shape:
        raise InputError(
            f"Prior of {whose} has shape {weights.shape}; expected {grid.shape}, (rows, "
            "columns), row 0 in the south"
        )
    bad = ~np.isfinite(weights) | (weights < 0)
    if bad.any():
        row, col = np.argwhere(bad)[0]
        raise InputError(
            f"Prior of {whose} holds NaN, infinite or negative weights: {weights[row, col]:g} in "
            f"row {row}, column {col}, {int(bad.sum())} of {bad.size} in all; expected finite "
            "weights of at least 0"
        )
    if not (weights > 0).any():
        raise InputError(f"Prior of {whose} is zero everywhere; expected a positive weight")
    weights = weights / weights.max()  # so that no sum overflows
    with np.errstate(divide="ignore"):
        log_p: NDArray[np.float64] = np.log(weights / weights.sum()).reshape(-1)
    return log_p
