"""How a relation to another target weighs where both are: a function of how they lie apart.

Shape legend: H, W grid; S = H W cells; M meanings of the relation under latents of its own.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import torch
from torch import Tensor

from sloop_ppl.maps import CityMap, Grid
from sloop_ppl.models._program_data import ProgramData
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.models.grounding import program_data
from sloop_ppl.models.phrase import Phrase
from sloop_ppl.models.presets import ObservationModel

__all__ = ["PairKernel"]

_LEAST = 1e-300

_SAME = 1e-12
"""Half width of a range of logs that counts as one number."""

_EXPANDED, _MOST_TERMS = 1e-12, 48


@dataclass(frozen=True, eq=False)
class PairKernel:
    r"""The log factor of a phrase for each cell of its figure and each cell of its ground.

    Parameters
    ----------
    relation
        The phrase; its ground is a target.
    city, model
        The map and the observation model.
    power
        Exponent of the factor: n^-temper for a figure of n phrases.
    log_meanings
        Given what the program of the phrase alone is run on, returns the log of what holds of each
        cell under each meaning of the phrase, shape (M, S).
    tables
        What others made of it, kept as long as it is.

    Notes
    -----
    Source: ours. The ground is a point at the centre of its cell, whose front may face any way, so
    g(s1 | r, s2) depends on s1 - s2 alone: one table of (2 H - 1)(2 W - 1) displacements holds it.
    Under ``map`` normalisation it is divided by its sum over the figure's cells, for each cell of
    the ground by itself: phi(s1 | s2) = lapse / S + (1 - lapse) g / sum_s1 g. Dividing the whole
    belief of the figure by its sum would keep what is known of the figure from telling anything of
    the ground.
    """

    relation: GroundedRelation
    city: CityMap
    model: ObservationModel
    power: float
    log_meanings: Callable[[ProgramData], Tensor]
    tables: dict[Any, Any] = field(default_factory=dict, init=False, repr=False)

    @property
    def figure(self) -> str:
        """Id of the target that is located."""
        return self.relation.figure

    @property
    def ground(self) -> str:
        """Id of the target that it is located by."""
        return self.relation.ground

    @property
    def is_alternative(self) -> bool:
        """Tell whether its ground may be a place as well; that is then another phrase."""
        return any(choice.kind == "ground" for choice in self.relation.choices)

    @property
    def log_silent(self) -> float:
        """Its log factor where it says nothing."""
        return self.power * self.model.log_uninformative(self.n_cells)

    @property
    def n_cells(self) -> int:
        """How many cells each of the two may be in, S."""
        return self.city.grid.size

    def log_rows(self, cells: Tensor, *, of_figure: bool = False) -> Tensor:
        """Return the log factor for some cells of the ground, at every cell of the figure.

        Parameters
        ----------
        cells
            Cells of the ground, row by row from the south-west, shape (C,).
        of_figure
            True for cells of the figure instead, at every cell of the ground.

        Returns
        -------
        Tensor
            Shape (C, S).
        """
        total: Tensor | None = None
        for log_prior, table, log_z in zip(self._log_priors, *self._tables, strict=True):
            log_p = self._windows(table, cells, of_figure=of_figure)
            log_p -= log_z[None, :] if of_figure else log_z[cells][:, None]
            log_p += log_prior
            total = log_p if total is None else torch.logaddexp(total, log_p)
        assert total is not None  # a phrase has at least one meaning
        log_phi = self._with_lapse(total)
        return log_phi if self.power == 1 else log_phi.mul_(self.power)

    def expansion(self) -> tuple[Tensor, Tensor] | None:
        r"""Return the factor as a sum of products: of a table over the ground and displacements.

        Returns
        -------
        tuple of Tensor or None
            Weights of the ground's cells, shape (J, S), and tables of displacements (figure less
            ground), shape (J, 2 H - 1, 2 W - 1): phi(s1 | s2) = sum_j w_j(s2) k_j(s1 - s2). None
            where there is no such sum that is exact to 1e-10, or where a factor may be too deep
            for sums of exponentials.

        Notes
        -----
        phi depends on the ground's cell by u = log Z(s2) alone, where edges of the map cut off a
        part of g. (c + a g exp(-u))^p is analytic in \|Im u\| < pi, so that Chebyshev's series
        over the range of u, of half width h, falls with the power of pi/h + sqrt((pi/h)^2 + 1).
        """
        (tables, sums) = self._tables
        if len(tables) > 1 or not self._lapse:
            return None
        u, table = sums[0], tables[0]
        middle, half = float(u.max() + u.min()) / 2, float(u.max() - u.min()) / 2
        count = 1
        if half > _SAME:
            rate = math.pi / half + math.hypot(math.pi / half, 1.0)
            count = math.ceil(-math.log(_EXPANDED) / math.log(rate)) + 2
        if count > _MOST_TERMS:
            return None
        angles = (torch.arange(count, dtype=torch.float64) + 0.5) * (math.pi / count)
        nodes = middle + half * angles.cos()
        log_phi = self._with_lapse(table - nodes[:, None, None]) * self.power
        order = torch.arange(count, dtype=torch.float64)
        # Lagrange's polynomials of the nodes, as cosine sums: 2/J sum' T_j(node) T_j(u).
        at = ((u - middle) / max(half, _SAME)).clamp(-1.0, 1.0).acos()
        share = torch.where(order == 0, 1.0, 2.0) / count
        weights = (angles[:, None] * order).cos() * share @ (order[:, None] * at).cos()
        return weights, log_phi.exp()

    @cached_property
    def least(self) -> float:
        """The least log factor, or less."""
        log_priors, (tables, log_z) = self._log_priors, self._tables
        log_p = max(
            float(p + t.min() - z.max()) for p, t, z in zip(log_priors, tables, log_z, strict=True)
        )
        level = self._with_lapse(torch.tensor(log_p, dtype=torch.float64))
        return self.power * float(level)

    @property
    def _lapse(self) -> float:
        return self.model.lapse_of(self.relation)

    def _with_lapse(self, log_p: Tensor) -> Tensor:
        """Return log[(1 - lapse) p + lapse u]; see `sloop_ppl.models.program.with_lapse`."""
        if not self._lapse:
            return log_p
        lapse = torch.as_tensor(self._lapse, dtype=torch.float64)
        level = lapse.log() + self.model.log_uninformative(self.n_cells)
        return torch.logaddexp(log_p + torch.log1p(-lapse), level)

    def _windows(self, table: Tensor, cells: Tensor, *, of_figure: bool) -> Tensor:
        """Return the part of a table of displacements that each cell sees, shape (C, S)."""
        rows, cols = self.city.grid.shape
        # All windows of the table as a view: that of ground (r, c) begins at (H-1-r, W-1-c).
        seen = (table.flip(0, 1) if of_figure else table).unfold(0, rows, 1).unfold(1, cols, 1)
        row = torch.div(cells, cols, rounding_mode="floor")
        return seen[rows - 1 - row, cols - 1 - cells % cols].reshape(len(cells), -1)

    @cached_property
    def _log_priors(self) -> tuple[float, ...]:
        """Log prior of each meaning."""
        own = [latent.prior for latent in self._phrase.own]
        return tuple(math.log(max(math.prod(shares), _LEAST)) for shares in itertools.product(*own))

    @cached_property
    def _tables(self) -> tuple[tuple[Tensor, ...], tuple[Tensor, ...]]:
        """Log of what holds by displacement, (2H-1, 2W-1), and of its sum over figures, (S,)."""
        with torch.no_grad():
            return self._made_tables()

    def _made_tables(self) -> tuple[tuple[Tensor, ...], tuple[Tensor, ...]]:
        data, phrase, grid = self._data, self._phrase, self._data.city.grid
        log_g = self.log_meanings(data)
        level = self.model.log_uninformative(self.n_cells)
        silent = phrase.unless_silent(torch.zeros(*phrase.sizes, 1), 1.0).reshape(-1) > 0
        tables, sums = [], []
        for table, says_nothing in zip(log_g, silent, strict=True):
            log_z = torch.zeros(self.n_cells, dtype=torch.float64)
            if says_nothing:
                tables.append(torch.full(grid.shape, level, dtype=torch.float64))
            else:
                tables.append(table.reshape(grid.shape))
                if self.model.normalisation == "map":
                    log_z = self._log_sums(tables[-1])
            sums.append(log_z)
        return tuple(tables), tuple(sums)

    def _log_sums(self, table: Tensor) -> Tensor:
        """Return the log of the sum over the figure's cells, for each cell of the ground, (S,).

        Sums of windows, along one axis and then the other: all terms are positive, so none cancel.
        """
        rows, cols = self.city.grid.shape
        top = table.max()
        sums = (table - top).exp().unfold(0, rows, 1).sum(-1).unfold(1, cols, 1).sum(-1)
        return sums.flip(0, 1).reshape(-1).clamp_min(_LEAST).log() + top

    @cached_property
    def _data(self) -> ProgramData:
        """What the program of the phrase alone is run on: displacements from a ground at 0."""
        apart = _displacements(self.city)
        at = {self.ground: (0.0, 0.0)}
        term = replace(self.relation, city=apart, points=at, choices=(), holds_when={})
        return program_data({self.figure: (term,)}, apart, self.model)

    @cached_property
    def _phrase(self) -> Phrase:
        return self._data.phrase(self._data.relations[0][0])


def _displacements(city: CityMap) -> CityMap:
    """Return a map whose cells are the displacements between two cells of another."""
    grid = city.grid
    west, north = (0.5 - grid.n_cols) * grid.cell_m, (grid.n_rows - 0.5) * grid.cell_m
    # Half a cell of slack: the extent is a whole number of cells less that.
    east = west + (2 * grid.n_cols - 1.5) * grid.cell_m
    south = north - (2 * grid.n_rows - 1.5) * grid.cell_m
    apart = Grid(west, south, east, north, grid.cell_m)
    return city.derived("displacements", lambda: city.with_grid(apart))
