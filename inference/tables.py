"""Joint tables of a posterior as labelled arrays: component by cell, front by cell."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.inference.fronts import Framed, directions, front_prior, front_table
from sloop_ppl.maps import Grid
from sloop_ppl.models import log_phrase

if TYPE_CHECKING:
    from sloop_ppl.inference.posterior import Posterior

__all__ = [
    "component_probabilities",
    "component_table",
    "component_weights",
    "frame_array",
    "frame_table",
    "phrase_tables",
    "responsibility_table",
]

Table = NDArray[np.float64]


def component_table(posterior: Posterior, target: str, which: int) -> xarray.DataArray:
    """Return p(component, cell | all that is known), dims component, y, x; sums to one.

    Raises
    ------
    InputError : when nothing was said of the target, or there is no such description.
    """
    names = _described(posterior, target, which)
    return _over_cells(posterior._joint(target, which), names, posterior.city.grid, "p")


def responsibility_table(posterior: Posterior, target: str, which: int) -> xarray.DataArray:
    """Return p(component | cell, description), dims component, y, x.

    Sums to one over components in every cell; NaN where the target cannot be.

    Raises
    ------
    InputError : when nothing was said of the target, or there is no such description.
    """
    names = _described(posterior, target, which)
    joint = posterior._joint(target, which)
    mass = joint.sum(0)
    share = np.divide(joint, mass, out=np.full_like(joint, np.nan), where=mass > 0)
    return _over_cells(share, names, posterior.city.grid, "responsibility")


def component_probabilities(posterior: Posterior, target: str, which: int) -> dict[str, float]:
    """Return the posterior probability of each component; empty when nothing was said."""
    if not posterior._said(target):
        return {}
    names = _described(posterior, target, which)
    return dict(zip(names, map(float, posterior._joint(target, which).sum(1)), strict=True))


def component_weights(posterior: Posterior, target: str, which: int) -> dict[str, float]:
    """Return the prior weight of each component, shared out among those that apply."""
    if not posterior._said(target):
        return {}
    names = _described(posterior, target, which)
    log_factor = posterior._said(target)[which].log_factor
    applies = np.isfinite(log_factor).any(axis=(0, 2))
    weights = np.array([part.weight for part in posterior.model.components]) * applies
    return dict(zip(names, map(float, weights / weights.sum()), strict=True))


def phrase_tables(posterior: Posterior, target: str) -> tuple[Table, ...]:
    """Return what each relation says of the cells by itself, as it was meant.

    Returns
    -------
    tuple of numpy.ndarray
        One table per relation of ``posterior.relations(target)``, summing to one, shape (H, W):
        no other relation, no component but the literal one, no prior; fronts summed out.
    """
    tables = []
    for said in posterior._said(target):
        for index in range(len(said.description.about(target))):
            own = [term for term in said.terms if term.index == index]
            log_p = sum(log_phrase(term, posterior.model).detach().numpy() for term in own)
            table = np.exp(log_p - np.max(log_p))
            tables.append((table / table.sum()).reshape(posterior.city.grid.shape))
    return tuple(tables)


def frame_table(posterior: Posterior, target: str, framed: Framed, bins: int) -> xarray.DataArray:
    """Return p(front, cell | all that is known), dims angle, y, x; sums to one."""
    grid = posterior.city.grid
    return xarray.DataArray(
        front_table(posterior, target, framed, bins).reshape(bins, *grid.shape),
        dims=("angle", "y", "x"),
        coords={"angle": _angle(bins), "y": grid.y_m, "x": grid.x_m},
        name="p",
        attrs=_about(framed),
    )


def frame_array(posterior: Posterior, target: str, framed: Framed, bins: int) -> xarray.DataArray:
    """Return p(front | all that is known), dim angle, with the prior as a coordinate."""
    _, mass, home = front_prior(framed.term, posterior.model, bins)
    return xarray.DataArray(
        front_table(posterior, target, framed, bins).sum(1),
        dims=("angle",),
        coords={
            "angle": _angle(bins),
            "prior": ("angle", np.bincount(home, weights=mass, minlength=bins)),
        },
        name="p",
        attrs=_about(framed),
    )


def _described(posterior: Posterior, target: str, which: int) -> tuple[str, ...]:
    said = posterior._said(target)
    if not said:
        raise InputError(
            f"Nothing was said of '{target}', so it has no mixture; its belief is its prior"
        )
    if not -len(said) <= which < len(said):
        raise InputError(
            f"Description {which} of '{target}' does not exist; expected 0 to {len(said) - 1}, or "
            "-1 for the latest"
        )
    return said[which].components


def _over_cells(values: Table, names: tuple[str, ...], grid: Grid, name: str) -> xarray.DataArray:
    return xarray.DataArray(
        values.reshape(-1, *grid.shape),
        dims=("component", "y", "x"),
        coords={"component": list(names), "y": grid.y_m, "x": grid.x_m},
        name=name,
    )


def _angle(bins: int) -> tuple[str, Table, dict[str, str]]:
    return (
        "angle",
        directions(bins),
        {"units": "rad", "long_name": "front, from east, anticlockwise"},
    )


def _about(framed: Framed) -> dict[str, str]:
    return {"ground": framed.term.ground, "relation": framed.term.relation}
