"""From the state of a page to the posterior it stands for, what was found kept for a while."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray
from shapely.geometry import Polygon

from sloop_ppl import bridge
from sloop_ppl.errors import InputError
from sloop_ppl.inference import Posterior
from sloop_ppl.inference.influence import without_relation
from sloop_ppl.language import Description, check_viewpoint, no_relation_found
from sloop_ppl.maps import CityMap
from sloop_ppl.models import cell_prior
from sloop_ppl.web._model_parameters import listed_model, listed_name, with_bounded_parameters
from sloop_ppl.web._state import Evidence, State

__all__ = ["Believed", "Posteriors", "questions_payload", "replace_state"]

_MISS, _FALSE_ALARM = 0.05, 0.02
"""How often someone who looks at a place overlooks the target there, or takes another for it."""

_KEPT_CELLS = 4_000_000


@dataclass(frozen=True)
class Believed:
    """What follows from a state.

    Parameters
    ----------
    read
        The description with all that was read, whether it is left out or not.
    posterior
        The posterior; None when nothing can be inferred.
    problem
        Why not, in one line.
    """

    read: Description
    posterior: Posterior | None
    problem: str = ""


class Posteriors:
    """Finds posteriors for states; those asked for last are kept, with those on the way to them.

    Parameters
    ----------
    find_map
        Gives a map by its key.
    """

    def __init__(self, find_map: Callable[[str], CityMap]) -> None:
        self._find_map = find_map
        self._kept: OrderedDict[bytes, tuple[int, Believed]] = OrderedDict()
        self._lock = threading.Lock()

    def of(self, state: State) -> Believed:
        """Return what follows from a state.

        Raises
        ------
        SloopError
            For names that are none, places off the map, or evidence that leaves nothing.
        """
        key = msgspec.json.encode(state)
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key][1]
        found = self._find(state)
        with self._lock:
            self._kept[key] = (self._find_map(state.map).grid.size, found)
            while sum(size for size, _ in self._kept.values()) > _KEPT_CELLS:
                self._kept.popitem(last=False)
        return found

    def _find(self, state: State) -> Believed:
        # The last answer, else the last evidence, is added to what follows without it.
        if state.answers:
            before = self.of(replace_state(state, answers=state.answers[:-1]))
            if before.posterior is None:
                return before
            return replace(before, posterior=_answered(before.posterior, *state.answers[-1]))
        if state.evidence:
            before = self.of(replace_state(state, evidence=state.evidence[:-1]))
            last = state.evidence[-1]
            if before.posterior is None or last.target not in before.posterior.targets:
                return before
            return replace(before, posterior=_seen(before.posterior, last))
        return _inferred(state, self._find_map(state.map))


def questions_payload(posterior: Posterior) -> list[dict[str, Any]]:
    """Return the questions worth asking, with their answers."""
    return [
        {
            "text": question.text,
            "bits": question.bits,
            "answers": [{"text": text, "p": p} for text, p in question.answers],
        }
        for question in bridge.ask(posterior, posterior.city, n=3)
    ]


def replace_state(state: State, **changes: Any) -> State:
    """Return a state with some fields changed."""
    return msgspec.structs.replace(state, **changes)


def _answered(posterior: Posterior, question: str, answer: str) -> Posterior:
    for one in bridge.ask(posterior, posterior.city, n=10):
        if one.text == question:
            return posterior.update(one.answer(answer))
    raise InputError(f"The question '{question}' is not one that is asked here; undo its answer")


def _inferred(state: State, city: CityMap) -> Believed:
    frames = listed_name("frames", "frame predictor", state.frames)
    prior = listed_name("priors", "prior", state.prior)
    model = listed_model(state.model, state.variant, frames)
    read = bridge.parse(state.text, city, viewpoint=check_viewpoint(state.viewpoint))
    kept = read
    for index in sorted(set(state.off), reverse=True):
        if 0 <= index < len(read.relations):
            figure = read.relations[index].figure
            position = sum(r.figure == figure for r in read.relations[:index])
            (kept,) = without_relation((kept,), figure, position)
    if not kept.relations:
        problem = "" if read.relations else str(no_relation_found(read, city))
        return Believed(read, None, problem or "Every phrase is switched off; switch one on")
    posterior = bridge.infer(
        kept,
        city,
        model=with_bounded_parameters(model, state.parameters),
        prior=None if prior is None else cell_prior(prior),
        area=state.area if state.polygon is None else Polygon(state.polygon),
    )
    return Believed(read, posterior)


def _seen(posterior: Posterior, evidence: Evidence) -> Posterior:
    grid = posterior.city.grid
    x, y = evidence.at
    grid.cell_at(x, y)  # refuses a place off the map
    distance = np.hypot(grid.x_m[None, :] - x, grid.y_m[:, None] - y)
    inside = distance <= max(evidence.radius_m, grid.cell_m / 2**0.5)
    p: NDArray[np.float64] = np.where(inside, 1 - _MISS, _FALSE_ALARM)
    return posterior.condition({evidence.target: np.log(p if evidence.is_there else 1 - p)})
