"""What is believed about where a target is before anything is said: priors over cells, by name."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import CityMap
from sloop_ppl.maps.landmark import PATH_KINDS
from sloop_ppl.registry import Registry

__all__ = ["CELL_PRIORS", "CellPrior", "CellsOfKinds", "UniformCells", "cell_prior", "cells_of"]

Table = NDArray[np.float64]


class CellPrior(Protocol):
    """Anything that weighs the cells of a map for a target."""

    def __call__(self, city: CityMap, target: str) -> Table:
        """Return the weight of each cell, shape (H, W).

        Parameters
        ----------
        city : the map.
        target : id of the target.

        Returns
        -------
        numpy.ndarray
            At least 0, somewhere positive; need not sum to one.
        """


CELL_PRIORS: Registry[CellPrior] = Registry("prior over cells")
"""Priors over cells by name."""


@dataclass(frozen=True)
class UniformCells:
    """Every cell is as likely."""

    def __call__(self, city: CityMap, target: str) -> Table:  # noqa: ARG002 - all targets alike
        """Return ones."""
        return np.ones(city.grid.shape)


@dataclass(frozen=True)
class CellsOfKinds:
    """A share of the probability on the cells of some kinds of landmark, the rest on the others.

    Parameters
    ----------
    kinds : kinds of landmark, such as ``"street"``.
    share : probability that the target is on one of their cells, in (0, 1).

    Raises
    ------
    InputError : when the share is not a probability strictly between 0 and 1.

    Notes
    -----
    Source: ours. Neither share is 0, so that no description can contradict the prior. A map that
    has no such cell, or no other, gets the uniform prior.
    """

    kinds: tuple[str, ...]
    share: float

    def __post_init__(self) -> None:
        if not 0 < self.share < 1:
            raise InputError(
                f"Share of a prior over cells is {self.share}; expected between 0 and 1"
            )

    def __call__(self, city: CityMap, target: str) -> Table:  # noqa: ARG002 - all targets alike
        """Return probabilities, summing to one, shape (H, W)."""
        on = cells_of(city, self.kinds)
        if on.all() or not on.any():
            return np.ones(on.shape)
        table: Table = np.where(on, self.share / on.sum(), (1 - self.share) / (~on).sum())
        return table


def cells_of(city: CityMap, kinds: tuple[str, ...]) -> NDArray[np.bool_]:
    """Return the cells that landmarks of some kinds touch, shape (H, W)."""

    def touched() -> NDArray[np.bool_]:
        cells = np.zeros(city.grid.shape, dtype=bool)
        for landmark in city.of_kind(*kinds):
            cells |= city.cells(landmark.id)
        return cells

    return city.derived(f"cells of {' '.join(kinds)}", touched)


def cell_prior(spec: Any) -> CellPrior:
    """Return the prior over cells that a name, a file or an object means.

    Parameters
    ----------
    spec : a name in `CELL_PRIORS`; a path to a ``.nc`` file (see
        :class:`sloop_ppl.models.cell_files.FileCells`) or a ``.json`` file (see
        :class:`sloop_ppl.models.learnt_cells.LearntCells`); or a `CellPrior`, returned as it is.

    Raises
    ------
    UnknownName : for another name; it lists those there are.
    InputError : when a file cannot be read, or for something else.

    Examples
    --------
    >>> cell_prior("streets").share
    0.95
    """
    if isinstance(spec, str | Path):
        ending = Path(spec).suffix.lower()
        if ending == ".nc":
            from sloop_ppl.models.cell_files import FileCells

            return FileCells.load(spec)
        if ending == ".json":
            from sloop_ppl.models.learnt_cells import LearntCells

            return LearntCells.load(spec)
        if str(spec) not in CELL_PRIORS:
            raise UnknownName(
                CELL_PRIORS.kind,
                str(spec),
                CELL_PRIORS,
                hint=", or the path of a .nc or .json file",
            )
        return CELL_PRIORS[str(spec)]
    if not callable(spec):
        raise InputError(
            f"Prior over cells is a {type(spec).__name__}; expected one of "
            f"{', '.join(CELL_PRIORS)}, a file, or a function of a map and a target's id"
        )
    made: CellPrior = spec
    return made


_PATHS = tuple(sorted(PATH_KINDS))
CELL_PRIORS.add("uniform", UniformCells())
CELL_PRIORS.add("streets", CellsOfKinds(_PATHS, share=0.95))
CELL_PRIORS.add("off-streets", CellsOfKinds(_PATHS, share=0.05))
