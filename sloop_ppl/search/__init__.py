"""Multi-object search on a grid: the OO-POMDP, its beliefs and planners, and the episode loop.

Names load on first use, because pomdp-py takes more than a second to import.

``sloop_ppl.search(posterior, city, ...)`` is the facade function: importing this room binds its
name in the package, so the module itself can be called and hands the call on.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

from sloop_ppl.search.config import ROLLOUTS, SearchConfig
from sloop_ppl.search.names import list_planners

if TYPE_CHECKING:
    from sloop_ppl.search.belief import GridBelief
    from sloop_ppl.search.episode import Episode, PlanInfo, SearchInterrupted, Step
    from sloop_ppl.search.files import read_episode, write_episode
    from sloop_ppl.search.greedy import GreedyPlanner
    from sloop_ppl.search.loop import run_search
    from sloop_ppl.search.models import (
        PublishedRollout,
        RandomRollout,
        SearchObservationModel,
        SearchPolicyModel,
        SearchRewardModel,
        SearchTransitionModel,
    )
    from sloop_ppl.search.planners import PLANNERS, SearchPlanner, make_planner
    from sloop_ppl.search.sensing import fan_offsets
    from sloop_ppl.search.space import SearchSpace
    from sloop_ppl.search.values import (
        RobotState,
        SearchAction,
        SearchObservation,
        SearchState,
        TargetState,
    )

__all__ = [
    "PLANNERS",
    "ROLLOUTS",
    "Episode",
    "GreedyPlanner",
    "GridBelief",
    "PlanInfo",
    "PublishedRollout",
    "RandomRollout",
    "RobotState",
    "SearchAction",
    "SearchConfig",
    "SearchInterrupted",
    "SearchObservation",
    "SearchObservationModel",
    "SearchPlanner",
    "SearchPolicyModel",
    "SearchRewardModel",
    "SearchSpace",
    "SearchState",
    "SearchTransitionModel",
    "Step",
    "TargetState",
    "fan_offsets",
    "list_planners",
    "make_planner",
    "read_episode",
    "run_search",
    "write_episode",
]

_HOMES = {
    "belief": ("GridBelief",),
    "episode": ("Episode", "PlanInfo", "SearchInterrupted", "Step"),
    "files": ("read_episode", "write_episode"),
    "greedy": ("GreedyPlanner",),
    "loop": ("run_search",),
    "models": (
        "PublishedRollout",
        "RandomRollout",
        "SearchObservationModel",
        "SearchPolicyModel",
        "SearchRewardModel",
        "SearchTransitionModel",
    ),
    "planners": ("PLANNERS", "SearchPlanner", "make_planner"),
    "sensing": ("fan_offsets",),
    "space": ("SearchSpace",),
    "values": ("RobotState", "SearchAction", "SearchObservation", "SearchState", "TargetState"),
}


if "gymnasium" in sys.modules:
    import_module(f"{__name__}.gym_register")


def __getattr__(name: str) -> Any:
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{module}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)


class _CallableRoom(ModuleType):
    """The room as a module that is the facade function of the same name too."""

    def __call__(self, *args: Any, **options: Any) -> Episode:
        """Search the map for the targets of a posterior; see `sloop_ppl.bridge.search`."""
        found: Episode = import_module("sloop_ppl.bridge").search(*args, **options)
        return found


sys.modules[__name__].__class__ = _CallableRoom
