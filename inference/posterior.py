"""The belief over each target's cell after language and sensing, with its latents open to view."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from sloop_ppl.errors import BeliefCollapse, InputError, UnknownName
from sloop_ppl.inference.engine import InferenceInfo
from sloop_ppl.inference.frames import FrameSummary, summarise_frame
from sloop_ppl.inference.summaries import entropy_nats, expected_m, hpd_cells, mode_m
from sloop_ppl.language import Description, SpatialRelation
from sloop_ppl.maps import CityMap
from sloop_ppl.models import Preset, RelationTerm

if TYPE_CHECKING:
    import xarray

__all__ = ["Posterior", "Said"]

Table = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Said:
    """What one description says of one target, weighed.

    Parameters
    ----------
    description : the description.
    components : names of the mixture's components, length K.
    log_factor : log of component weight times likelihood, shape (K, S).
    terms : the relations of the target, grounded.
    """

    description: Description
    components: tuple[str, ...]
    log_factor: Table
    terms: tuple[RelationTerm, ...]


@dataclass(frozen=True, eq=False, repr=False)
class Posterior:
    """What is believed about where targets are. Immutable: evidence returns a new one.

    Shape legend: H, W grid; S = H W cells; K components.

    Parameters
    ----------
    city : the map.
    model : the observation model.
    engine : name of the engine that weighs what is said.
    log_prior : target -> log belief before anything was said, shape (S,).
    said : target -> what was said of it, in any order.
    log_sensed : target -> log likelihood of all that was sensed, shape (S,).
    info : how the last inference went.

    Notes
    -----
    The posterior of a target's component and cell given all descriptions d is
    prior(s) sensed(s) prod_d sum_k factor_d(k, s): a new component is drawn for each description,
    so two updates are not one longer description, and updates commute.
    """

    city: CityMap
    model: Preset
    engine: str
    log_prior: Mapping[str, Table]
    said: Mapping[str, tuple[Said, ...]]
    log_sensed: Mapping[str, Table]
    info: InferenceInfo | None = None
    _cache: dict[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        told = []
        for target in self.targets:
            x, y = self.mode(target)
            told.append(f"{target} near ({x:g}, {y:g}) m, {self.entropy(target):.2f} nats")
        return f"Posterior({self.city.name!r}, {self.model.name!r}: {'; '.join(told)})"

    @property
    def targets(self) -> tuple[str, ...]:
        """Ids of the targets."""
        return tuple(self.log_prior)

    def belief(self, target: str) -> Table:
        """Return the probability of each cell, summing to one, row 0 in the south, shape (H, W)."""
        return self._log_belief(target)[0].reshape(self.city.grid.shape)

    @property
    def descriptions(self) -> tuple[Description, ...]:
        """The distinct descriptions, in the order they came."""
        met = [part.description for target in self.targets for part in self.said[target]]
        return tuple({id(d): d for d in met}.values())

    @property
    def texts(self) -> tuple[str, ...]:
        """The texts of the descriptions, in the order they came."""
        return tuple(d.text for d in self.descriptions)

    @property
    def log_evidence(self) -> float:
        """Log probability of all that was said and sensed, summed over targets."""
        return float(sum(self._log_belief(target)[1] for target in self.targets))

    def component(self, target: str, which: int = -1) -> dict[str, float]:
        """Return the posterior probability of each component.

        Parameters
        ----------
        target : id of the target.
        which : which description about the target, the latest by default.

        Returns
        -------
        dict
            Component name -> probability; empty when nothing was said of the target.
        """
        said = self._said(target)
        if not said:
            return {}
        joint = self._joint(target, which)
        return dict(zip(said[which].components, map(float, joint.sum(1)), strict=True))

    def frames(self, target: str) -> tuple[FrameSummary, ...]:
        """Return the posterior of every frame that was used in speaking of a target.

        One entry per part of the frame's prior (a street has two normals, left and right have the
        map's frame and the ground's), in the order the relations were said.
        """
        uses = np.array([part.uses_frames for part in self.model.components])
        summaries: list[FrameSummary] = []
        for which, said in enumerate(self._said(target)):
            framed = [term for term in said.terms if term.needs_frame and uses.any()]
            joint = self._joint(target, which) if framed else np.zeros((len(uses), 0))
            for term in framed:
                used, unused = joint[uses].sum(0), float(joint[~uses].sum())
                summaries += summarise_frame(term, self.model, used, unused)
        return tuple(summaries)

    def relations(self, target: str) -> tuple[SpatialRelation, ...]:
        """Return what was said of a target."""
        return tuple(r for said in self._said(target) for r in said.description.about(target))

    def mode(self, target: str) -> tuple[float, float]:
        """Return x and y of the most probable cell's centre, metres."""
        return mode_m(self.belief(target), self.city.grid)

    def expected(self, target: str) -> tuple[float, float]:
        """Return the mean place, metres."""
        return expected_m(self.belief(target), self.city.grid)

    def entropy(self, target: str) -> float:
        """Return the entropy of a target's belief, nats."""
        return entropy_nats(self.belief(target))

    def hpd(self, target: str, mass: float = 0.9) -> NDArray[np.bool_]:
        """Return the smallest set of cells holding at least `mass`, shape (H, W)."""
        if not 0 < mass <= 1:
            raise InputError(f"mass is {mass}; expected a probability in (0, 1]")
        return hpd_cells(self.belief(target), mass)

    def update(self, description: Description, rng: np.random.Generator | None = None) -> Posterior:
        """Return the posterior after one more description; the order of updates is irrelevant.

        Parameters
        ----------
        description : what is said now. Targets not known so far start from a uniform prior.
        rng : wanted by engines that draw.
        """
        from sloop_ppl.inference.infer import infer_description

        later, _ = infer_description(
            description, self.city, self.model, self.engine, prior=None, rng=rng
        )
        new_prior = {t: p for t, p in later.log_prior.items() if t not in self.log_prior}
        return replace(
            later,
            log_prior={**self.log_prior, **new_prior},
            said={
                target: (*self.said.get(target, ()), *later.said.get(target, ()))
                for target in dict.fromkeys((*self.targets, *later.targets))
            },
            log_sensed={**later.log_sensed, **self.log_sensed},
            _cache={},
        )._checked(description)

    def condition(self, log_likelihood: Mapping[str, Table]) -> Posterior:
        """Return the posterior after sensing; components and frames move with the cells.

        Parameters
        ----------
        log_likelihood : target -> log likelihood of what was sensed at each cell, at most 0 up to
            a constant, -inf where impossible, shape (H, W).

        Raises
        ------
        BeliefCollapse : when nothing that was believed possible remains.
        InputError : when a table has the wrong shape or holds NaN or +inf.
        """
        sensed = dict(self.log_sensed)
        for target, table in log_likelihood.items():
            self._said(target)
            flat = np.asarray(table, dtype=np.float64)
            if flat.shape != self.city.grid.shape:
                raise InputError(
                    f"Log likelihood of '{target}' has shape {flat.shape}; expected "
                    f"{self.city.grid.shape}"
                )
            if np.isnan(flat).any() or np.isposinf(flat).any():
                raise InputError(f"Log likelihood of '{target}' holds NaN or +inf")
            sensed[target] = sensed[target] + flat.reshape(-1)
        return replace(self, log_sensed=sensed, _cache={})._checked(log_likelihood)

    @property
    def dataset(self) -> xarray.Dataset:
        """The posterior as an xarray Dataset: belief(target, y, x) and what it is made of."""
        from sloop_ppl.inference.store import to_dataset

        return to_dataset(self)

    def save(self, path: str | Path) -> None:
        """Write the posterior, its map and its descriptions to a netCDF file.

        Raises
        ------
        OutputError : when the path does not end in ``.nc`` or cannot be written.
        """
        from sloop_ppl.inference.store import save_posterior

        save_posterior(self, path)

    @staticmethod
    def load(path: str | Path) -> Posterior:
        """Read a posterior that :meth:`save` wrote.

        Raises
        ------
        InputError : when the file is not a saved posterior.
        """
        from sloop_ppl.inference.store import load_posterior

        return load_posterior(path)

    def _said(self, target: str) -> tuple[Said, ...]:
        if target not in self.log_prior:
            raise UnknownName("target", target, self.targets)
        return self.said[target]

    def _log_belief(self, target: str) -> tuple[Table, float]:
        """Return belief, shape (S,), and log evidence."""
        if target not in self._cache:
            log_p = self._log_weight(target)
            total = float(logsumexp(log_p))
            belief = np.exp(log_p - total)
            self._cache[target] = belief / belief.sum(), total
        cached: tuple[Table, float] = self._cache[target]
        return cached

    def _log_weight(self, target: str, leave_out: int | None = None) -> Table:
        """Return prior, sensing and descriptions (but one) at each cell, shape (S,)."""
        said = self._said(target)
        skip = None if leave_out is None else leave_out % len(said)
        log_p: Table = self.log_prior[target] + self.log_sensed[target]
        for i, part in enumerate(said):
            if i != skip:
                log_p = log_p + logsumexp(part.log_factor, axis=0)
        return log_p

    def _joint(self, target: str, which: int) -> Table:
        """Return the posterior of component and cell for one description, shape (K, S)."""
        log_joint = self._log_weight(target, which) + self._said(target)[which].log_factor
        joint: Table = np.exp(log_joint - logsumexp(log_joint))
        return joint

    def _checked(self, observation: object) -> Posterior:
        """Return itself unless some target has nowhere left to be."""
        for target in self.targets:
            if not np.isfinite(logsumexp(self._log_weight(target))):
                raise BeliefCollapse(
                    f"Nothing that was believed about '{target}' is possible after this "
                    "observation; check it, or start from a prior without zeros",
                    observation=observation,
                )
        return self
