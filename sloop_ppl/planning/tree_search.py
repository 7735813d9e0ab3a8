"""pomdp-py's own tree searches: POUCT on the table, POMCP on particles drawn from it."""

from __future__ import annotations

import logging
import random
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.planning._pomdp import (
    POMCP,
    POUCT,
    Agent,
    Particles,
    RolloutPolicy,
    RootVNodeParticles,
)
from sloop_ppl.planning.belief import GridBelief
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.episode import PlanInfo
from sloop_ppl.planning.explain import tree_to_json
from sloop_ppl.planning.models import PublishedRollout, RandomRollout
from sloop_ppl.planning.planners import RunningPlanner, overridden
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import SearchAction, SearchObservation, SearchState
from sloop_ppl.rng import scalar_rng

__all__ = ["GridParticles", "Pomcp", "Pouct", "PouctFallback"]

_log = logging.getLogger(__name__)


def _settings(space: SearchSpace, rng: random.Random) -> dict[str, Any]:
    config = space.config
    if config.rollout == "informed":
        raise InputError(
            "rollout is 'informed', which only the planner 'fast' knows; expected published or "
            "random, or the planner 'fast'"
        )
    rollout: RolloutPolicy = (
        RandomRollout(space, rng) if config.rollout == "random" else PublishedRollout(space, rng)
    )
    return {
        "max_depth": config.horizon,
        "num_sims": config.sims,
        "discount_factor": config.discount,
        "exploration_const": config.exploration,
        "rollout_policy": rollout,
    }


def _info(name: str, space: SearchSpace, agent: Agent, planner: POUCT, **notes: Any) -> PlanInfo:
    children = agent.tree.children
    depth = space.config.tree_depth
    return PlanInfo(
        name,
        sims=planner.last_num_sims,
        seconds=planner.last_planning_time,
        values={action.name: float(node.value) for action, node in children.items()},
        visits={action.name: int(node.num_visits) for action, node in children.items()},
        tree=tree_to_json(agent.tree, depth, space.n_cols if space.sees_mask else None)
        if depth
        else None,
        root=agent.tree if depth else None,
        notes=notes,
    )


@dataclass(frozen=True)
class _TreeSearch:
    """Settings of a tree search; one that is None is the search's own."""

    sims: int | None = None
    depth: int | None = None
    exploration: float | None = None
    discount: float | None = None
    rollout: str | None = None
    tree_depth: int | None = None

    asks = True
    """Questions are actions of the tree; `run_search` asks for this."""

    def settings(self, config: SearchConfig) -> SearchConfig:
        """Return the settings of the search with the planner's own in their places."""
        return overridden(config, self)


@dataclass(frozen=True)
class Pouct(_TreeSearch):
    """Plan with ``pomdp_py.POUCT`` on the agent's table; the paper's planner.

    Parameters
    ----------
    sims, depth, exploration, discount, rollout, tree_depth
        As in `SearchConfig`, whose values count where None is given.

    Notes
    -----
    Source: SLOOP sec. VI. The paper says POMCP, and plans on a histogram, which is POUCT.
    """

    name = "pouct"

    def begin(self, space: SearchSpace, *, rng: np.random.Generator) -> RunningPlanner:
        """Return a planner for one search; rollouts draw from `rng`."""
        return _PouctRun(space, rng)


class _PouctRun:
    """POUCT in the course of one search."""

    def __init__(self, space: SearchSpace, rng: np.random.Generator) -> None:
        self._space = space
        self.planner = POUCT(**_settings(space, scalar_rng(rng)))
        self._stale = False

    def plan(self, agent: Agent) -> tuple[SearchAction, PlanInfo]:
        """Return the action with the highest value at the root."""
        if self._stale:
            agent.tree, self._stale = None, False
        action: SearchAction = self.planner.plan(agent)
        return action, _info("pouct", self._space, agent, self.planner)

    def update(self, agent: Agent, action: SearchAction, observation: SearchObservation) -> None:
        """Keep the part of the tree below what was done and observed."""
        if getattr(agent, "tree", None) is not None:
            self.planner.update(agent, action, observation)

    def forget(self) -> None:
        """Plan anew, without the old tree."""
        self._stale = True


