"""Put a language belief into any OO-POMDP of pomdp-py: as a histogram, or as an observation."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pomdp_py
from numpy.typing import NDArray

from sloop_ppl._cell_axes import in_order
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference import infer_description
from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap
from sloop_ppl.models import ObservationModel
from sloop_ppl.planning._pomdp import Observation
from sloop_ppl.planning._pomdp import ObservationModel as PomdpObservationModel

if TYPE_CHECKING:
    import xarray

__all__ = ["LanguageObservationModel", "Utterance", "as_histogram"]

Table = NDArray[np.float64]
Cell = tuple[int, int]


def as_histogram(
    belief: Table | xarray.DataArray,
    make_state: Callable[[int, int], Hashable | None],
    among: Callable[[int, int], bool] | None = None,
) -> pomdp_py.Histogram:
    """Return a belief over cells as a pomdp-py histogram over states.

    Parameters
    ----------
    belief
        Weight of each cell, row 0 in the south, finite, >= 0, not all zero, shape (H, W). Of an
        xarray table the coordinates x and y tell where its cells are.
    make_state
        Row and column to a state of the domain, such as an ``ObjectState``; cells for which it
        returns None are left out, cells with equal states are added up.
    among
        Tells which cells are possible; all when None.

    Returns
    -------
    pomdp_py.Histogram
        State -> probability, summing to one.

    Raises
    ------
    InputError
        When the belief is not one, lacks rows or columns between others, or every cell of
        positive weight is left out.

    Examples
    --------
    >>> import numpy as np
    >>> hist = as_histogram(np.array([[1.0, 3.0]]), lambda row, col: ("cell", row, col))
    >>> hist["cell", 0, 1]
    0.75
    """
    table = np.asarray(in_order(belief, "The belief"), dtype=np.float64, order="C")
    if table.ndim != 2 or not np.isfinite(table).all() or (table < 0).any():
        raise InputError(
            f"The belief has shape {table.shape}; expected a table (H, W) of finite numbers >= 0"
        )
    weights: dict[Hashable, float] = {}
    for (row, col), p in np.ndenumerate(table):
        if among is not None and not among(row, col):
            continue
        state = make_state(row, col)
        if state is not None:
            weights[state] = weights.get(state, 0.0) + float(p)
    total = math.fsum(weights.values())
    if not total > 0:
        raise InputError(
            "No state of the domain has a positive probability under the belief; check which "
            "cells are left out"
        )
    return pomdp_py.Histogram({state: p / total for state, p in weights.items()})


class Utterance(Observation):
    """A description as an observation, where a domain wants a pomdp-py class.

    Parameters
    ----------
    description
        What was said; None for nothing.
    """

    def __init__(self, description: Description | None) -> None:
        self.description = description

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Utterance) and self.description == other.description

    def __hash__(self) -> int:
        return hash(self.description)

    def __repr__(self) -> str:
        return f"Utterance({self.description.text if self.description else None!r})"


class LanguageObservationModel(PomdpObservationModel):
    """The probability of a description given where one target is.

    Parameters
    ----------
    city
        The map.
    target
        Id of the target in the descriptions.
    cell_of
        State of the domain -> row and column of the target, row 0 in the south.
    model
        Name of the language model, or an ObservationModel.
    engine
        Name of the inference engine.
    utterances
        What could be said, for `sample`.
    rng
        Where `sample` and engines that draw take their numbers from.

    Notes
    -----
    ``pomdp_py.update_histogram_belief(histogram, action, description, model, transition)`` with a
    static transition is `sloop_ppl.infer` with that prior. What a description says of other
    targets is summed out, each of them anywhere on the map. `probability` is the model's
    likelihood, which for models whose phrases are normalised over the map is known up to a factor
    that is the same for every cell. `sample` draws one of `utterances` in proportion to it: p(d |
    s, one of these is said).
    """

    def __init__(
        self,
        city: CityMap,
        target: str,
        cell_of: Callable[[Any], Cell],
        model: str | ObservationModel = "bayes",
        engine: str = "exact",
        *,
        utterances: Sequence[Description] = (),
        rng: np.random.Generator | None = None,
    ) -> None:
        self._city, self._target, self._cell_of = city, target, cell_of
        self._model, self._engine, self._rng = model, engine, rng
        self._utterances = tuple(utterances)
        self._tables: dict[Description, Table] = {}

    def likelihood(self, description: Description | Utterance) -> Table:
        """Return p(description | cell), shape (H, W).

        Raises
        ------
        UnknownName
            When the description has no such target.
        InputError
            When the model is told the truth and so hears nothing.
        """
        parsed = description.description if isinstance(description, Utterance) else description
        if parsed is None:
            return np.ones(self._city.grid.shape)
        if parsed not in self._tables:
            known = [target.id for target in parsed.targets]
            if self._target not in known:
                raise UnknownName("target", self._target, known)
            posterior, _ = infer_description(
                parsed, self._city, self._model, self._engine, rng=self._rng
            )
            # p(d | cell) = p(cell | d) p(d) / p(cell), with a uniform p(cell) = 1 / (H W).
            scale = math.exp(posterior.log_evidence) * self._city.grid.size
            self._tables[parsed] = posterior.belief(self._target) * scale
        return self._tables[parsed]

    def probability(
        self,
        observation: Description | Utterance,
        next_state: Any,
        action: Any,  # noqa: ARG002
        **_: Any,
    ) -> float:
        """Return p(observation | next_state); the action is of no account."""
        return float(self.likelihood(observation)[self._cell_of(next_state)])

    def sample(self, next_state: Any, action: Any, **_: Any) -> Description:  # noqa: ARG002
        """Return one of the utterances, drawn in proportion to its probability.

        Raises
        ------
        InputError
            When there is none to draw from, no `rng`, or none of them can be said.
        """
        if not self._utterances or self._rng is None:
            raise InputError(
                "Nothing can be drawn: give the model the utterances that could be said "
                "(utterances=) and where to draw from (rng=)"
            )
        cell = self._cell_of(next_state)
        weights = np.array([self.likelihood(d)[cell] for d in self._utterances])
        if not weights.sum() > 0:
            raise InputError(f"None of the utterances can be said of a target in cell {cell}")
        return self._utterances[int(self._rng.choice(len(weights), p=weights / weights.sum()))]

    def argmax(self, next_state: Any, action: Any, **_: Any) -> Description:  # noqa: ARG002
        """Return the most probable utterance."""
        cell = self._cell_of(next_state)
        return max(self._utterances, key=lambda d: float(self.likelihood(d)[cell]))

    def get_distribution(self, next_state: Any, action: Any, **_: Any) -> Mapping[Any, float]:  # noqa: ARG002
        """Return utterance -> probability, summing to one."""
        cell = self._cell_of(next_state)
        weights = {d: float(self.likelihood(d)[cell]) for d in self._utterances}
        total = math.fsum(weights.values())
        return {d: p / total for d, p in weights.items()}
