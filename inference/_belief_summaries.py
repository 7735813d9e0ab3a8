"""What any belief over a map's cells is summed up by."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.inference.summaries import (
    entropy_nats,
    expected_distance_m,
    expected_m,
    hpd_cells,
    mode_m,
    probability_in,
)
from sloop_ppl.maps import CityMap

__all__ = ["BeliefSummaries"]

Table = NDArray[np.float64]


class BeliefSummaries(ABC):
    """Where a target is: numbers and regions of a belief over the cells of a map."""

    city: CityMap

    @abstractmethod
    def belief(self, target: str) -> Table:
        """Return the probability of each cell, summing to one, row 0 in the south, shape (H, W)."""

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

    def expected_distance(self, target: str, place_m: tuple[float, float]) -> float:
        """Return the mean distance from a place (x, y) to the target, metres."""
        return expected_distance_m(self.belief(target), self.city.grid, place_m)

    def probability_in(self, target: str, polygon: Any) -> float:
        """Return the probability that a target is inside a shapely polygon, metres.

        A cell that is partly inside counts by the share of its area.

        Raises
        ------
        InputError
            When it is no polygon, is empty, or crosses itself.
        """
        return probability_in(self.belief(target), self.city.grid, polygon)
