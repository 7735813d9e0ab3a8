"""What the sensor reports of one target: the one model behind sampling, probability and updates."""

from __future__ import annotations

import math
import random
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import RobotState

__all__ = ["CellLikelihood", "Detector"]


class CellLikelihood(NamedTuple):
    """Probability of what was observed of one target, given its cell.

    Attributes
    ----------
    cells : the cells in view, flat indices.
    inside : probability at each of them, same length.
    outside : probability at every other cell.
    """

    cells: NDArray[np.intp]
    inside: NDArray[np.float64]
    outside: float

    def log_table(self, shape: tuple[int, int]) -> NDArray[np.float64]:
        """Return the natural log as a table over the grid, shape (H, W); minus infinity allowed."""
        table = np.full(shape[0] * shape[1], self.outside)
        table[self.cells] = self.inside
        with np.errstate(divide="ignore"):
            log: NDArray[np.float64] = np.log(table)
        return log.reshape(shape)


class Detector:
    """Detect a target in view with some probability, at a cell near its own; else err or be silent.

    A target in view is detected with the true positive rate; the reported cell is drawn among
    the cells in view with weights ``exp(-d ** 2 / (2 sigma ** 2))`` around its own. Where nothing
    was detected, any cell in view is reported with the false positive rate.

    Parameters
    ----------
    space : the search space, which holds the rates.
    """

    def __init__(self, space: SearchSpace) -> None:
        config = space.config
        self._n_cols = space.n_cols
        self._hit, self._false = config.true_positive_rate, config.false_positive_rate
        self._sigma = config.position_noise_cells
        self._views: dict[int, NDArray[np.intp]] = {}

    def sample(self, robot: RobotState, cell: int, rng: random.Random) -> int:
        """Return the cell at which a target in `cell` is reported, or -1."""
        view = robot.view
        if cell in view and rng.random() < self._hit:
            if not self._sigma:
                return cell
            cells = self._cells(robot)
            weights = self._spread(cells, cell)
            return int(cells[np.searchsorted(np.cumsum(weights), rng.random() * weights.sum())])
        if self._false and view and rng.random() < self._false:
            cells = self._cells(robot)
            return int(cells[int(rng.random() * len(cells))])
        return -1

    def likelihood(self, robot: RobotState, seen: int) -> CellLikelihood:
        """Return the probability of a report (-1 for none) by the target's cell."""
        cells = self._cells(robot)
        n = len(cells)
        false = self._false if n else 0.0
        if seen < 0:
            missed = (1.0 - self._hit) * (1.0 - false)
            return CellLikelihood(cells, np.full(n, missed), 1.0 - false)
        at = cells == seen
        if not at.any():
            return CellLikelihood(cells, np.zeros(n), 0.0)
        if self._sigma:
            reported = np.array([self._spread(cells, int(c))[at][0] for c in cells])
        else:
            reported = at.astype(np.float64)
        inside = self._hit * reported + (1.0 - self._hit) * false / n
        return CellLikelihood(cells, inside, false / n)

    def probability(self, robot: RobotState, cell: int, seen: int) -> float:
        """Return the probability that a target in `cell` is reported at `seen` (-1 for not)."""
        told = self.likelihood(robot, seen)
        return float(told.inside[told.cells == cell][0]) if cell in robot.view else told.outside

    def _cells(self, robot: RobotState) -> NDArray[np.intp]:
        cells = self._views.get(robot.pose)
        if cells is None:
            cells = self._views[robot.pose] = np.array(sorted(robot.view), dtype=np.intp)
        return cells

    def _spread(self, cells: NDArray[np.intp], cell: int) -> NDArray[np.float64]:
        """Return the probabilities with which the cells in view are reported for a detection."""
        row, col = divmod(cell, self._n_cols)
        rows, cols = np.divmod(cells, self._n_cols)
        weights = np.exp(-((rows - row) ** 2 + (cols - col) ** 2) / (2 * self._sigma**2))
        spread: NDArray[np.float64] = weights / math.fsum(weights)
        return spread
