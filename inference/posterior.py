"""The belief over each target's cell after language and sensing, with its latents open to view."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import UnknownName
from sloop_ppl.inference.cells import CellQuestions
from sloop_ppl.inference.coupling import Coupling
from sloop_ppl.inference.engine import InferenceInfo
from sloop_ppl.inference.export_geojson import cells_geojson
from sloop_ppl.inference.latents import LatentQuestions
from sloop_ppl.inference.log_evidence import LogEvidence, words_of
from sloop_ppl.inference.said import Said
from sloop_ppl.language import Description, SpatialRelation
from sloop_ppl.maps import CityMap
from sloop_ppl.models import Preset

if TYPE_CHECKING:
    import xarray

__all__ = ["Posterior"]

Table = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Posterior(CellQuestions, LatentQuestions):
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
    What it can be asked is in :class:`sloop_ppl.inference.cells.CellQuestions` and
    :class:`sloop_ppl.inference.latents.LatentQuestions`.
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

    def relations(self, target: str) -> tuple[SpatialRelation, ...]:
        """Return what was said of a target."""
        return tuple(r for said in self._said(target) for r in said.description.about(target))

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
        from sloop_ppl.inference.updates import updated

        return updated(self, description, rng)

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
        from sloop_ppl.inference.updates import conditioned

        return conditioned(self, log_likelihood)

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

    def _joint(self, target: str, which: int) -> Table:
        """Return the posterior of component and cell for one description, shape (K, S)."""
        self._said(target)
        joint: Table = self._coupling.joint(target, which).sum(0)
        return joint
