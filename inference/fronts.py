"""Which way the ground of a relation faces, as tables over directions: alone and by cell."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import torch
from numpy.typing import NDArray

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.models import (
    FrameDistribution,
    Preset,
    RelationTerm,
    log_phrase,
    log_phrase_given_front,
    phrases,
)

if TYPE_CHECKING:
    from sloop_ppl.inference.posterior import Posterior

__all__ = [
    "Framed",
    "directions",
    "find_framed",
    "framed_terms",
    "front_distribution",
    "front_prior",
    "front_ratio",
    "front_table",
]

Table = NDArray[np.float64]
_NODES_PER_BIN = 5
_MOST_CELLS = 20_000
"""On larger maps one angle stands for a bin."""
_MOST_NUMBERS = 8_000_000


@dataclass(frozen=True, eq=False)
class Framed:
    """A relation of a target whose meaning depends on which way its ground faces.

    Parameters
    ----------
    which : index of the description that holds it among those about the target.
    relation : index of the relation in ``posterior.relations(target)``.
    term : the relation to one of its grounds.
    """

    which: int
    relation: int
    term: RelationTerm


def directions(bins: int) -> Table:
    """Return B equal directions in radians, the first east, anticlockwise, shape (B,)."""
    if bins < 4:
        raise InputError(f"bins is {bins}; expected at least 4 directions")
    return 2 * math.pi * np.arange(bins, dtype=np.float64) / bins


def framed_terms(posterior: Posterior, target: str) -> tuple[Framed, ...]:
    """Return what was said of a target in some frame of reference, in the order it was said."""
    if not any(part.uses_frames for part in posterior.model.components):
        return ()
    found: list[Framed] = []
    before = 0
    for which, said in enumerate(posterior.said[target]):
        found += [
            Framed(which, before + term.index, term) for term in said.terms if term.needs_frame
        ]
        before += len(said.description.about(target))
    return tuple(found)


def find_framed(
    posterior: Posterior, target: str, ground: str | None, relation: int | None
) -> Framed:
    """Return the one frame of a target that is meant.

    Parameters
    ----------
    posterior : where it is looked up.
    target : id of the target.
    ground : id of the landmark whose front it is; None for any.
    relation : index in ``posterior.relations(target)``; None for any.

    Raises
    ------
    InputError : when no frame or several fit; give `ground`, `relation` or both.
    UnknownName : when there is no such target, or no frame of such a ground.
    """
    if target not in posterior.targets:
        raise UnknownName("target", target, posterior.targets)
    all_of_them = framed_terms(posterior, target)
    if not all_of_them:
        raise InputError(
            f"Nothing that was said of '{target}' depends on a frame of reference under model "
            f"'{posterior.model.name}'; expected front, behind, left or right"
        )
    grounds = tuple(dict.fromkeys(framed.term.ground for framed in all_of_them))
    if ground is not None and ground not in grounds:
        raise UnknownName("ground with a front", ground, grounds)
    fitting = [
        framed
        for framed in all_of_them
        if ground in (None, framed.term.ground) and relation in (None, framed.relation)
    ]
    if len(fitting) == 1:
        return fitting[0]
    listed = ", ".join(
        f"{framed.relation} ({framed.term.relation} {framed.term.ground})" for framed in all_of_them
    )
    asked = f"ground {ground!r} and relation {relation}"
    raise InputError(
        f"{len(fitting)} frames of '{target}' fit {asked}; name one of the relations {listed}"
    )


def front_distribution(term: RelationTerm, model: Preset) -> FrameDistribution:
    """Return the prior of the front that a frame relation depends on."""
    return phrases.front_prior(term, model) or model.frame_prior(term)


def front_prior(
    term: RelationTerm, model: Preset, bins: int
) -> tuple[Table, Table, NDArray[np.intp]]:
    """Return angles that stand for a frame's prior, their mass, and the bin each falls into.

    Returns
    -------
    tuple of numpy.ndarray
        Angles in radians, probabilities that sum to one, and indices into `directions`, shape
        (M,) each. Points of the prior come first, at their own angle.
    """
    nodes = _NODES_PER_BIN if term.city.grid.size <= _MOST_CELLS else 1
    angles, mass = front_distribution(term, model).bins(nodes * bins)
    return angles, mass, np.round(angles * bins / (2 * math.pi)).astype(np.intp) % bins


def front_ratio(
    term: RelationTerm, model: Preset, fronts_rad: Table, cells: NDArray[np.intp]
) -> Table:
    """Return how much likelier what was said is, at a cell, for a front than for the prior.

    Returns
    -------
    numpy.ndarray
        g(s, psi) / E_psi g(s, psi), lapses and normalisers included, 0 where nothing is likely,
        shape (M, C).
    """
    chosen = torch.from_numpy(cells)
    with torch.no_grad():
        given = log_phrase_given_front(term, model, fronts_rad)[:, chosen]
        ratio = (given - log_phrase(term, model)[chosen]).exp().numpy()
    told: Table = np.nan_to_num(ratio, posinf=0.0)
    return told


def front_table(posterior: Posterior, target: str, framed: Framed, bins: int) -> Table:
    """Return the posterior of a front together with the cell of the target it was said of.

    Parameters
    ----------
    posterior : what is believed.
    target : id of the target.
    framed : the relation whose ground's front it is.
    bins : number of directions B.

    Returns
    -------
    numpy.ndarray
        Joint table of `directions` and cells, shape (B, S), sums to one; summed over directions
        it is the belief.

    Notes
    -----
    p(psi, s | said) = p(psi) [used(s) g(s, psi) / E_psi g(s, psi) + unused(s)], where `unused`
    is the share of the components that leave frames out, and each front stands for the bin
    nearest to it. A front that targets share has its table in the coupling already.
    """
    angles, mass, home = front_prior(framed.term, posterior.model, bins)
    joint = posterior._coupling.joint(target, framed.which)
    shared = posterior._said(target)[framed.which].shared
    if framed.term.ground in shared.grounds:
        fronts = shared.fronts_rad[:, shared.grounds.index(framed.term.ground)]
        gain, met = _gain_of_settings(fronts, shared.log_prior.numpy(), joint.sum(1))
        return _binned(lambda part: gain[_nearest(met, angles[part])], mass, home, joint, bins)
    uses = np.array([part.uses_frames for part in posterior.model.components])
    used, unused = joint[:, uses].sum((0, 1)), joint[:, ~uses].sum((0, 1))
    cells = np.arange(used.size)

    def weigh(part: slice) -> Table:
        ratio: Table = front_ratio(framed.term, posterior.model, angles[part], cells)
        return ratio

    prior = np.bincount(home, weights=mass, minlength=bins)
    table: Table = _binned(weigh, mass, home, used, bins) + prior[:, None] * unused
    return table


def _binned(
    weigh: Callable[[slice], Table], mass: Table, home: NDArray[np.intp], joint: Table, bins: int
) -> Table:
    """Weigh the angles of a prior at every cell, sum them into bins, and restore each cell's mass.

    `weigh` gives the factors of some of the angles, shape (m, S).
    """
    cell_mass = joint.reshape(-1, joint.shape[-1]).sum(0)
    table = np.zeros((bins, cell_mass.size))
    step = max(1, _MOST_NUMBERS // cell_mass.size)
    for start in range(0, len(mass), step):
        part = slice(start, start + step)
        met, own = np.unique(home[part], return_inverse=True)
        sums = np.zeros((len(met), len(own)))
        sums[own, np.arange(len(own))] = mass[part]
        table[met] += sums @ weigh(part)
    total = table.sum(0)
    scale = np.divide(cell_mass, total, out=np.zeros_like(total), where=total > 0)
    whole: Table = table * scale
    return whole


def _gain_of_settings(fronts: Table, log_prior: Table, settings: Table) -> tuple[Table, Table]:
    """Return posterior over prior of each distinct front by cell, (D, S), and the fronts, (D,)."""
    met, which = np.unique(fronts, return_inverse=True)
    prior = np.bincount(which, weights=np.exp(log_prior))
    by_front = np.zeros((len(met), settings.shape[-1]))
    np.add.at(by_front, which, settings)
    gain: Table = by_front / np.maximum(prior, 1e-300)[:, None]
    return gain, met


def _nearest(met: Table, angles: Table) -> NDArray[np.intp]:
    """Return the index of the nearest of the fronts `met` to each angle, round the circle."""
    apart = np.abs((angles[:, None] - met + math.pi) % (2 * math.pi) - math.pi)
    nearest: NDArray[np.intp] = apart.argmin(1)
    return nearest
