"""The planner ``fast``: POUCT in machine code, or the path search, by the rollout asked for."""

from __future__ import annotations

import numpy as np

from sloop_ppl.planning._pomdp import Agent
from sloop_ppl.planning._search_kernel import NativeSearch
from sloop_ppl.planning.episode import PlanInfo
from sloop_ppl.planning.native_pouct import NativePouct
from sloop_ppl.planning.path_search import PathSearch
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import SearchAction, SearchObservation

__all__ = ["FastPlanner"]


class FastPlanner:
    """Plan in machine code; the planner ``fast`` of the registry.

    With rollout ``published`` or ``random`` it is `NativePouct`, the same algorithm as ``pouct``;
    with ``informed``, its own, it is `PathSearch`.

    Parameters
    ----------
    space : the search space.
    rng : where simulations are drawn from.
    """

    def __init__(self, space: SearchSpace, *, rng: np.random.Generator) -> None:
        config = space.config
        self._inner: PathSearch | NativePouct
        if config.rollout in (None, "informed"):
            self._inner = PathSearch(space)
        else:
            self._inner = NativePouct(
                NativeSearch(space),
                sims=config.sims,
                depth=config.depth,
                discount=config.discount,
                exploration=config.exploration,
                rng=rng,
                tree_depth=config.tree_depth,
            )

    def plan(self, agent: Agent) -> tuple[SearchAction, PlanInfo]:
        """Return the best action."""
        if isinstance(self._inner, PathSearch):
            return self._inner.plan(agent)
        action: SearchAction = self._inner.plan(agent)
        return action, self._inner.last_info

    def update(self, agent: Agent, action: SearchAction, observation: SearchObservation) -> None:
        """Keep what is still of use."""
        self._inner.update(agent, action, observation)

    def forget(self) -> None:
        """Plan anew."""
        self._inner.forget()