class GridParticles(Particles):
    """Particles that draw from their own generator instead of Python's global one."""

    def __init__(self, particles: list[SearchState], rng: random.Random) -> None:
        super().__init__(particles)
        self._choice = rng.choice

    def random(self) -> SearchState:
        """Return any particle."""
        state: SearchState = self._choice(self.particles)
        return state

    def __deepcopy__(self, _memo: object) -> GridParticles:
        return GridParticles(list(self.particles), self._choice.__self__)  # type: ignore[attr-defined]


@dataclass(frozen=True)
class Pomcp(_TreeSearch):
    """Plan with ``pomdp_py.POMCP`` on particles drawn from the agent's table.

    As many particles as simulations are kept; those that POMCP is short of after a step are
    drawn from the exact table, so that depletion never ends a search. How many were drawn anew
    is in the notes of `PlanInfo`.

    Parameters
    ----------
    sims, depth, exploration, discount, rollout, tree_depth
        As in `SearchConfig`, whose values count where None is given.
    """

    name = "pomcp"

    def begin(self, space: SearchSpace, *, rng: np.random.Generator) -> RunningPlanner:
        """Return a planner for one search; particles and rollouts draw from `rng`."""
        return _PomcpRun(space, rng)


class _PomcpRun:
    """POMCP in the course of one search."""

    def __init__(self, space: SearchSpace, rng: np.random.Generator) -> None:
        self._rng = scalar_rng(rng)
        self._space = space
        self._wanted = space.config.sims
        self.planner = POMCP(**_settings(space, self._rng))
        self._agent: Agent | None = None

    def plan(self, agent: Agent) -> tuple[SearchAction, PlanInfo]:
        """Return the action with the highest value at the root."""
        table: GridBelief = agent.belief
        own = self._agent
        if own is None:
            own = self._agent = Agent(
                GridParticles([], self._rng),
                agent.policy_model,
                agent.transition_model,
                agent.observation_model,
                agent.reward_model,
            )
            own.tree = None
        # Particles that the exact table holds impossible are dropped.
        kept = [p for p in own.belief.particles if table[p] > 0]
        missing = max(self._wanted - len(kept), 0)
        particles = GridParticles(kept + [table.random() for _ in range(missing)], self._rng)
        own.set_belief(particles)
        if own.tree is not None:
            # POMCP draws from the belief of the root.
            own.tree.belief = particles
        action: SearchAction = self.planner.plan(own)
        info = _info(
            "pomcp",
            self._space,
            own,
            self.planner,
            particles_kept=len(kept),
            particles_drawn=missing,
        )
        return action, info

    def update(self, agent: Agent, action: SearchAction, observation: SearchObservation) -> None:
        """Keep the part of the tree, and its particles, below what was done and observed."""
        del agent  # its history and table belong to the loop; POMCP has its own
        own = self._agent
        if own is None:
            return
        own.update_history(action, observation)
        branch = own.tree.children.get(action)
        node = branch.children.get(observation) if branch is not None else None
        if node is None:
            own.tree = None
            own.set_belief(GridParticles([], self._rng))
        else:
            own.tree = RootVNodeParticles.from_vnode(node, own.history)
            own.set_belief(GridParticles(list(node.belief.particles), self._rng))

    def forget(self) -> None:
        """Plan anew, without the old tree and particles."""
        if self._agent is not None:
            self._agent.tree = None
            self._agent.set_belief(GridParticles([], self._rng))


class PouctFallback:
    """POUCT in the place of ``fast``, for a sensor whose reports no kernel knows."""

    def __init__(self, space: SearchSpace, rng: np.random.Generator) -> None:
        kind = type(space.sensor).__name__
        self._note = f"sensor {kind} sees no mask; planned by pomdp_py.POUCT"
        _log.warning(self._note)
        self._inner = Pouct().begin(space, rng=rng)
        self.update, self.forget = self._inner.update, self._inner.forget

    def plan(self, agent: Agent) -> tuple[SearchAction, PlanInfo]:
        """Return the action that POUCT chooses, with a note."""
        action, info = self._inner.plan(agent)
        return action, replace(info, notes={**info.notes, "fallback": self._note})
