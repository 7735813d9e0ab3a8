from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

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


@dataclass(frozen=True)
class FakeEpisode:
    """The least that a search must be to be drawn."""

    poses: tuple[tuple[float, float, float], ...]
    actions: tuple[str, ...]
    observations: tuple[dict[str, tuple[float, float] | None], ...]
    rewards: tuple[float, ...]
    found_targets: tuple[str, ...]
    places: dict[str, tuple[float, float]]
    views: NDArray[np.bool_]
    beliefs: tuple[dict[str, NDArray[np.float64]], ...] = ()
    discounted_return: float = -12.4


def short_search(city: CityMap, **changes: Any) -> FakeEpisode:
    """Go east, declare too soon, go on, declare rightly what is ahead."""
    x = np.array([-40.0, -25.0, -25.0, -10.0, -10.0, -10.0])
    views = np.zeros((len(x), *city.grid.shape), dtype=bool)
    for i, east in enumerate(x):
        row, col = city.grid.cell_at(float(east), 2.5)
        views[i, row - 1 : row + 2, col + 1 : col + 4] = True
    nothing = {"Cup": None, "Hat": None}
    seen = {"Cup": (2.5, 2.5), "Hat": None}
    made: dict[str, Any] = {
        "poses": tuple((float(v), 2.5, 0.0) for v in x),
        "actions": ("forward", "find", "forward", "turn_left", "find"),
        "observations": (nothing, nothing, seen, seen, seen),
        "rewards": (-10.0, -1000.0, -10.0, -10.0, 1000.0),
        "found_targets": ("Cup",),
        "places": {"Cup": (2.5, 2.5), "Hat": (62.5, -62.5)},
        "views": views,
    }
    return FakeEpisode(**{**made, **changes})
