"""The planner ``fast``: POUCT in machine code, or a search over paths, by the rollout asked for."""

from __future__ import annotations

import logging
import time
from typing import Any

import numpy as np

from sloop_ppl.search._pomdp import Agent, Planner
from sloop_ppl.search.episode import PlanInfo
from sloop_ppl.search.informed import InformedPlanner
from sloop_ppl.search.kernel import (
    Budget,
    FlatTree,
    compact,
    find_child,
    grow,
    new_scratch,
    new_tree,
)
from sloop_ppl.search.native import NativeModel
from sloop_ppl.search.native_search import NativeSearch
from sloop_ppl.search.space import SearchSpace
from sloop_ppl.search.values import SearchAction, SearchObservation

__all__ = ["FastPlanner", "NativePouct"]

_log = logging.getLogger(__name__)


class NativePouct(Planner):
    """Plan as ``pomdp_py.POUCT`` does, on any agent whose domain has a native model.

    The tree is kept between steps, below what was done and observed. One planner serves one
    agent; planning releases the interpreter's lock.

    Parameters
    ----------
    model : the domain's native model.
    sims, depth, discount, exploration : as in `SearchConfig`.
    rng : where the seed of the simulations comes from.

    Attributes
    ----------
    last_info : what is to be said about the last decision.
    """

    def __init__(
        self,
        model: NativeModel,
        *,
        sims: int = 1000,
        depth: int = 30,
        discount: float = 0.95,
        exploration: float = 1000.0,
        rng: np.random.Generator,
    ) -> None:
        self.model = model
        self.budget = Budget(sims, depth, float(discount), float(exploration))
        self._random = rng.integers(2**63, size=1, dtype=np.uint64)
        self._state = np.zeros(model.state_size, dtype=np.int64)
        self._scratch = new_scratch(depth)
        self._tree: FlatTree | None = None
        self._size = 0
        self.last_info = PlanInfo("fast")

    @property
    def updates_agent_belief(self) -> bool:
        """False: the belief is updated by whoever runs the agent."""
        return False

    def plan(self, agent: Agent) -> Any:
        """Return the action with the highest value at the root."""
        begun = time.perf_counter()
        tree = self._roomy()
        self._size = grow(
            self.model.data,
            self.model.belief(agent),
            tree,
            self._size,
            self.budget,
            self._random,
            self._state,
            self._scratch,
        )
        values, counts = tree.values[0], tree.counts[0]
        tried = [a for a in range(len(counts)) if tree.legal[0] >> a & 1]
        best = max(tried, key=lambda a: (values[a], -a))
        names = [str(a) for a in self.model.actions]
        self.last_info = PlanInfo(
            "fast",
            sims=self.budget.sims,
            seconds=time.perf_counter() - begun,
            values={names[a]: float(values[a]) for a in tried},
            visits={names[a]: int(counts[a]) for a in tried},
            notes={"nodes": self._size},
        )
        return self.model.actions[best]

    def update(self, agent: Agent, real_action: Any, real_observation: Any) -> None:
        """Keep the part of the tree below what was done and observed."""
        del agent
        if self._tree is None or self._size == 0:
            return
        action = self.model.actions.index(real_action)
        child = int(find_child(self._tree, 0, action, self.model.key(real_observation)))
        if child < 0:
            self.forget()
            return
        tree = new_tree(self._size - child + self.budget.sims, len(self.model.actions))
        self._size = compact(self._tree, self._size, child, tree)
        self._tree = tree

    def forget(self) -> None:
        """Drop the tree."""
        self._tree, self._size = None, 0

    def _roomy(self) -> FlatTree:
        """Return the tree, with room for one more node per simulation."""
        wanted = self._size + self.budget.sims
        if self._tree is None or self._size == 0:
            self._tree, self._size = new_tree(wanted, len(self.model.actions)), 0
        elif len(self._tree.visits) < wanted:
            larger = new_tree(wanted, len(self.model.actions))
            compact(self._tree, self._size, 0, larger)
            self._tree = larger
        return self._tree


class FastPlanner:
    """Plan in machine code; the planner ``fast`` of the registry.

    With rollout ``published`` or ``random`` it is `NativePouct`, the same algorithm as ``pouct``;
    with ``informed``, its own, it is `InformedPlanner`.

    Parameters
    ----------
    space : the search space.
    rng : where simulations are drawn from.
    """

    def __init__(self, space: SearchSpace, *, rng: np.random.Generator) -> None:
        config = space.config
        self._inner: InformedPlanner | NativePouct
        if config.rollout in (None, "informed"):
            self._inner = InformedPlanner(space)
        else:
            self._inner = NativePouct(
                NativeSearch(space),
                sims=config.sims,
                depth=config.depth,
                discount=config.discount,
                exploration=config.exploration,
                rng=rng,
            )

    def plan(self, agent: Agent) -> tuple[SearchAction, PlanInfo]:
        """Return the best action."""
        if isinstance(self._inner, InformedPlanner):
            return self._inner.plan(agent)
        action: SearchAction = self._inner.plan(agent)
        return action, self._inner.last_info

    def update(self, agent: Agent, action: SearchAction, observation: SearchObservation) -> None:
        """Keep what is still of use."""
        self._inner.update(agent, action, observation)

    def forget(self) -> None:
        """Plan anew."""
        self._inner.forget()
