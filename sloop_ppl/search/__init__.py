"""Multi-object search on a grid: the OO-POMDP, its beliefs and planners, and the episode loop.

Names load on first use, because pomdp-py takes more than a second to import.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from sloop_ppl.search.config import ROLLOUTS, SearchConfig
from sloop_ppl.search.names import list_planners

if TYPE_CHECKING:
    from sloop_ppl.search.belief import GridBelief
    from sloop_ppl.search.episode import Episode, PlanInfo, Step
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
    "GridBelief",
    "PlanInfo",
    "PublishedRollout",
    "RandomRollout",
    "RobotState",
    "SearchAction",
    "SearchConfig",
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
    "run_search",
]

_HOMES = {
    "belief": ("GridBelief",),
    "episode": ("Episode", "PlanInfo", "Step"),
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


def __getattr__(name: str) -> Any:
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{module}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
