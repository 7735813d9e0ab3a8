"""Plan as ``pomdp_py.POUCT`` does, in machine code, for any domain that has a native model."""

from __future__ import annotations

import copy
import logging
import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.planning._native import NativeFunctions, NativeModel, register_native, uniform
from sloop_ppl.planning._pomdp import POUCT, Agent, Planner
from sloop_ppl.planning._search_kernel import NativeSearch, SearchBelief
from sloop_ppl.planning._search_tables import SearchData
from sloop_ppl.planning._tree_kernel import (
    Budget,
    FlatTree,
    compact,
    find_child,
    grow,
    grow_uncached,
    new_scratch,
    new_tree,
)
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.episode import PlanInfo
from sloop_ppl.planning.explain import flat_tree_to_json
from sloop_ppl.planning.planners import RunningPlanner
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.tree_search import PouctFallback
from sloop_ppl.planning.values import SearchAction

__all__ = ["NativeFunctions", "NativeModel", "NativePouct", "register_native", "uniform"]

NO_MODEL = "the domain has no native model; planned by pomdp_py.POUCT"

_log = logging.getLogger(__name__)


class NativePouct(Planner):
    """Plan as ``pomdp_py.POUCT`` does, on any agent whose domain has a native model.

    The tree is kept between steps, below what was done and observed. One planner serves one
    agent; planning releases the interpreter's lock.

    Parameters
    ----------
    model
        The domain's native model; when None it is the attribute ``native`` of the agent's
        transition model. An agent without one is planned for by ``pomdp_py.POUCT``, with a
        warning in the log and a note in `last_info`.
    sims, depth, discount, exploration
        As in `SearchConfig`. Where None is given, a search's own count; for a domain of one's own
        they are 1000, 30, 0.95 and 1000.
    rng
        Where the seed of the simulations comes from; a search has its own.
    rollout_policy
        Rollout policy of the fallback; the agent's policy model when None.
    tree_depth
        Levels of the tree that `last_info` keeps.

    Attributes
    ----------
    last_info
        The `PlanInfo` of the last decision.

    Notes
    -----
    The machine code for the search of this package is kept on disk. That for another domain is
    made anew in every process, in about a second.
    """

    def __init__(
        self,
        model: NativeModel | None = None,
        *,
        sims: int | None = None,
        depth: int | None = None,
        discount: float | None = None,
        exploration: float | None = None,
        rng: np.random.Generator | None = None,
        rollout_policy: Any = None,
        tree_depth: int | None = None,
    ) -> None:
        own = {
            "sims": sims,
            "depth": depth,
            "discount": discount,
            "exploration": exploration,
            "tree_depth": tree_depth,
        }
        self._own = {name: value for name, value in own.items() if value is not None}
        used = SearchConfig(**self._own)  # type: ignore[arg-type]
        self.tree_depth = used.tree_depth
        self.model = model
        self._rollout_policy = rollout_policy
        self._fallback: POUCT | None = None
        self.budget = Budget(used.sims, used.horizon, float(used.discount), float(used.exploration))
        self._random: NDArray[np.uint64] | None = None
        if rng is not None:
            # One uint64 is the whole state of the stream, see `uniform`.
            self._random = rng.integers(2**63, size=1, dtype=np.uint64)
        self._scratch = new_scratch(used.horizon)
        self._tree: FlatTree | None = None
        self._size = 0
        self.last_info = PlanInfo("fast")

    def __repr__(self) -> str:
        return f"NativePouct({', '.join(f'{name}={value}' for name, value in self._own.items())})"

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and pickle by value; of the base, made in C, nothing needs to go along."""
        # The fallback's tree is the agent's, and the scratch is filled anew by each decision.
        return _restored, ({**self.__dict__, "_fallback": None, "_scratch": None},)

    def __copy__(self) -> NativePouct:
        """Return a planner with a tree and a stream of its own: both are changed in place."""
        own = {name: copy.deepcopy(getattr(self, name)) for name in ("_random", "_tree")}
        return _restored({**self.__dict__, "_fallback": None, **own})

    @property
    def name(self) -> str:
        """What the planner is called in episodes: ``fast``, of which it is one half."""
        return "fast"

    def settings(self, config: SearchConfig) -> SearchConfig:
        """Return the settings of a search with the planner's own in their places."""
        rollout = "random" if config.rollout == "random" else "published"
        return replace(config, rollout=rollout, **self._own)  # type: ignore[arg-type]

    def begin(self, space: SearchSpace, *, rng: np.random.Generator) -> RunningPlanner:
        """Return a planner for one search; simulations draw from `rng`."""
        return _NativeRun(space, rng) if space.sees_mask else PouctFallback(space, rng)

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
        if self._random is None:
            raise InputError(
                "NativePouct has nothing to draw its simulations from; give it rng=, a generator "
                "of numpy"
            )
        self.model = model
        tree = self._roomy(len(model.actions))
        belief = model.belief(agent)
        # Types of a user must not get into the cache on disk; see `jit`.
        ours = type(model.data) is SearchData and type(belief) is SearchBelief
        self._size = (grow if ours else grow_uncached)(
            model.data,
            belief,
            tree,
            self._size,
            self.budget,
            self._random,
            np.zeros(model.state_size, dtype=np.int64),
            self._scratch,
        )
        values, counts = tree.values[0], tree.counts[0]
        tried = [a for a in range(len(counts)) if tree.legal[0] >> a & 1]
        # Of equal values the action that is declared first.
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
        # Parents come before their children: the subtree has at most size - child nodes.
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


def _restored(state: Mapping[str, Any]) -> NativePouct:
    """Return a planner in the state that one was in."""
    made = NativePouct()
    made.__dict__.update(state)
    made._scratch = new_scratch(made.budget.depth)
    return made


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
