"""The planners by name, what a search asks of one, and planners from outside.

A planner is a value, such as ``Pouct(sims=500)``; at the start of each search it begins a running
planner, which chooses the actions.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.registry import Registry
from sloop_ppl.rng import child
from sloop_ppl.user_file import UserValue, is_user_file, load_from_file

if TYPE_CHECKING:
    from sloop_ppl.planning._pomdp import Agent
    from sloop_ppl.planning.episode import PlanInfo
    from sloop_ppl.planning.space import SearchSpace
    from sloop_ppl.planning.values import SearchAction, SearchObservation

__all__ = [
    "NOT_SIMULATING",
    "PLANNERS",
    "RunningPlanner",
    "SearchPlanner",
    "list_planners",
    "make_planner",
    "overridden",
    "planner_of",
]


@runtime_checkable
class RunningPlanner(Protocol):
    """A planner in the course of one search."""

    def plan(self, agent: Agent) -> tuple[SearchAction, PlanInfo]:
        """Return the action to take and what is to be said about it."""
        ...

    def update(self, agent: Agent, action: SearchAction, observation: SearchObservation) -> None:
        """Learn what was done and observed; the agent's history and belief have it already."""
        ...

    def forget(self) -> None:
        """Drop what was built on the old belief: something else than the plan changed it."""
        ...


@runtime_checkable
class SearchPlanner(Protocol):
    """A planner as a value.

    Notes
    -----
    A planner from outside needs less: a method ``plan(agent)`` that returns an action, its name,
    or action and `PlanInfo`. It may have ``begin(space, *, rng)``, called at the start of each
    search, which may return another object that plans; ``update`` and ``forget`` as in
    `RunningPlanner`; and a ``name``. A planner of pomdp-py is one.
    """

    @property
    def name(self) -> str:
        """What the planner is called in episodes."""
        ...

    def settings(self, config: SearchConfig) -> SearchConfig:
        """Return the settings of the search with the planner's own in their places."""
        ...

    def begin(self, space: SearchSpace, *, rng: np.random.Generator) -> RunningPlanner:
        """Return a planner for one search."""
        ...


PLANNERS: Registry[type[SearchPlanner]] = Registry("planner")
"""Every planner's class by name."""

for _name, _module, _class in (
    ("pouct", "tree_search", "Pouct"),
    ("pomcp", "tree_search", "Pomcp"),
    ("fast", "fast", "Fast"),
    ("greedy", "baselines", "Greedy"),
    ("random", "baselines", "Random"),
):
    PLANNERS.add_later(_name, f"sloop_ppl.planning.{_module}", _class)

NOT_SIMULATING = ("greedy", "random")
"""Those that run no simulations, so that their number and their rollout say nothing."""


def list_planners() -> list[str]:
    """Return the names of the planners.

    Examples
    --------
    >>> "pouct" in list_planners()
    True
    """
    return list(PLANNERS)


def overridden(config: SearchConfig, planner: Any) -> SearchConfig:
    """Return settings with those fields of a planner that are not None in their places."""
    own = {f.name: getattr(planner, f.name) for f in fields(planner)}
    return replace(config, **{name: value for name, value in own.items() if value is not None})


def planner_of(planner: Any) -> SearchPlanner:
    """Return the planner that a name, a file or an object stands for.

    Parameters
    ----------
    planner
        A name of `PLANNERS`; ``FILE.py:NAME``; a planner, its class, or any object with a method
        ``plan``.

    Raises
    ------
    UnknownName
        When there is no such planner.
    InputError
        When it is no planner, or the file does not hold one.
    """
    if isinstance(planner, str):
        if not is_user_file(planner):
            return PLANNERS[planner]()
        file = load_from_file(planner, "Planner", _WANTED, _plans)
        if isinstance(file.value, SearchPlanner):
            return file.value
        return _FromOutside(file.value, file.label, file)
    if isinstance(planner, type) and _plans(planner):
        planner = planner()
    if isinstance(planner, SearchPlanner):
        return planner
    if not _plans(planner):
        raise InputError(f"The planner is a {type(planner).__name__}; expected {_WANTED}")
    return _FromOutside(planner, str(getattr(planner, "name", type(planner).__name__)))


def make_planner(planner: Any, space: SearchSpace, *, rng: np.random.Generator) -> RunningPlanner:
    """Return a planner for one search of a space, to be run step by step.

    Parameters
    ----------
    planner
        A planner or its name, as `planner_of` takes it.
    space
        The search space; settings of the planner's own must agree with its.
    rng
        The planner draws from its own child stream of this.

    Raises
    ------
    UnknownName
        When there is no such planner.
    InputError
        When it has settings of its own that the space does not have.
    """
    chosen = planner_of(planner)
    if chosen.settings(space.config) != space.config:
        raise InputError(
            f"Planner '{chosen.name}' has settings that the search space does not have; make the "
            "space with SearchSpace(..., planner.settings(config))"
        )
    return chosen.begin(space, rng=child(rng, "planner", chosen.name))


_WANTED = "a planner's name, or an object with a method plan(agent) that returns an action"


def _plans(value: Any) -> bool:
    return callable(getattr(value, "plan", None)) or isinstance(value, SearchPlanner)


@dataclass(frozen=True)
class _FromOutside:
    """A planner of a user's own, as a value."""

    planner: Any
    name: str
    file: UserValue | None = None

    def settings(self, config: SearchConfig) -> SearchConfig:
        return config

    def begin(self, space: SearchSpace, *, rng: np.random.Generator) -> RunningPlanner:
        started = self._guarded(self.planner)
        if callable(getattr(started, "begin", None)):
            started = self._guarded(started.begin(space, rng=rng) or started)
        if not callable(getattr(started, "plan", None)):
            raise InputError(
                f"Planner '{self.name}' has no method plan(agent) once it has begun; expected "
                "begin to return an object that plans, or None"
            )
        return _Running(started, space, self.name)

    def _guarded(self, planner: Any) -> Any:
        if self.file is None:
            return planner
        return self.file.guard(planner, ("begin", "plan", "update", "forget"))


class _Running:
    """A user's planner in the course of one search; what it chooses is checked."""

    def __init__(self, planner: Any, space: SearchSpace, name: str) -> None:
        self._planner, self._name = planner, name
        self._agent: Any = None
        self._actions: Mapping[str, SearchAction] = MappingProxyType(
            {action.name: action for action in space.actions}
        )

    def plan(self, agent: Agent) -> tuple[SearchAction, PlanInfo]:
        from sloop_ppl.planning.episode import PlanInfo

        self._agent = agent
        chosen, info = self._planner.plan(agent), None
        if isinstance(chosen, tuple) and len(chosen) == 2:
            chosen, info = chosen
        action = self._actions.get(str(chosen))
        if action is None:
            raise InputError(
                f"Planner '{self._name}' chose {chosen!r}; expected one of: "
                f"{', '.join(self._actions)}"
            )
        if not isinstance(info, PlanInfo):
            info = PlanInfo(self._name)
        return action, info

    def update(self, agent: Agent, action: SearchAction, observation: SearchObservation) -> None:
        if callable(getattr(self._planner, "update", None)):
            self._planner.update(agent, action, observation)

    def forget(self) -> None:
        if callable(getattr(self._planner, "forget", None)):
            self._planner.forget()
        elif getattr(self._agent, "tree", None) is not None:
            self._agent.tree = None  # where the planners of pomdp-py keep it
