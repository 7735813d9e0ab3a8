"""Take any action: the planner that knows nothing."""

from __future__ import annotations

import random
import time
from dataclasses import dataclass

import numpy as np

from sloop_ppl.planning._pomdp import Agent
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.episode import PlanInfo
from sloop_ppl.planning.planners import RunningPlanner
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import SearchAction, SearchObservation
from sloop_ppl.rng import scalar_rng

__all__ = ["Random"]


@dataclass(frozen=True)
class Random:
    """Take any valid action, each as likely."""

    name = "random"

    def settings(self, config: SearchConfig) -> SearchConfig:
        """Return the settings as they are."""
        return config

    def begin(self, space: SearchSpace, *, rng: np.random.Generator) -> RunningPlanner:
        """Return a planner for one search; its choices are drawn from `rng`."""
        del space
        return _RandomRun(scalar_rng(rng))


class _RandomRun:
    """Random choices in the course of one search."""

    def __init__(self, rng: random.Random) -> None:
        self._rng = rng

    def plan(self, agent: Agent) -> tuple[SearchAction, PlanInfo]:
        """Return any valid action."""
        begun = time.perf_counter()
        state = agent.belief.mpe()
        actions = agent.valid_actions(state=state, history=agent.history)
        action: SearchAction = self._rng.choice(actions)
        return action, PlanInfo("random", seconds=time.perf_counter() - begun)

    def update(self, agent: Agent, action: SearchAction, observation: SearchObservation) -> None:
        """Learn nothing."""

    def forget(self) -> None:
        """Forget nothing."""
