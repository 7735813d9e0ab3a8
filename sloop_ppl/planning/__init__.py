"""Multi-object search on a grid: the OO-POMDP, its beliefs and planners, and the episode loop.

Names load on first use, because pomdp-py takes more than a second to import.
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import TYPE_CHECKING

from sloop_ppl._rooms import load_later
from sloop_ppl.planning.config import ROLLOUTS, SearchConfig
from sloop_ppl.planning.names import list_planners

if TYPE_CHECKING:
    from sloop_ppl.planning.belief import GridBelief
    from sloop_ppl.planning.episode import Episode, PlanInfo, SearchInterrupted, Step
    from sloop_ppl.planning.files import read_episode, write_episode
    from sloop_ppl.planning.greedy import GreedyPlanner
    from sloop_ppl.planning.loop import run_search
    from sloop_ppl.planning.models import (
        PublishedRollout,
        RandomRollout,
        SearchObservationModel,
        SearchPolicyModel,
        SearchRewardModel,
        SearchTransitionModel,
    )
    from sloop_ppl.planning.planners import PLANNERS, SearchPlanner, make_planner
    from sloop_ppl.planning.sensing import fan_offsets
    from sloop_ppl.planning.space import SearchSpace
    from sloop_ppl.planning.values import (
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


__getattr__ = load_later(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted(__all__)
