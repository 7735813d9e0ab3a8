"""What is known of the frames that were used: which way grounds face, alone and cell by cell.

Shape legend: S cells; K components; B directions; X = V S pairs of shared latents and cell.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import torch
from numpy.typing import NDArray

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference._phrase_tables import FRAME_BINS, PhraseTables
from sloop_ppl.inference.factors import DescriptionFactor, site_name
from sloop_ppl.inference.joint import JointPosterior, LogTable
from sloop_ppl.inference.summaries import circular_summary
from sloop_ppl.maps import Grid
from sloop_ppl.models import FrameDistribution, FramePart, GroundedRelation, SharedFrame

if TYPE_CHECKING:
    import xarray

__all__ = [
    "FramePosterior",
    "FrameSummary",
    "Framed",
    "directions",
    "find_framed",
    "frame_array",
    "frame_masses",
    "frame_nodes",
    "frame_table",
    "framed_relations",
    "modes_of",
    "summarise_frames",
]

Table = NDArray[np.float64]

_BINS = 360
_NODES_PER_BIN = 5
_MOST_CELLS = 20_000
"""On larger maps one angle stands for a bin: five would take as many tables of all cells."""
_MOST_NUMBERS = 1_000_000  # of one table at a time, 8 MB
_MOST_MODES, _LEAST_MODE = 3, 0.2  # what `modes_of` says in words; a fourth quarter is what is left
_LEFT_OUT, _LEFT_OUT_LARGE = 1e-9, 1e-4  # mass of the cells that `gain` leaves out
_LAST = 4  # harmonics at the end of a series that show whether it has ended


@dataclass(frozen=True)
class FrameSummary:
    """One part of the posterior over the direction a ground faces.

    Parameters
    ----------
    ground
        Id of the landmark.
    relation
        The relation whose frame it is.
    mean_rad
        Mean direction of the ground's front, radians anticlockwise from east.
    kappa
        Concentration of the part; None for a point.
    p
        Posterior probability of the part; what is missing to one is the lapse.
    """

    ground: str
    relation: str
    mean_rad: float
    kappa: float | None
    p: float


@dataclass(frozen=True, eq=False)
class Framed:
    """A relation of a target whose meaning depends on which way its ground faces.

    Parameters
    ----------
    which
        Position of the description that holds it.
    relation
        Index of the relation among those of the target.
    term
        The relation to one of its grounds.
    """

    which: int
    relation: int
    term: GroundedRelation


def directions(bins: int) -> Table:
    """Return B equal directions in radians, the first east, anticlockwise, shape (B,)."""
    if bins < 4:
        raise InputError(f"bins is {bins}; expected at least 4 directions")
    return 2 * math.pi * np.arange(bins, dtype=np.float64) / bins


def framed_relations(factors: Sequence[DescriptionFactor], target: str) -> tuple[Framed, ...]:
    """Return what was said of a target in some frame of reference, in the order it was said.

    Left out is a relation whose frame is another one under each value of a latent, such as which
    place its ground is: the joint posterior tells of it
    (``posterior.joint.table("T/frame_j", "latent")``).
    """
    found: list[Framed] = []
    before = 0
    for which, factor in enumerate(factors):
        if target not in factor.log_factors:
            continue
        if any(part.uses_frames for part in factor.data.model.components):
            found += [
                Framed(which, before + term.index, term)
                for term in factor.relations(target)
                if term.needs_frame and _has_one_frame(factor, term)
            ]
        before += len(factor.about(target))
    return tuple(found)


def _has_one_frame(factor: DescriptionFactor, term: GroundedRelation) -> bool:
    phrase = factor.data.phrase(term)
    if not term.is_main or phrase.is_of_each_denied:
        return False
    if phrase.frames is None:
        return True
    pairs = zip(phrase.meanings, phrase.frames, strict=True)
    return len({frame for meaning, frame in pairs if not meaning.is_silent}) == 1


def find_framed(
    framed: Sequence[Framed], target: str, model: str, ground: str | None, relation: int | None
) -> Framed:
    """Return the one frame of a target that is meant.

    Parameters
    ----------
    target, model
        Id of the target and name of the model, for messages.
    ground
        Id of the landmark whose front it is; None for any.
    relation
        Index among the target's relations; None for any.

    Raises
    ------
    InputError
        When no frame or several fit; give `ground`, `relation` or both.
    UnknownName
        When there is no frame of such a ground.
    """
    if not framed:
        raise InputError(
            f"Nothing that was said of '{target}' depends on a frame of reference under model "
            f"'{model}'; expected front, behind, left or right"
        )
    grounds = tuple(dict.fromkeys(one.term.ground for one in framed))
    if ground is not None and ground not in grounds:
        raise UnknownName("ground with a front", ground, grounds)
    fitting = [
        one
        for one in framed
        if ground in (None, one.term.ground) and relation in (None, one.relation)
    ]
    if len(fitting) == 1:
        return fitting[0]
    listed = ", ".join(f"{one.relation} ({one.term.relation} {one.term.ground})" for one in framed)
    asked = f"ground {ground!r} and relation {relation}"
    raise InputError(
        f"{len(fitting)} frames of '{target}' fit {asked}; name one of the relations {listed}"
    )


class FramePosterior:
    """The posterior of one frame jointly with the cell of the target it was said of.

    Parameters
    ----------
    joint
        The joint posterior.
    factor
        The description.
    target
        Id of the target.
    framed
        The relation.

    Notes
    -----
    p(psi, s | all) = p(psi) [used(s) phi(s, psi) / E_psi phi(s, psi) + unused(s)], where `unused`
    is the share of the components that leave frames out.
    """

    def __init__(
        self, joint: JointPosterior, factor: DescriptionFactor, target: str, framed: Framed
    ) -> None:
        model, data = factor.data.model, factor.data
        self.term = framed.term
        self.tables = PhraseTables(data, framed.term)
        self.prior: FrameDistribution = model.frame_prior_for(framed.term) or model.frame_prior(
            framed.term
        )
        self.n_cells = data.n_cells
        names = [site_name(latent.name, framed.which) for latent in data.shared]
        component = site_name(f"{target}/component", framed.which)
        own = f"{target}/frame_{framed.relation}"
        self.answered = [
            f for f in joint.factors if isinstance(f, LogTable) and f.latents == (own,)
        ]
        self._support = joint.support(own) if self.answered else ()
        if self.answered:  # they weigh the fronts themselves, below
            others = tuple(f for f in joint.factors if f not in self.answered)
            joint = JointPosterior(others, joint.supports, joint.local)
        weights = joint.probabilities(*names, component, f"{target}/cell")
        uses = np.array([part.uses_frames for part in model.components])
        self.used = weights[..., uses, :].sum(-2).reshape(-1)  # (X,)
        self.unused = weights[..., ~uses, :].sum(-2).reshape(-1)
        self.shape = (*weights.shape[:-2], weights.shape[-1])
        self.shared = None
        if self.tables.phrase.shared_axis is not None:
            shared = data.shared[self.tables.phrase.shared_axis]
            assert isinstance(shared, SharedFrame)
            axis = self.tables.phrase.shared_axis
            over = np.moveaxis(weights.sum(-2), axis, 0).reshape(len(shared.support), -1)
            by_cell = over.reshape(len(shared.support), -1, self.n_cells).sum(1)
            self.shared = _SharedGain(shared, by_cell, self.prior)

    def answer_likelihood(self, angles_rad: Table) -> Table:
        """Return how probable what was answered of the front is if it is so, shape (B,)."""
        if not self.answered:
            return np.ones(len(angles_rad))
        at = np.exp(1j * np.array(self._support, dtype=np.float64))
        nearest = np.abs(np.exp(1j * angles_rad)[:, None] - at).argmin(1)
        log_p = sum(factor.values.numpy() for factor in self.answered)
        found: Table = np.exp(np.asarray(log_p))[nearest]
        return found

    def ratio(self, angles_rad: Table, cells: NDArray[np.intp] | None = None) -> Table:
        """Return phi(s, psi) / E_psi phi(s, psi) for some fronts, 0 where nothing is likely.

        Parameters
        ----------
        angles_rad
            Fronts of a frame that is the phrase's own, shape (B,).
        cells
            Cells that are wanted, shape (C,); all when None.

        Returns
        -------
        numpy.ndarray
            Shape (B, V, C), V the joint values of shared latents.
        """
        given = self.tables.log_phi_given_frame(angles_rad, cells).numpy()
        names = (*self.tables.shared, "cell")
        expected = self.tables.log_phi.aligned(names).numpy()
        expected = expected if cells is None else expected[..., cells]
        with np.errstate(invalid="ignore"):
            ratio = np.exp(given - expected)
        size = self.n_cells if cells is None else len(cells)
        whole = np.broadcast_to(ratio, (len(angles_rad), *self.shape[:-1], size))
        ratios: Table = np.nan_to_num(whole.reshape(len(angles_rad), -1, size), posinf=0.0)
        return ratios

    def ratio_at(self, angles_rad: Table, cells: NDArray[np.intp]) -> Table:
        """Return what `ratio` does at some cells, shared latents averaged over, shape (B, C)."""
        used = self.used.reshape(-1, self.n_cells)[:, cells]
        mass = used.sum(0)
        found = np.zeros((len(angles_rad), len(cells)))
        step = max(1, _MOST_NUMBERS // used.size)
        for start in range(0, len(angles_rad), step):
            part = slice(start, start + step)
            weighed = (self.ratio(angles_rad[part], cells) * used).sum(1)
            found[part] = np.divide(weighed, mass, out=np.zeros_like(weighed), where=mass > 0)
        return found

    def gain(self, angles_rad: Table) -> Table:
        """Return posterior over prior density of some fronts, shape (B,).

        Notes
        -----
        With phi = (1 - lapse) p + lapse u, the sum over cells of used phi(psi) / E phi is a number
        plus the sum of p(psi) weighted by used (1 - lapse) / E phi. Cells that together hold less
        than 1e-9 of the latter (1e-4 on maps of over 20,000 cells) are taken as if the front told
        nothing of them.
        """
        if self.shared is not None:
            return self.shared.overall(angles_rad)
        data = self.tables.data
        names = (*self.tables.shared, "cell")
        log_phi = self.tables.log_phi.aligned(names).numpy()
        phi = np.exp(np.broadcast_to(log_phi, self.shape)).reshape(-1, self.n_cells)
        used = self.used.reshape(-1, self.n_cells)
        weight = np.divide(used, phi, out=np.zeros_like(used), where=phi > 0)
        lapse = data.model.lapse_of(self.tables.relation)
        level = lapse * math.exp(data.log_uninformative)
        moved = np.maximum(used - level * weight, 0.0)
        by_cell = moved.sum(0)
        order = np.argsort(-by_cell)
        left = by_cell.sum() - np.cumsum(by_cell[order])
        least = _LEFT_OUT if self.n_cells <= _MOST_CELLS else _LEFT_OUT_LARGE
        cells = np.sort(order[: int((left > least).sum()) + 1])
        fixed = self.unused.sum() + used.sum() - moved[:, cells].sum()
        total = np.full(len(angles_rad), float(fixed))
        held = torch.from_numpy((1 - lapse) * weight[:, cells])
        step = max(1, _MOST_NUMBERS // held.numel())
        for start in range(0, len(angles_rad), step):
            part = slice(start, start + step)
            p = self.tables.log_phi_without_lapse(angles_rad[part], cells).exp_()
            p = p.expand(-1, *self.shape[:-1], -1).reshape(len(p), -1)
            total[part] += (p @ held.reshape(-1)).numpy()
        return total * self.answer_likelihood(angles_rad)

    def table(self, bins: int) -> Table:
        """Return the joint posterior of `directions` and cells, shape (B, S), summing to one.

        Each angle of the prior stands for the bin nearest to it; summed over directions the table
        is the belief.
        """
        angles, mass, home = self.nodes(bins)
        cell_mass = (self.used + self.unused).reshape(-1, self.n_cells).sum(0)
        weigh: Callable[[Table], Table]
        if self.shared is not None:
            weigh = self.shared.gain
        else:
            used = self.used.reshape(-1, self.n_cells)

            def weigh(angles: Table) -> Table:
                over: Table = (self.ratio(angles) * used).sum(1)
                return over

        if self.answered:
            return self._table_answered(angles, mass, home, bins)
        table = np.zeros((bins, self.n_cells))
        step = max(1, _MOST_NUMBERS // self.used.size)
        for start in range(0, len(mass), step):
            part = slice(start, start + step)
            met, own = np.unique(home[part], return_inverse=True)
            sums = np.zeros((len(met), len(own)))
            sums[own, np.arange(len(own))] = mass[part]
            table[met] += sums @ weigh(angles[part])
        unused = np.zeros(self.n_cells)
        if self.shared is None:
            unused = self.unused.reshape(-1, self.n_cells).sum(0)
        total = table.sum(0)  # restore each cell's mass
        scale = np.divide(cell_mass - unused, total, out=np.zeros_like(total), where=total > 0)
        prior = np.bincount(home, weights=mass, minlength=bins)
        whole: Table = table * scale + prior[:, None] * unused
        return whole

    def _table_answered(
        self, angles: Table, mass: Table, home: NDArray[np.intp], bins: int
    ) -> Table:
        """Return what `table` does, where an answer weighs the fronts."""
        weight = mass * self.answer_likelihood(angles)
        used = self.used.reshape(-1, self.n_cells)
        unused = self.unused.reshape(-1, self.n_cells).sum(0)
        table = np.zeros((bins, self.n_cells))
        step = max(1, _MOST_NUMBERS // self.used.size)
        for start in range(0, len(mass), step):
            part = slice(start, start + step)
            over = (self.ratio(angles[part]) * used).sum(1) + unused
            np.add.at(table, home[part], weight[part, None] * over)
        whole: Table = table / table.sum()
        return whole

    def nodes(self, bins: int) -> tuple[Table, Table, NDArray[np.intp]]:
        """Return angles that stand for the prior, their mass, and the bin each falls into.

        Points of the prior come first, at their own angle; shape (M,) each.
        """
        return frame_nodes(self.prior, bins, self.n_cells)

    def gain_between(self, angles_rad: Table) -> Table:
        """Return the gain of some fronts, of a smooth kernel from its Fourier series of 72 fronts.

        Exact to 1e-9 where the series ends before its 36th harmonic, as that of von Mises shapes
        does up to a concentration of some thirty; other fronts are weighed one by one.
        """
        error = getattr(self.tables.data.model.likelihood, "quadrature_error", 1.0)
        if self.shared is not None or error > 1e-10 or self.prior.is_point or self.answered:
            return self.gain(angles_rad)
        size = np.abs(self._harmonics)
        if size[-_LAST:].max() > _LEFT_OUT * size.max():  # too sharp for so few fronts
            return self.gain(angles_rad)
        order = np.arange(len(self._harmonics))
        waves = np.exp(1j * order * angles_rad[:, None])
        total: Table = (waves @ self._harmonics).real
        return total

    @cached_property
    def _harmonics(self) -> NDArray[np.complex128]:
        few = 2 * math.pi * np.arange(FRAME_BINS) / FRAME_BINS
        found: NDArray[np.complex128] = np.fft.rfft(self.gain(few)) / FRAME_BINS
        found[1 : FRAME_BINS // 2] *= 2  # each stands for the one of the opposite sign too
        return found

    def summaries(self) -> tuple[FrameSummary, ...]:
        """Return the posterior of each part of the prior, most probable first.

        Each part is weighed by how much likelier its fronts have become.
        """
        angles = np.linspace(-math.pi, math.pi, _BINS, endpoint=False)
        gain = self.gain_between(angles)
        parts = [_part(part, angles, gain, self.gain) for part in self.prior.parts]
        lapse = self.prior.lapse * float(gain.mean()) if self.prior.lapse else 0.0
        total = sum(weight for weight, _, _ in parts) + lapse
        summaries = [
            FrameSummary(self.term.ground, self.term.relation, mean, kappa, weight / total)
            for weight, mean, kappa in parts
        ]
        return tuple(sorted(summaries, key=lambda s: -s.p))


def frame_nodes(
    prior: FrameDistribution, bins: int, n_cells: int
) -> tuple[Table, Table, NDArray[np.intp]]:
    """Return angles that stand for a frame's prior, their mass, and the bin each falls into.

    Parameters
    ----------
    prior
        The prior; its points come first, at their own angle.
    bins
        Number of directions B.
    n_cells
        Cells of the map; on large ones one angle stands for a bin.

    Returns
    -------
    tuple of numpy.ndarray
        Radians, probabilities that sum to one, and indices into `directions`, shape (M,) each.
    """
    nodes = _NODES_PER_BIN if n_cells <= _MOST_CELLS else 1
    angles, mass = prior.bins(nodes * bins)
    return angles, mass, np.round(angles * bins / (2 * math.pi)).astype(np.intp) % bins


class _SharedGain:
    """Posterior over prior of a shared front."""

    def __init__(self, shared: SharedFrame, by_cell: Table, prior: FrameDistribution) -> None:
        self._met = shared.angles_rad
        self._gain = by_cell / np.maximum(shared.mass, 1e-300)[:, None]
        # The prior is that of the phrase, which may be another than the first phrase's.
        self._angles, mass = prior.bins(len(np.unique(shared.angles_rad)))
        p = by_cell.sum(1)
        posterior = [p[np.isclose(shared.angles_rad, angle)].sum() for angle in self._angles]
        self._overall = np.array(posterior) / np.maximum(mass, 1e-300)

    def overall(self, angles_rad: Table) -> Table:
        """Return the gain of some fronts, between bins a straight line, shape (B,)."""
        gain: Table = np.interp(angles_rad, self._angles, self._overall, period=2 * math.pi)
        return gain

    def gain(self, angles_rad: Table) -> Table:
        """Return the gain of some fronts at every cell, that of the nearest bin, shape (B, S)."""
        apart = np.abs((angles_rad[:, None] - self._met + math.pi) % (2 * math.pi) - math.pi)
        nearest: Table = self._gain[apart.argmin(1)]
        return nearest


def modes_of(p: Table, angles_rad: Table) -> tuple[tuple[float, float], ...]:
    """Return the directions around which a distribution over directions has its mass.

    Parameters
    ----------
    p
        Probability of each direction, shape (B,).
    angles_rad
        The directions, equally far apart all round, radians, shape (B,).

    Returns
    -------
    tuple of (float, float)
        Mean direction and mass of each quarter of the circle that stands out, most probable first:
        the quarter with the greatest mass, then the next beside it, as long as one holds a fifth
        and more than its share if nothing were known of it.
    """
    left = np.asarray(p, dtype=np.float64) / np.sum(p)
    near = np.cos(angles_rad[:, None] - angles_rad) >= math.sqrt(0.5) - 1e-9
    found: list[tuple[float, float]] = []
    while len(found) < _MOST_MODES:
        mass = near @ left
        top = int(mass.argmax())
        share = left[near[top]].sum()
        if found and share < max(_LEAST_MODE, near[top].mean() + 1e-9):
            break
        weights = np.where(near[top], left, 0.0)
        mean = math.atan2(weights @ np.sin(angles_rad), weights @ np.cos(angles_rad))
        found.append((mean, float(share)))
        left = np.where(near[top], 0.0, left)
    return tuple(found)


def summarise_frames(
    joint: JointPosterior, factors: Sequence[DescriptionFactor], target: str
) -> tuple[FrameSummary, ...]:
    """Return the posterior of every frame that was used in speaking of a target."""
    found: list[FrameSummary] = []
    for framed in framed_relations(factors, target):
        found += FramePosterior(joint, factors[framed.which], target, framed).summaries()
    return tuple(found)


def frame_table(posterior: FramePosterior, grid: Grid, bins: int) -> xarray.DataArray:
    """Return p(front, cell | all that is known), dims angle, y, x; sums to one."""
    import xarray

    return xarray.DataArray(
        posterior.table(bins).reshape(bins, *grid.shape),
        dims=("angle", "y", "x"),
        coords={"angle": _angle(bins), "y": grid.y_m, "x": grid.x_m},
        name="p",
        attrs=_about(posterior.term),
    )


def frame_masses(posterior: FramePosterior, bins: int) -> tuple[Table, Table]:
    """Return p(front | all that is known) and p(front) of `directions`, shape (B,) each."""
    angles, mass, home = posterior.nodes(bins)
    after = mass * posterior.gain_between(angles)
    return _binned(after / after.sum(), home, bins), _binned(mass, home, bins)


def _binned(mass: Table, home: NDArray[np.intp], bins: int) -> Table:
    return np.asarray(np.bincount(home, weights=mass, minlength=bins), dtype=np.float64)


def frame_array(posterior: FramePosterior, bins: int) -> xarray.DataArray:
    """Return p(front | all that is known), dim angle, with the prior as a coordinate."""
    import xarray

    after, before = frame_masses(posterior, bins)
    return xarray.DataArray(
        after,
        dims=("angle",),
        coords={"angle": _angle(bins), "prior": ("angle", before)},
        name="p",
        attrs=_about(posterior.term),
    )


def _part(
    part: FramePart, angles: Table, gain: Table, gain_at: Callable[[Table], Table]
) -> tuple[float, float, float | None]:
    """Return the unnormalised posterior weight, mean and concentration of one part."""
    if math.isinf(part.kappa):
        at = gain_at(np.array([part.mean_rad]))
        return part.weight * float(at[0]), part.mean_rad, None
    density = np.exp(part.log_density(angles))
    density /= density.sum()
    weighed = density * gain
    mean, kappa = circular_summary(weighed, angles)
    return part.weight * float(weighed.sum()), mean, kappa


def _angle(bins: int) -> tuple[str, Table, dict[str, str]]:
    return (
        "angle",
        directions(bins),
        {"units": "rad", "long_name": "front, from east, anticlockwise"},
    )


def _about(term: GroundedRelation) -> dict[str, str]:
    return {"ground": term.ground, "relation": term.relation}
