"""The planners, by name."""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Protocol

import numpy as np

from sloop_ppl.planning._pomdp import Agent
from sloop_ppl.planning.episode import PlanInfo
from sloop_ppl.planning.greedy import GreedyPlanner
from sloop_ppl.planning.names import check_planner, list_planners
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.tree import PomcpPlanner, PouctPlanner
from sloop_ppl.planning.values import SearchAction, SearchObservation
from sloop_ppl.rng import child

__all__ = ["PLANNERS", "RandomPlanner", "SearchPlanner", "list_planners", "make_planner"]


class SearchPlanner(Protocol):
    """What the episode loop asks of a planner."""

    def plan(self, agent: Agent) -> tuple[SearchAction, PlanInfo]:
        """Return the action to take and what is to be said about it."""
        ...

    def update(self, agent: Agent, action: SearchAction, observation: SearchObservation) -> None:
        """Learn what was done and observed; the agent's history and belief tell it already."""
        ...

    def forget(self) -> None:
        """Drop what was built on the old belief: something else than the sensor changed it."""
        ...


class RandomPlanner:
    """Take any valid action, each as likely.

    Parameters
    ----------
    space : the search space.
    rng : where the choices come from.
    """

    def __init__(self, space: SearchSpace, *, rng: np.random.Generator) -> None:
        del space
        self._rng = random.Random(int(rng.integers(2**63)))

    def plan(self, agent: Agent) -> tuple[SearchAction, PlanInfo]:
        """Return any valid action."""
        begun = time.perf_counter()
        state = agent.belief.mpe()
        actions = agent.valid_actions(state=state, history=agent.history)
        action = self._rng.choice(actions)
        return action, PlanInfo("random", seconds=time.perf_counter() - begun)

    def update(self, agent: Agent, action: SearchAction, observation: SearchObservation) -> None:
        """Learn nothing."""

    def forget(self) -> None:
        """Forget nothing."""


def _fast(space: SearchSpace, *, rng: np.random.Generator) -> SearchPlanner:
    """Return the planner ``fast``; numba is imported when it is asked for."""
    from sloop_ppl.planning.fast import FastPlanner

    return FastPlanner(space, rng=rng)


PLANNERS: Mapping[str, Callable[..., SearchPlanner]] = MappingProxyType(
    {
        "pouct": PouctPlanner,
        "pomcp": PomcpPlanner,
        "fast": _fast,
        "greedy": GreedyPlanner,
        "random": RandomPlanner,
    }
)
"""Every planner by name; each is called with a `SearchSpace` and keyword `rng`."""


def make_planner(name: str, space: SearchSpace, *, rng: np.random.Generator) -> SearchPlanner:
    """Return the planner with this name.

    Parameters
    ----------
    name : one of `PLANNERS`.
    space : the search space.
    rng : the planner draws from its own child stream of this.

    Raises
    ------
    UnknownName : when there is no such planner.
    """
    check_planner(name)
    return PLANNERS[name](space, rng=child(rng, "planner", name))
