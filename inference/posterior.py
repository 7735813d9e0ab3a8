"""The belief over each target's cell after language and sensing, with its latents open to view."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import BeliefCollapse, InputError, NoRelationFound, UnknownName
from sloop_ppl.inference.coupling import Coupling
from sloop_ppl.inference.draws import draws_from, uniforms_for
from sloop_ppl.inference.engine import InferenceInfo
from sloop_ppl.inference.export_geojson import cells_geojson
from sloop_ppl.inference.frames import FrameSummary, summarise_frame, summarise_shared_frame
from sloop_ppl.inference.fronts import find_framed
from sloop_ppl.inference.influence import Influence, influence_on
from sloop_ppl.inference.lapses import Lapse, lapses_of
from sloop_ppl.inference.log_evidence import LogEvidence, words_of
from sloop_ppl.inference.regions import probability_in
from sloop_ppl.inference.said import Said
from sloop_ppl.inference.summaries import (
    entropy_nats,
    expected_distance_m,
    expected_m,
    hpd_cells,
    mode_m,
)
from sloop_ppl.inference.tables import (
    component_table,
    component_weights,
    frame_array,
    frame_table,
    responsibility_table,
)
from sloop_ppl.language import Description, SpatialRelation
from sloop_ppl.maps import CityMap
from sloop_ppl.models import Preset

if TYPE_CHECKING:
    import xarray

    from sloop_ppl.models.simulate import Simulated

__all__ = ["Posterior"]

Table = NDArray[np.float64]


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
    so two updates are not one longer description, and updates commute. Frames that a description
    shares between targets couple their beliefs: what is learnt of one tells of the other.
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
        self._said(target)
        if target not in self._cache:
            self._cache[target] = self._coupling.belief(target).reshape(self.city.grid.shape)
        belief: Table = self._cache[target]
        return belief

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
    def log_evidence(self) -> LogEvidence:
        """Log probability of all that was said and sensed; it ranks no unlike models.

        See :func:`sloop_ppl.inference.rank_models`.
        """
        return LogEvidence(
            self._coupling.log_evidence,
            self.model.normalisation,
            self.model.name,
            words_of(self),
        )

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
        if not -len(said) <= which < len(said):
            raise InputError(f"which is {which}; '{target}' has {len(said)} descriptions")
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
            joint = self._coupling.joint(target, which) if framed else np.zeros((1, len(uses), 0))
            for term in framed:
                if term.ground in said.shared.grounds:
                    settings = self._coupling.settings(said)
                    summaries += summarise_shared_frame(term, self.model, said.shared, settings)
                else:
                    used, unused = joint[:, uses].sum((0, 1)), float(joint[:, ~uses].sum())
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

    def frame(
        self, target: str, ground: str | None = None, relation: int | None = None, bins: int = 72
    ) -> xarray.DataArray:
        """Return how probable each direction of a ground's front is.

        Parameters
        ----------
        target : id of the target it was said of.
        ground : id of the landmark; may be left out when the target has one frame only.
        relation : index in :meth:`relations`, when two relations speak of the same ground.
        bins : number of equal directions B, the first centred on east, anticlockwise.

        Returns
        -------
        xarray.DataArray
            Dim angle (radians), sums to one; its coordinate ``prior`` is what was believed before.

        Raises
        ------
        InputError : when nothing depends on a frame, or several frames fit.
        UnknownName : when there is no such target, or no frame of such a ground.
        """
        return frame_array(self, target, find_framed(self, target, ground, relation), bins)

    def joint(self, target: str, which: int = -1) -> xarray.DataArray:
        """Return p(component, cell), dims component, y, x, for one description of a target."""
        self._said(target)
        return component_table(self, target, which)

    def component_prior(self, target: str, which: int = -1) -> dict[str, float]:
        """Return the prior weight of each component of a description, 0 where it does not apply."""
        return component_weights(self, target, which) if self._said(target) else {}

    def joint_frame(
        self, target: str, relation: int | None = None, ground: str | None = None, bins: int = 72
    ) -> xarray.DataArray:
        """Return p(front, cell), dims angle, y, x, for one frame; arguments as in :meth:`frame`."""
        return frame_table(self, target, find_framed(self, target, ground, relation), bins)

    def responsibilities(self, target: str, which: int = -1) -> xarray.DataArray:
        """Return p(component | cell), dims component, y, x; NaN where the target cannot be."""
        self._said(target)
        return responsibility_table(self, target, which)

    def influence(
        self, target: str, rng: np.random.Generator | None = None
    ) -> tuple[Influence, ...]:
        """Return how many bits each relation moves the belief: inferred again without it.

        Parameters
        ----------
        target : id of the target.
        rng : wanted by engines that draw.
        """
        self._said(target)
        return influence_on(self, target, rng)

    def lapses(self, target: str) -> tuple[Lapse, ...]:
        """Return how probable it is that each relation of a target is wrong, given everything."""
        return lapses_of(self, target)

    def expected_distance(self, target: str, place_m: tuple[float, float]) -> float:
        """Return the mean distance from a place (x, y) to the target, metres."""
        return expected_distance_m(self.belief(target), self.city.grid, place_m)

    def probability_in(self, target: str, polygon: Any) -> float:
        """Return the probability that a target is inside a shapely polygon, metres.

        A cell that is partly inside counts by the share of its area.

        Raises
        ------
        InputError : when it is no polygon, is empty, or crosses itself.
        """
        return probability_in(self.belief(target), self.city.grid, polygon)

    def draws(self, target: str, n: int, *, rng: np.random.Generator) -> xarray.Dataset:
        """Draw cells, components and fronts together.

        Parameters
        ----------
        target : id of the target.
        n : how many, > 0.
        rng : where they are drawn from.

        Returns
        -------
        xarray.Dataset
            See :func:`sloop_ppl.inference.draws.draws_from`.
        """
        return draws_from(self, target, uniforms_for(self, target, n, rng))

    def utterances(
        self, target: str, n: int, *, rng: np.random.Generator, **options: Any
    ) -> tuple[Simulated, ...]:
        """Draw what would be said of a target, as far as is known where it is.

        Parameters
        ----------
        target : id of the target.
        n : how many descriptions, > 0.
        rng : where they are drawn from.
        **options : ``speaker``, ``phrases``, ``grounds``; see
            :func:`sloop_ppl.inference.utterances.utterances_about`.
        """
        from sloop_ppl.inference.utterances import utterances_about

        return utterances_about(self, target, n, rng=rng, **options)

    def to_geojson(self, target: str | None = None, least: float = 0.0) -> dict[str, Any]:
        """Return the cells of a target, or of all, as GeoJSON squares with their probability.

        Parameters
        ----------
        target : id of the target; None for all.
        least : cells of a lower probability are left out, in [0, 1).

        Raises
        ------
        InputError : when the map has no centre on earth.
        """
        return cells_geojson(self, self.targets if target is None else (target,), least)

    def to_arviz(self, n: int = 1000, *, rng: np.random.Generator | None = None) -> Any:
        """Return n draws of every target as an ArviZ InferenceData (needs ``sloop-ppl[arviz]``).

        Parameters
        ----------
        n : draws of each target, > 0.
        rng : where they are drawn from; None for draws that lie evenly, the same every time.
        """
        from sloop_ppl.inference.export_arviz import to_arviz

        return to_arviz(self, n, rng)

    def update(self, description: Description, rng: np.random.Generator | None = None) -> Posterior:
        """Return the posterior after one more description; the order of updates is irrelevant.

        Parameters
        ----------
        description : what is said now. Targets not known so far start from a uniform prior.
        rng : wanted by engines that draw.

        Raises
        ------
        NoRelationFound : when the description speaks of no target.
        BeliefCollapse : when it excludes all that was believed.
        """
        from sloop_ppl.inference.infer import infer_description

        if not description.targets:
            raise NoRelationFound(
                f"'{description.text}' says nothing of any target; expected at least one relation"
            )
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
        )._checked(description, self)

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
        return replace(self, log_sensed=sensed, _cache={})._checked(log_likelihood, self)

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

    @property
    def _coupling(self) -> Coupling:
        if "" not in self._cache:
            self._cache[""] = Coupling(self.log_prior, self.log_sensed, self.said)
        coupling: Coupling = self._cache[""]
        return coupling

    def _responsibilities(self, target: str, which: int) -> Table:
        """Return p(component | cell) for one description, NaN where p(cell) is 0, shape (K, S)."""
        joint = self._joint(target, which)
        mass = joint.sum(0)
        share: Table = np.divide(joint, mass, out=np.full_like(joint, np.nan), where=mass > 0)
        return share

    def _joint(self, target: str, which: int) -> Table:
        """Return the posterior of component and cell for one description, shape (K, S)."""
        self._said(target)
        joint: Table = self._coupling.joint(target, which).sum(0)
        return joint

    def _checked(self, observation: object, before: Posterior | None = None) -> Posterior:
        """Return itself unless some target has nowhere left to be."""
        for target in self.targets:
            if not self._coupling.possible(target):
                raise BeliefCollapse(
                    f"Nothing that was believed about '{target}' is possible after this "
                    "observation; check it, or start from a prior without zeros",
                    prior=self.log_prior[target] if before is None else before.belief(target),
                    observation=observation,
                )
        return self
