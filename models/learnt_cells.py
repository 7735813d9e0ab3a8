"""A prior over cells learnt from known places: how dense targets are on each kind of cell."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import CityMap
from sloop_ppl.models.cell_priors import CELL_PRIORS, cells_of
from sloop_ppl.outputs import check_output, written_whole

__all__ = ["FEATURES", "LearntCells", "cell_features", "learn_cells"]

FEATURES = (
    "street",
    "service",
    "pedestrian",
    "parking",
    "square",
    "park",
    "water",
    "building",
    "open",
)
"""What a cell is: the first of these kinds that touches it, ``open`` where none does."""

STRENGTH = 10.0
"""How many places the prior of the learning counts for."""

_KIND = "sloop_ppl prior over cells"


@dataclass(frozen=True)
class LearntCells:
    """Targets are as dense on each kind of cell as they were where they were known.

    Parameters
    ----------
    counts : known places by feature of their cell, one per `FEATURES`, >= 0.
    shares : share of the maps' cells that have the feature, one per `FEATURES`, summing to one.
    strength : how many places the Dirichlet prior counts for, > 0; its mean are the shares, so
        that without places the prior over cells is uniform.

    Raises
    ------
    InputError : when the numbers are not as said.

    Notes
    -----
    Source: ours. P(feature) is (count + strength share) / (n + strength), the mean of its
    posterior; a cell's weight is that divided by the feature's share: a density relative to
    uniform, so that it carries over to maps with more or fewer such cells.
    """

    counts: tuple[int, ...]
    shares: tuple[float, ...]
    strength: float = STRENGTH

    def __post_init__(self) -> None:
        if len(self.counts) != len(FEATURES) or min(self.counts) < 0:
            raise InputError(f"Counts are {self.counts}; expected {len(FEATURES)} of at least 0")
        total = math.fsum(self.shares)
        if len(self.shares) != len(FEATURES) or min(self.shares) < 0 or abs(total - 1) > 1e-6:
            raise InputError(
                f"Shares are {self.shares}; expected {len(FEATURES)} of at least 0 that sum to one"
            )
        if not 0 < self.strength < math.inf:
            raise InputError(f"strength is {self.strength}; expected a number of places > 0")

    @property
    def density(self) -> dict[str, float]:
        """How dense targets are on cells of each feature, relative to uniform."""
        n = sum(self.counts)
        found = {}
        for feature, count, share in zip(FEATURES, self.counts, self.shares, strict=True):
            p = (count + self.strength * share) / (n + self.strength)
            # No map had such cells: nothing is known of them but the overall density.
            found[feature] = p / share if share else 1.0
        return found

    def __call__(self, city: CityMap, target: str) -> NDArray[np.float64]:  # noqa: ARG002
        """Return the weight of each cell, the same for all targets, shape (H, W)."""
        weights: NDArray[np.float64] = np.array(list(self.density.values()))[cell_features(city)]
        return weights

    def save(self, path: str | Path) -> None:
        """Write it to a ``.json`` file, which ``prior=`` and ``--prior`` take.

        Raises
        ------
        OutputError : when the path does not end in ``.json`` or cannot be written.
        """
        told = {
            "kind": _KIND,
            "counts": dict(zip(FEATURES, self.counts, strict=True)),
            "shares": dict(zip(FEATURES, self.shares, strict=True)),
            "strength": self.strength,
        }
        with written_whole(check_output(path, (".json",))) as temporary:
            temporary.write_text(json.dumps(told, indent=2) + "\n", encoding="utf-8")

    @staticmethod
    def load(path: str | Path) -> LearntCells:
        """Read what :meth:`save` wrote.

        Raises
        ------
        InputError : when the file cannot be read or is something else.
        UnknownName : for a feature there is none of.
        """
        try:
            told: Any = json.loads(Path(path).read_text(encoding="utf-8"))
        except OSError as error:
            raise InputError(f"Prior '{path}' cannot be read: {error.strerror}") from error
        except ValueError as error:  # JSONDecodeError, UnicodeDecodeError
            raise InputError(f"Prior '{path}' is no JSON: {error}") from error
        if not isinstance(told, Mapping) or told.get("kind") != _KIND:
            raise InputError(
                f"Prior '{path}' is no prior over cells; expected a file that LearntCells.save "
                "wrote"
            )
        try:
            return LearntCells(
                tuple(int(n) for n in _by_feature(told["counts"])),
                tuple(float(a) for a in _by_feature(told["shares"])),
                float(told["strength"]),
            )
        except UnknownName:
            raise
        except KeyError as error:
            raise InputError(f"Prior '{path}' lacks {error}; save it again") from error
        except (TypeError, ValueError) as error:
            raise InputError(f"Prior '{path}' is not one: {error}") from error


def learn_cells(
    places: Iterable[tuple[CityMap, tuple[float, float]]], strength: float = STRENGTH
) -> LearntCells:
    """Learn a prior over cells from known places.

    Parameters
    ----------
    places : a map and a place (x, y) in metres on it, for each known target.
    strength : how many places the Dirichlet prior counts for, > 0.

    Raises
    ------
    InputError : when there is no place.
    OutsideMap : when one lies outside its map.
    """
    counts = np.zeros(len(FEATURES), dtype=int)
    shares = np.zeros(len(FEATURES))
    for city, place in places:
        features = cell_features(city)
        counts[features[city.grid.cell_at(*place)]] += 1
        shares += np.bincount(features.reshape(-1), minlength=len(FEATURES)) / features.size
    n = int(counts.sum())
    if not n:
        raise InputError("There is no known place to learn from; expected at least one")
    return LearntCells(tuple(map(int, counts)), tuple(map(float, shares / n)), strength)


def cell_features(city: CityMap) -> NDArray[np.intp]:
    """Return the index in `FEATURES` of what each cell is, shape (H, W)."""

    def read() -> NDArray[np.intp]:
        features = np.full(city.grid.shape, len(FEATURES) - 1, dtype=np.intp)
        for index in reversed(range(len(FEATURES) - 1)):
            features[cells_of(city, (FEATURES[index],))] = index
        return features

    return city.derived("features of cells", read)


def _by_feature(told: Mapping[str, Any]) -> list[Any]:
    for name in told:
        if name not in FEATURES:
            raise UnknownName("feature of cells", str(name), FEATURES)
    return [told[feature] for feature in FEATURES]


# The 64 places of this package's 32 example descriptions, on its five maps.
CELL_PRIORS.add(
    "learnt",
    LearntCells(
        counts=(28, 6, 1, 7, 0, 4, 0, 8, 10),
        shares=(0.1742, 0.0597, 0.0120, 0.0571, 0.0, 0.0167, 0.0, 0.4979, 0.1824),
    ),
)
