"""The planner ``fast``: POUCT in machine code, or a search over paths, by the rollout asked for."""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sloop_ppl.planning._pomdp import POUCT, Agent, Planner
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.episode import PlanInfo
from sloop_ppl.planning.explain import flat_tree_to_json
from sloop_ppl.planning.informed import InformedPlanner
from sloop_ppl.planning.kernel import (
    Budget,
    FlatTree,
    compact,
    find_child,
    grow,
    new_scratch,
    new_tree,
)
from sloop_ppl.planning.native import NativeModel
from sloop_ppl.planning.native_search import NativeSearch
from sloop_ppl.planning.planners import RunningPlanner, overridden
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import SearchAction

__all__ = ["Fast", "NativePouct"]

NO_MODEL = "the domain has no native model; planned by pomdp_py.POUCT"

_log = logging.getLogger(__name__)


class NativePouct(Planner):
    """Plan as ``pomdp_py.POUCT`` does, on any agent whose domain has a native model.

    The tree is kept between steps, below what was done and observed. One planner serves one
    agent; planning releases the interpreter's lock.

    Parameters
    ----------
    model : the domain's native model; when None it is the attribute ``native`` of the agent's
        transition model. An agent without one is planned for by ``pomdp_py.POUCT``, with a
        warning in the log and a note in `last_info`.
    sims, depth, discount, exploration : as in `SearchConfig`.
    rng : where the seed of the simulations comes from.
    rollout_policy : rollout policy of the fallback; the agent's policy model when None.
    tree_depth : levels of the tree that `last_info` keeps.

    Attributes
    ----------
    last_info : what is to be said about the last decision.
    """

    def __init__(
        self,
        model: NativeModel | None = None,
        *,
        sims: int = 1000,
        depth: int = 30,
        discount: float = 0.95,
        exploration: float = 1000.0,
        rng: np.random.Generator,
        rollout_policy: Any = None,
        tree_depth: int = 0,
    ) -> None:
        self.tree_depth = tree_depth
        self.model = model
        self._rollout_policy = rollout_policy
        self._fallback: POUCT | None = None
        self.budget = Budget(sims, depth, float(discount), float(exploration))
        self._random = rng.integers(2**63, size=1, dtype=np.uint64)
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
        model = self.model or getattr(agent.transition_model, "native", None)
        if model is None:
            return self._fall_back(agent)
        self.model = model
        tree = self._roomy(len(model.actions))
        self._size = grow(
            model.data,
            model.belief(agent),
            tree,
            self._size,
            self.budget,
            self._random,
            np.zeros(model.state_size, dtype=np.int64),
            self._scratch,
        )
        values, counts = tree.values[0], tree.counts[0]
        tried = [a for a in range(len(counts)) if tree.legal[0] >> a & 1]
        best = max(tried, key=lambda a: (values[a], -a))
        names = [str(a) for a in model.actions]
        self.last_info = PlanInfo(
            "fast",
            sims=self.budget.sims,
            seconds=time.perf_counter() - begun,
            values={names[a]: float(values[a]) for a in tried},
            visits={names[a]: int(counts[a]) for a in tried},
            tree=flat_tree_to_json(tree, self._size, model.actions, self.tree_depth)
            if self.tree_depth
            else None,
            notes={"nodes": self._size},
        )
        return model.actions[best]

    def update(self, agent: Agent, real_action: Any, real_observation: Any) -> None:
        """Keep the part of the tree below what was done and observed."""
        if self._fallback is not None:
            self._fallback.update(agent, real_action, real_observation)
        if self.model is None or self._tree is None or self._size == 0:
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

    def _fall_back(self, agent: Agent) -> Any:
        """Return the action that ``pomdp_py.POUCT`` chooses."""
        if self._fallback is None:
            _log.warning(NO_MODEL)
            self._fallback = POUCT(
                max_depth=self.budget.depth,
                num_sims=self.budget.sims,
                discount_factor=self.budget.discount,
                exploration_const=self.budget.exploration,
                rollout_policy=self._rollout_policy or agent.policy_model,
            )
        action = self._fallback.plan(agent)
        children = agent.tree.children
        self.last_info = PlanInfo(
            "pouct",
            sims=self._fallback.last_num_sims,
            seconds=self._fallback.last_planning_time,
            values={str(a): float(node.value) for a, node in children.items()},
            visits={str(a): int(node.num_visits) for a, node in children.items()},
            notes={"fallback": NO_MODEL},
        )
        return action

    def _roomy(self, n_actions: int) -> FlatTree:
        """Return the tree, with room for one more node per simulation."""
        wanted = self._size + self.budget.sims
        if self._tree is None or self._size == 0:
            self._tree, self._size = new_tree(wanted, n_actions), 0
        elif len(self._tree.visits) < wanted:
            larger = new_tree(wanted, n_actions)
            compact(self._tree, self._size, 0, larger)
            self._tree = larger
        return self._tree


@dataclass(frozen=True)
class Fast:
    """Plan in machine code: `PathSearch`, or `NativePouct` where a rollout is asked for.

    A sensor that sees no mask is neither's: then ``pomdp_py.POUCT`` plans, and the notes of
    `PlanInfo` say so.

    Parameters
    ----------
    sims, depth, exploration, discount, rollout, hedge, tree_depth
        As in `SearchConfig`, whose values count where None is given.
    """

    sims: int | None = None
    depth: int | None = None
    exploration: float | None = None
    discount: float | None = None
    rollout: str | None = None
    hedge: float | None = None
    tree_depth: int | None = None

    name = "fast"

    def settings(self, config: SearchConfig) -> SearchConfig:
        """Return the settings of the search with the planner's own in their places."""
        return overridden(config, self)

    def begin(self, space: SearchSpace, *, rng: np.random.Generator) -> RunningPlanner:
        """Return a planner for one search; simulations draw from `rng`."""
        if not space.sees_mask:
            return _Fallback(space, rng)
        if space.config.rollout in (None, "informed"):
            return InformedPlanner(space)
        return _NativeRun(space, rng)


class _NativeRun:
    """`NativePouct` in the course of one search."""

    def __init__(self, space: SearchSpace, rng: np.random.Generator) -> None:
        config = space.config
        self._inner = NativePouct(
            NativeSearch(space),
            sims=config.sims,
            depth=config.horizon,
            discount=config.discount,
            exploration=config.exploration,
            rng=rng,
            tree_depth=config.tree_depth,
        )
        self.update, self.forget = self._inner.update, self._inner.forget

    def plan(self, agent: Agent) -> tuple[SearchAction, PlanInfo]:
        """Return the best action."""
        action: SearchAction = self._inner.plan(agent)
        return action, self._inner.last_info


class _Fallback:
    """POUCT in the place of ``fast``, for a sensor whose reports no kernel knows."""

    def __init__(self, space: SearchSpace, rng: np.random.Generator) -> None:
        from sloop_ppl.planning.tree_search import Pouct

        kind = type(space.sensor).__name__
        self._note = f"sensor {kind} sees no mask; planned by pomdp_py.POUCT"
        _log.warning(self._note)
        self._inner = Pouct().begin(space, rng=rng)
        self.update, self.forget = self._inner.update, self._inner.forget

    def plan(self, agent: Agent) -> tuple[SearchAction, PlanInfo]:
        """Return the action that POUCT chooses, with a note."""
        action, info = self._inner.plan(agent)
        return action, replace(info, notes={**info.notes, "fallback": self._note})
