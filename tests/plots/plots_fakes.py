from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.maps import CityMap


@dataclass(frozen=True)
class Told:
    relation: str
    grounds: tuple[str, ...]
    negated: bool = False


@dataclass(frozen=True)
class Frame:
    ground: str
    relation: str
    mean_rad: float
    kappa: float | None = None
    p: float = 1.0


@dataclass(frozen=True)
class FakePosterior:
    """The least that a posterior must be to be drawn."""

    city: CityMap
    beliefs: dict[str, NDArray[np.float64]]
    told: dict[str, Sequence[Told]] = field(default_factory=dict)
    faces: dict[str, Sequence[Frame]] = field(default_factory=dict)
    texts: tuple[str, ...] = ("It is behind the $5 shop.",)

    @property
    def targets(self) -> tuple[str, ...]:
        return tuple(self.beliefs)

    def belief(self, target: str) -> NDArray[np.float64]:
        return self.beliefs[target]

    def relations(self, target: str) -> Sequence[Told]:
        return self.told.get(target, ())

    def frames(self, target: str) -> Sequence[Frame]:
        return self.faces.get(target, ())


def blob(city: CityMap, x_m: float, y_m: float, sigma_m: float) -> NDArray[np.float64]:
    x, y = np.meshgrid(city.grid.x_m, city.grid.y_m)
    raw = np.exp(-((x - x_m) ** 2 + (y - y_m) ** 2) / (2 * sigma_m**2))
    belief: NDArray[np.float64] = raw / raw.sum()
    return belief
