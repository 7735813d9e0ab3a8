"""The planner ``fast``: POUCT in machine code, or the path search, by the rollout asked for."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace

import numpy as np

from sloop_ppl.planning._pomdp import Agent
from sloop_ppl.planning._search_kernel import NativeSearch
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.episode import PlanInfo
from sloop_ppl.planning.native_pouct import NativePouct
from sloop_ppl.planning.path_search import PathSearch
from sloop_ppl.planning.planners import RunningPlanner, overridden
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import SearchAction

__all__ = ["Fast"]

_log = logging.getLogger(__name__)


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
            return PathSearch(space)
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
