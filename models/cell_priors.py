"""What is believed about where a target is before anything is said: priors over cells, by name."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sloop_ppl._foreign import ForeignFault, parse_json, read_text
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import CityMap
from sloop_ppl.maps.landmark import PATH_KINDS
from sloop_ppl.outputs import check_output, written_whole
from sloop_ppl.registry import Registry

__all__ = [
    "CELL_PRIORS",
    "FEATURES",
    "CellPrior",
    "CellsOfKinds",
    "LearntCells",
    "UniformCells",
    "cell_features",
    "cell_prior",
    "learn_cells",
]

Table = NDArray[np.float64]

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
"""How many places the prior of the learning counts for, spread over features as the cells are:
enough that a feature without a place keeps some weight, few beside some tens of places."""

_KIND = "sloop_ppl prior over cells"


class CellPrior(Protocol):
    """Anything that weighs the cells of a map for a target."""

    def __call__(self, city: CityMap, target: str) -> Table:
        """Return the weight of each cell, shape (H, W).

        Parameters
        ----------
        city
            The map.
        target
            Id of the target.

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
    kinds
        Kinds of landmark, such as ``"street"``.
    share
        Probability that the target is on one of their cells, in (0, 1).

    Raises
    ------
    InputError
        When the share is not a probability strictly between 0 and 1.

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
        on = _cells_of(city, self.kinds)
        if on.all() or not on.any():
            return np.ones(on.shape)
        table: Table = np.where(on, self.share / on.sum(), (1 - self.share) / (~on).sum())
        return table


@dataclass(frozen=True)
class LearntCells:
    """Targets are as dense on each kind of cell as they were where they were known.

    Parameters
    ----------
    counts
        Known places by feature of their cell, one per `FEATURES`, >= 0.
    shares
        Share of the maps' cells that have the feature, one per `FEATURES`, summing to one.
    strength
        How many places the Dirichlet prior counts for, > 0; its mean are the shares, so that
        without places the prior over cells is uniform.

    Raises
    ------
    InputError
        When the numbers are not as said.

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
        OutputError
            When the path does not end in ``.json`` or cannot be written.
        """
        payload = {
            "kind": _KIND,
            "counts": dict(zip(FEATURES, self.counts, strict=True)),
            "shares": dict(zip(FEATURES, self.shares, strict=True)),
            "strength": self.strength,
        }
        with written_whole(check_output(path, (".json",))) as temporary:
            temporary.write_text(json.dumps(payload, indent=2) + "\n", encoding="utf-8")

    @staticmethod
    def load(path: str | Path) -> LearntCells:
        """Read what :meth:`save` wrote.

        Raises
        ------
        InputError
            When the file cannot be read or is something else.
        UnknownName
            For a feature there is none of.
        """
        text = read_text(path, "Prior")
        try:
            payload: Any = parse_json(text)
        except ForeignFault as error:
            raise InputError(f"Prior '{path}' is no JSON: {error}") from error
        if not isinstance(payload, Mapping) or payload.get("kind") != _KIND:
            raise InputError(
                f"Prior '{path}' is no prior over cells; expected a file that LearntCells.save "
                "wrote"
            )
        try:
            return LearntCells(
                tuple(int(n) for n in _by_feature(payload["counts"])),
                tuple(float(a) for a in _by_feature(payload["shares"])),
                float(payload["strength"]),
            )
        except UnknownName:
            raise
        except KeyError as error:
            raise InputError(f"Prior '{path}' lacks {error}; save it again") from error
        except (TypeError, ValueError, OverflowError) as error:
            raise InputError(f"Prior '{path}' is not one: {error}") from error


def learn_cells(
    places: Iterable[tuple[CityMap, tuple[float, float]]], strength: float = STRENGTH
) -> LearntCells:
    """Learn a prior over cells from known places.

    Parameters
    ----------
    places
        A map and a place (x, y) in metres on it, for each known target.
    strength
        How many places the Dirichlet prior counts for, > 0.

    Raises
    ------
    InputError
        When there is no place.
    OutsideMap
        When one lies outside its map.

    Examples
    --------
    >>> from sloop_ppl.maps import load_map
    >>> city = load_map("cleveland")
    >>> prior = learn_cells([(city, (22.5, -40.0)), (city, (-30.0, 12.0))])
    >>> type(prior).__name__
    'LearntCells'
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
            features[_cells_of(city, (FEATURES[index],))] = index
        return features

    return city.derived("features of cells", read)


def cell_prior(spec: Any) -> CellPrior:
    """Return the prior over cells that a name, a file or an object means.

    Parameters
    ----------
    spec
        A name in `CELL_PRIORS`; a path to a ``.nc`` file (see
        :class:`sloop_ppl.models._netcdf.FileCells`) or a ``.json`` file (see `LearntCells`); or a
        `CellPrior`, returned as it is.

    Raises
    ------
    UnknownName
        For another name; it lists those there are.
    InputError
        When a file cannot be read, or for something else.

    Examples
    --------
    >>> cell_prior("streets").share
    0.95
    """
    if isinstance(spec, str | Path):
        ending = Path(spec).suffix.lower()
        if ending == ".nc":
            from sloop_ppl.models._netcdf import FileCells

            return FileCells.load(spec)
        if ending == ".json":
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


def _cells_of(city: CityMap, kinds: tuple[str, ...]) -> NDArray[np.bool_]:
    """Return the cells that landmarks of some kinds touch, shape (H, W)."""

    def touched() -> NDArray[np.bool_]:
        cells = np.zeros(city.grid.shape, dtype=bool)
        for landmark in city.of_kind(*kinds):
            cells |= city.cells(landmark.id)
        return cells

    return city.derived(f"cells of {' '.join(kinds)}", touched)


def _by_feature(payload: Mapping[str, Any]) -> list[Any]:
    for name in payload:
        if name not in FEATURES:
            raise UnknownName("feature of cells", str(name), FEATURES)
    return [payload[feature] for feature in FEATURES]


_PATHS = tuple(sorted(PATH_KINDS))
CELL_PRIORS.add("uniform", UniformCells())
CELL_PRIORS.add("streets", CellsOfKinds(_PATHS, share=0.95))
CELL_PRIORS.add("off-streets", CellsOfKinds(_PATHS, share=0.05))
