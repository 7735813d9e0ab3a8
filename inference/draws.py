"""Draw cells, components and fronts together from a posterior."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import xarray
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.inference.fronts import (
    Framed,
    framed_terms,
    front_distribution,
    front_prior,
    front_ratio,
)

if TYPE_CHECKING:
    from sloop_ppl.inference.posterior import Posterior

__all__ = ["draws_from", "uniforms_for"]

Table = NDArray[np.float64]
_BINS = 72
_AT_ONCE = 10_000


def uniforms_for(
    posterior: Posterior, target: str, n: int, rng: np.random.Generator | None
) -> Table:
    """Return the numbers that n draws take: for the cell, the components and the fronts.

    Parameters
    ----------
    posterior : what will be drawn from.
    target : id of the target.
    n : how many draws, > 0.
    rng : where the numbers are drawn from; None for a lattice, the same every time.

    Raises
    ------
    InputError : when `n` is not positive.
    """
    if n < 1:
        raise InputError(f"n is {n}; expected at least one draw")
    needed = 1 + len(posterior._said(target)) + 2 * len(framed_terms(posterior, target))
    return _lattice(n, needed) if rng is None else rng.random((n, needed))


def draws_from(posterior: Posterior, target: str, uniforms: Table) -> xarray.Dataset:
    """Turn uniform numbers into draws from the joint posterior of a target.

    Parameters
    ----------
    posterior : what is drawn from.
    target : id of the target.
    uniforms : numbers in [0, 1), shape (n, D), from `uniforms_for`.

    Returns
    -------
    xarray.Dataset
        ``x`` and ``y``, centres of the drawn cells in metres, and ``row`` and ``col`` (dim draw);
        ``component`` (draw, description); ``front``, radians from east in [-pi, pi) (draw,
        frame), with the ``ground`` and the ``relation`` of each frame.

    Notes
    -----
    Ancestral: cell ~ belief; component ~ p(z | cell) for each description, independent given the
    cell; front ~ p(psi | cell, z), which is its prior when z leaves frames out. A front that is
    not a point is drawn evenly within its bin of a degree.
    """
    grid = posterior.city.grid
    cells = _inverse(posterior.belief(target).reshape(-1), uniforms[:, 0])
    rows, cols = np.divmod(cells, grid.n_cols)
    said = posterior.said[target]
    chosen = np.zeros((len(cells), len(said)), dtype=np.intp)
    for which in range(len(said)):
        weights = posterior._joint(target, which)[:, cells]
        chosen[:, which] = _by_column(weights, uniforms[:, 1 + which])
    framed = framed_terms(posterior, target)
    fronts = np.zeros((len(cells), len(framed)))
    for k, frame in enumerate(framed):
        # Phrases of one description that share a front draw it with the same numbers.
        same = (f for f in range(k) if _share(posterior, target, framed[f], frame))
        first = next(same, k)
        column = 1 + len(said) + 2 * first
        for start in range(0, len(cells), _AT_ONCE):
            part = slice(start, start + _AT_ONCE)
            pick, within = uniforms[part, column], uniforms[part, column + 1]
            components = chosen[part, frame.which]
            fronts[part, k] = _fronts(
                posterior, target, frame, cells[part], components, pick, within
            )
    names = np.array([part.name for part in posterior.model.components])
    return xarray.Dataset(
        {
            "x": ("draw", grid.x_m[cols], {"units": "m"}),
            "y": ("draw", grid.y_m[rows], {"units": "m"}),
            "row": ("draw", rows),
            "col": ("draw", cols),
            "component": (("draw", "description"), names[chosen]),
            "front": (("draw", "frame"), fronts, {"units": "rad"}),
        },
        coords={
            "ground": ("frame", np.array([f.term.ground for f in framed], dtype=str)),
            "relation": ("frame", np.array([f.term.relation for f in framed], dtype=str)),
        },
        attrs={"target": target},
    )


def _lattice(n: int, dimensions: int) -> Table:
    """Return n points that fill the unit cube evenly, the same at every call, shape (n, D).

    Notes
    -----
    Source: Roberts (2018), "The unreasonable effectiveness of quasirandom sequences": multiples
    of the inverse powers of the root of x^(D+1) = x + 1, modulo one.
    """
    root = 2.0
    for _ in range(64):
        root = (1 + root) ** (1 / (dimensions + 1))
    steps = root ** -np.arange(1, dimensions + 1)
    points: Table = (0.5 + np.outer(np.arange(1, n + 1), steps)) % 1.0
    return points


def _inverse(weights: Table, uniforms: Table) -> NDArray[np.intp]:
    """Return the index at which the running sum of the weights passes each number."""
    running = np.cumsum(weights)
    passed = np.searchsorted(running, uniforms * running[-1], side="right")
    found: NDArray[np.intp] = np.minimum(passed, np.flatnonzero(weights)[-1])
    return found


def _by_column(weights: Table, uniforms: Table) -> NDArray[np.intp]:
    """Draw a row for every column of weights, shape (M, n), with one number each."""
    running = np.cumsum(weights, 0)
    passed = (uniforms * running[-1] >= running).sum(0)
    drawn: NDArray[np.intp] = np.minimum(passed, len(weights) - 1)
    return drawn


def _share(posterior: Posterior, target: str, one: Framed, other: Framed) -> bool:
    """Tell whether two phrases speak of one front."""
    shared = posterior.said[target][one.which].shared
    same = (one.which, one.term.ground) == (other.which, other.term.ground)
    return same and one.term.ground in shared.grounds


def _fronts(
    posterior: Posterior,
    target: str,
    framed: Framed,
    cells: NDArray[np.intp],
    components: NDArray[np.intp],
    pick: Table,
    within: Table,
) -> Table:
    """Draw one front for each drawn cell and component."""
    term, model = framed.term, posterior.model
    shared = posterior.said[target][framed.which].shared
    if term.ground in shared.grounds:
        angles = shared.fronts_rad[:, shared.grounds.index(term.ground)]
        joint = posterior._coupling.joint(target, framed.which)
        node = _by_column(joint[:, components, cells], pick)
    else:
        angles, mass, _ = front_prior(term, model, _BINS)
        uses = np.array([part.uses_frames for part in model.components])[components]
        places, home = np.unique(cells, return_inverse=True)
        told = mass[:, None] * front_ratio(term, model, angles, places)
        node = _by_column(np.where(uses, told[:, home], mass[:, None]), pick)
    points = [
        part.mean_rad for part in front_distribution(term, model).parts if math.isinf(part.kappa)
    ]
    width = 2 * math.pi / max(len(np.unique(angles)) - len(points), 1)
    jitter = np.where(np.isin(angles[node], points), 0.0, (within - 0.5) * width)
    drawn: Table = (angles[node] + jitter + math.pi) % (2 * math.pi) - math.pi
    return drawn
