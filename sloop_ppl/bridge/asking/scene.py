"""What a kind of question may ask of the map: the geometry of its landmarks at some cells."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.bridge.asking.answerer_model import AnswererModel
from sloop_ppl.bridge.asking.landmark_salience import askable_landmarks
from sloop_ppl.bridge.relation_text import names_of
from sloop_ppl.inference import Posterior
from sloop_ppl.language import SPEAKER, TargetObject
from sloop_ppl.language._place_names import PlaceNames
from sloop_ppl.maps import CityMap

__all__ = ["Scene"]

Table = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Scene:
    """A target that questions are asked about, and the cells at which they are looked at.

    Shape legend: S cells of the scene.

    Parameters
    ----------
    posterior
        What is believed.
    target
        Id of the target.
    landmarks
        Ids of the landmarks to ask about, the nearest to the belief first.
    cells
        Flat indices of the cells; all of the map when None.
    person
        How the person who is asked is believed to see directions and distances.
    """

    posterior: Posterior
    target: str
    landmarks: tuple[str, ...] = ()
    cells: NDArray[np.intp] | None = None
    person: AnswererModel = field(default_factory=AnswererModel)
    _kept: dict[tuple[str, str], Table] = field(default_factory=dict, repr=False)

    @classmethod
    def of(
        cls,
        posterior: Posterior,
        target: str,
        *,
        most: int = 14,
        landmarks: tuple[str, ...] | None = None,
        person: AnswererModel | None = None,
    ) -> Scene:
        """Return the scene of a target with the landmarks that are worth asking about.

        Parameters
        ----------
        posterior, target
            As in the class.
        most
            How many landmarks.
        landmarks
            Those to ask about, where they are given.
        person
            How the person is believed to answer.
        """
        city = posterior.city
        if landmarks is None:
            mentioned = {g for r in posterior.relations(target) for g in r.grounds if g in city}
            landmarks = askable_landmarks(city, posterior.belief(target), mentioned, most)
        return cls(posterior, target, landmarks, person=person or AnswererModel())

    def at(self, cells: NDArray[np.intp] | None) -> Scene:
        """Return the same scene looked at in other cells."""
        return replace(self, cells=cells, _kept={})

    @property
    def city(self) -> CityMap:
        """The map."""
        return self.posterior.city

    @cached_property
    def names(self) -> PlaceNames:
        """What places are called to who described the target."""
        return names_of(self.posterior)

    @cached_property
    def x_m(self) -> Table:
        """Metres east of each cell's centre, shape (S,)."""
        grid = self.city.grid
        return self._own(np.broadcast_to(grid.x_m[None, :], grid.shape))

    @cached_property
    def y_m(self) -> Table:
        """Metres north of each cell's centre, shape (S,)."""
        grid = self.city.grid
        return self._own(np.broadcast_to(grid.y_m[:, None], grid.shape))

    def distance_m(self, landmark: str) -> Table:
        """Return metres to a landmark's nearest cell, 0 on it, shape (S,)."""
        key = "distance", landmark
        if key not in self._kept:
            self._kept[key] = self._own(self.city.fields(landmark).distance_m)
        return self._kept[key]

    def _log_distances(self, landmark: str) -> tuple[Table, Table]:
        """Return logarithms of metres to nearest edge and middle, from half a cell on."""
        key, other = ("log distance", landmark), ("log from middle", landmark)
        if key not in self._kept:
            least = self.city.grid.cell_m / 2
            self._kept[key] = np.log(np.maximum(self.distance_m(landmark), least))
            x, y = self.city.centroid(landmark)
            apart = np.hypot(self.x_m - x, self.y_m - y)
            self._kept[other] = np.log(np.maximum(apart, least))
        return self._kept[key], self._kept[other]

    def farther(self, landmark: str, than_m: float) -> Table:
        """Return how probably each cell is found farther than so many metres, shape (S,)."""
        edge, middle = self._log_distances(landmark)
        return self._mixed(lambda log_m: self.person.farther(log_m, math.log(than_m)), edge, middle)

    def nearer_to_other(self, landmark: str, other: str) -> Table:
        """Return how probably each cell is found nearer to another landmark, shape (S,)."""
        pairs = zip(self._log_distances(landmark), self._log_distances(other), strict=True)
        edge, middle = (one - two for one, two in pairs)
        # Both distances are seen with an error of their own.
        return self._mixed(lambda r: self.person.farther(r / math.sqrt(2), 0.0), edge, middle)

    def covered(self, landmark: str) -> Table:
        """Return how probably something in each cell is inside a landmark, shape (S,).

        A cell that a landmark only touches counts by the share of such cells that it covers; for
        who sees exactly all cells that it touches are inside.
        """
        inside = self.distance_m(landmark) == 0.0
        if self.person.distance_share == 0.0:
            return np.asarray(inside, dtype=np.float64)
        key = "covered", landmark
        if key not in self._kept:
            cells = self.city.cells(landmark)
            around = np.pad(cells, 1, mode="edge")
            core = cells & around[:-2, 1:-1] & around[2:, 1:-1]
            core &= around[1:-1, :-2] & around[1:-1, 2:]
            border = cells & ~core
            area = self.city.footprint(landmark).area / self.city.grid.cell_m**2
            share = np.clip((area - core.sum()) / max(int(border.sum()), 1), 0.0, 1.0)
            self._kept[key] = self._own(np.where(border, share, core.astype(np.float64)))
        return self._kept[key]

    def _mixed(self, seen: Callable[[Table], Table], usual: Table, other: Table) -> Table:
        """Average what is seen over the two ways to measure."""
        share = self.person.other_geometry
        if share == 0.0:
            return seen(usual)
        return (1.0 - share) * seen(usual) + share * seen(other)

    def edge_bearing_rad(self, landmark: str) -> Table:
        """Return the direction from a landmark's nearest edge, that of its middle on it, (S,)."""
        fields, grid = self.city.fields(landmark), self.city.grid
        rows, cols = (self._own(part).astype(np.intp) for part in fields.nearest)
        bearing = np.arctan2(self.y_m - grid.y_m[rows], self.x_m - grid.x_m[cols])
        on_it = self.distance_m(landmark) == 0.0
        found: Table = np.where(on_it, self.bearing_rad(landmark), bearing)
        return found

    def bearing_rad(self, landmark: str) -> Table:
        """Return the direction from a landmark's centroid, radians from east, shape (S,)."""
        key = "bearing", landmark
        if key not in self._kept:
            x, y = self.city.centroid(landmark)
            self._kept[key] = np.arctan2(self.y_m - y, self.x_m - x)
        return self._kept[key]

    def quarters(self, landmark: str) -> Table:
        """Return how probably cells are seen north, east, south, west of it, shape (4, S)."""

        def make() -> Table:
            usual, share = self.bearing_rad(landmark), self.person.other_geometry
            other = self.edge_bearing_rad(landmark) if share else usual
            return self._mixed(self.person.quarters, usual, other)

        if self.cells is not None:
            return make()
        person = f"{self.person.angle_deg:g} {self.person.other_geometry:g}"
        return self.city.derived(f"asking: quarters {person} {landmark}", make)

    def belief(self) -> Table:
        """Return the probability of each cell, shape (S,); it sums to one over all of the map."""
        return self._own(self.posterior.belief(self.target))

    def label(self, landmark: str) -> str:
        """Return what a landmark is called."""
        return self.names.of(landmark)

    @cached_property
    def subject(self) -> str:
        """The target as it is spoken of to who answers, with its verb: "is the red honda"."""
        return "are you" if self.target == SPEAKER else f"is {self.noun}"

    @cached_property
    def noun(self) -> str:
        """The target as it is spoken of to who answers: "the red honda", "your dog", "you"."""
        if self.target == SPEAKER:
            return "you"
        known = {t.id: t for d in self.posterior.descriptions for t in d.targets}
        names = known.get(self.target, TargetObject(self.target)).names
        name = names[0] if names else self.target
        first, _, rest = name.partition(" ")
        if first.casefold() in ("my", "our"):
            return f"your {rest}"
        return (
            name if not names or first.casefold() in ("the", "a", "his", "her") else f"the {name}"
        )

    def _own(self, table: NDArray[np.float64]) -> Table:
        flat = np.asarray(table, dtype=np.float64).reshape(-1)
        return flat if self.cells is None else flat[self.cells]
