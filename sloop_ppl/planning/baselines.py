"""The planners that look no further: greed, which others are compared with, and chance."""

from __future__ import annotations

import random
import time
from dataclasses import dataclass

import numpy as np

from sloop_ppl.planning._pomdp import Agent
from sloop_ppl.planning._search_tables import likeliest_poses, reach_from, visible_mass
from sloop_ppl.planning.belief import GridBelief
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.episode import PlanInfo
from sloop_ppl.planning.planners import RunningPlanner
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import SearchAction, SearchObservation
from sloop_ppl.rng import scalar_rng

__all__ = ["Greedy", "Random", "find_value"]


@dataclass(frozen=True)
class _NoSettings:
    """A planner without settings of its own."""

    def settings(self, config: SearchConfig) -> SearchConfig:
        """Return the settings as they are."""
        return config


class _NothingKept:
    """A running planner that decides each step anew; the belief tells it all."""

    def update(self, agent: Agent, action: SearchAction, observation: SearchObservation) -> None:
        """Learn nothing."""

    def forget(self) -> None:
        """Forget nothing."""


@dataclass(frozen=True)
class Greedy(_NoSettings):
    """Take the first move towards the pose that maximises ``discount ** steps * visible belief``.

    Every reachable pose counts, at its fewest steps, each move taken at its most probable outcome.
    What is seen is found at once when the expected reward of that find is positive; a sensor that
    sees no mask may make a find pay at any time. Nothing is drawn.
    """

    name = "greedy"

    def begin(self, space: SearchSpace, *, rng: np.random.Generator) -> RunningPlanner:
        """Return a planner for one search."""
        del rng
        return _GreedyRun(space)


class _GreedyRun(_NothingKept):
    """Greed in the course of one search."""

    def __init__(self, space: SearchSpace) -> None:
        self._space = space
        self._nexts = likeliest_poses(space)
        self._unseen: dict[int, list[int]] = {}

    def plan(self, agent: Agent) -> tuple[SearchAction, PlanInfo]:
        """Return the first move towards the best pose, or a find."""
        begun = time.perf_counter()
        belief: GridBelief = agent.belief
        space, robot = self._space, belief.robot
        if agent.history and agent.history[-1][1].any:
            value = [find_value(belief, find) for find in space.finds]
            best = int(np.argmax(value))
            if value[best] > 0:
                values = {f.name: w for f, w in zip(space.finds, value, strict=True)}
                seconds = time.perf_counter() - begun
                return space.finds[best], PlanInfo("greedy", seconds=seconds, values=values)
        wanted = [t for i, t in enumerate(belief.flat) if not robot.found >> i & 1]
        reach = reach_from(robot.pose, self._nexts)
        mass = visible_mass(space, wanted)
        if robot.pose in self._unseen or belief.unseen:  # between cells, it shows something else
            self._unseen[robot.pose] = list(belief.unseen)
        for pose, cells in self._unseen.items():
            mass[pose] -= sum(float(table[cells].sum()) for table in wanted)
        promise = mass * space.config.discount**reach.steps
        # Out of reach: below every promise, which are >= 0.
        promise[reach.steps < 0] = -1.0
        values = {
            move.name: float(promise[reach.first == move.index].max(initial=0.0))
            for move in space.moves
        }
        best = int(reach.first[np.argmax(promise)])
        seconds = time.perf_counter() - begun
        return space.moves[best], PlanInfo("greedy", seconds=seconds, values=values)


@dataclass(frozen=True)
class Random(_NoSettings):
    """Take any valid action, each as likely."""

    name = "random"

    def begin(self, space: SearchSpace, *, rng: np.random.Generator) -> RunningPlanner:
        """Return a planner for one search; its choices are drawn from `rng`."""
        del space
        return _RandomRun(scalar_rng(rng))


class _RandomRun(_NothingKept):
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


def find_value(belief: GridBelief, find: SearchAction) -> float:
    """Return the expected reward of a find from where the robot is."""
    view = list(belief.in_view)
    missed = 1.0
    for i, table in enumerate(belief.flat):
        if find.marks >> i & 1 and not belief.robot.found >> i & 1:
            # P(no target of the find is in view), targets independent.
            missed *= 1.0 - float(table[view].sum())
    config = belief.space.config
    return (1.0 - missed) * config.right_find_reward + missed * config.wrong_find_reward
