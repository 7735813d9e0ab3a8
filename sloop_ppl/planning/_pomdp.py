"""Import pomdp-py with types: the only module that touches it, because it ships no stubs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__all__ = [
    "POMCP",
    "POUCT",
    "Action",
    "Agent",
    "GenerativeDistribution",
    "OOState",
    "ObjectState",
    "Observation",
    "ObservationModel",
    "Particles",
    "Planner",
    "PolicyModel",
    "RewardModel",
    "RolloutPolicy",
    "RootVNodeParticles",
    "TransitionModel",
]

if TYPE_CHECKING:

    class Action:
        """What an agent can do."""

    class Observation:
        """What an agent can perceive."""

    class ObjectState:
        """The state of one object: a class name and attributes."""

        objclass: Any
        attributes: Any

        def __init__(self, objclass: str, attributes: dict[str, Any]) -> None: ...

    class OOState:
        """The state of several objects."""

        object_states: Any

    class GenerativeDistribution:
        """A distribution that can be sampled."""

    class TransitionModel:
        """How states follow on states."""

    class ObservationModel:
        """How observations follow on states."""

    class RewardModel:
        """How rewards follow on transitions."""

    class PolicyModel:
        """Which actions there are, and how they are chosen."""

    class RolloutPolicy(PolicyModel):
        """How actions are chosen below the leaves of a search tree."""

    class Particles(GenerativeDistribution):
        """A distribution made of equally weighted samples."""

        particles: list[Any]

        def __init__(self, particles: list[Any]) -> None: ...

        def add(self, particle: Any) -> None:
            """Add one sample."""

    class Agent:
        """A belief, a history and the models to plan with."""

        history: tuple[tuple[Any, Any], ...]
        belief: Any
        init_belief: Any
        transition_model: Any
        observation_model: Any
        reward_model: Any
        policy_model: Any
        tree: Any

        def __init__(
            self,
            init_belief: Any,
            policy_model: Any = None,
            transition_model: Any = None,
            observation_model: Any = None,
            reward_model: Any = None,
        ) -> None: ...

        def set_belief(self, belief: Any, prior: bool = False) -> None:
            """Replace the belief."""

        def update_history(self, real_action: Any, real_observation: Any) -> None:
            """Append what was done and seen."""

        def valid_actions(self, state: Any = None, history: Any = None) -> tuple[Any, ...]:
            """Return the actions that may be taken."""

    class Planner:
        """Chooses an action for an agent."""

    class POUCT(Planner):
        """UCT for partially observable problems."""

        last_num_sims: int
        last_planning_time: float

        def __init__(self, **settings: Any) -> None: ...

        def plan(self, agent: Agent) -> Any:
            """Return the action to take."""

        def update(self, agent: Agent, real_action: Any, real_observation: Any) -> None:
            """Keep the part of the tree that is still of use."""

    class POMCP(POUCT):
        """POUCT on particles."""

    class RootVNodeParticles:
        """The root of POMCP's tree."""

        belief: Particles

        @classmethod
        def from_vnode(cls, vnode: Any, history: Any) -> RootVNodeParticles:
            """Make a root of an inner node."""

else:
    from pomdp_py import (
        POMCP,
        POUCT,
        Action,
        Agent,
        GenerativeDistribution,
        ObjectState,
        Observation,
        ObservationModel,
        OOState,
        Particles,
        Planner,
        PolicyModel,
        RewardModel,
        RolloutPolicy,
        TransitionModel,
    )
    from pomdp_py.algorithms.pomcp import RootVNodeParticles
