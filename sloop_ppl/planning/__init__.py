"""Multi-object search on a grid: the OO-POMDP, its beliefs and planners, and the episode loop.

Names load on first use, because pomdp-py takes more than a second to import.
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import TYPE_CHECKING

from sloop_ppl._rooms import load_later
from sloop_ppl.planning.config import ROLLOUTS, SearchConfig

if TYPE_CHECKING:
    from sloop_ppl.planning._compile import notify_compiling
    from sloop_ppl.planning.baselines import Greedy, Random
    from sloop_ppl.planning.belief import GridBelief
    from sloop_ppl.planning.environment import (
        Environment,
        GridEnvironment,
        Outcome,
        Report,
        SearchEnded,
    )
    from sloop_ppl.planning.episode import Episode, PlanInfo, SearchInterrupted, Step
    from sloop_ppl.planning.fast import Fast, warm_up
    from sloop_ppl.planning.files import read_episode, write_episode
    from sloop_ppl.planning.information import AnswerTables, expected_bits
    from sloop_ppl.planning.loop import run_search
    from sloop_ppl.planning.models import (
        PublishedRollout,
        RandomRollout,
        SearchObservationModel,
        SearchPolicyModel,
        SearchRewardModel,
        SearchTransitionModel,
    )
    from sloop_ppl.planning.motion import ExactMotion, FiniteMotion, Motion, SlippingMotion
    from sloop_ppl.planning.native_pouct import (
        NativeFunctions,
        NativeModel,
        NativePouct,
        register_native,
        uniform,
    )
    from sloop_ppl.planning.path_search import PathSearch
    from sloop_ppl.planning.planners import (
        PLANNERS,
        RunningPlanner,
        SearchPlanner,
        list_planners,
        make_planner,
        planner_of,
    )
    from sloop_ppl.planning.pose import Pose
    from sloop_ppl.planning.questions import AskedQuestion, Questioner, QuestionTable, Reply
    from sloop_ppl.planning.sensors import FanSensor, MaskSensor, Sensor, fan_offsets
    from sloop_ppl.planning.space import SearchSpace
    from sloop_ppl.planning.tree_search import Pomcp, Pouct
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
    "AnswerTables",
    "AskedQuestion",
    "Environment",
    "Episode",
    "ExactMotion",
    "FanSensor",
    "Fast",
    "FiniteMotion",
    "Greedy",
    "GridBelief",
    "GridEnvironment",
    "MaskSensor",
    "Motion",
    "NativeFunctions",
    "NativeModel",
    "NativePouct",
    "Outcome",
    "PathSearch",
    "PlanInfo",
    "Pomcp",
    "Pose",
    "Pouct",
    "PublishedRollout",
    "QuestionTable",
    "Questioner",
    "Random",
    "RandomRollout",
    "Reply",
    "Report",
    "RobotState",
    "RunningPlanner",
    "SearchAction",
    "SearchConfig",
    "SearchEnded",
    "SearchInterrupted",
    "SearchObservation",
    "SearchObservationModel",
    "SearchPlanner",
    "SearchPolicyModel",
    "SearchRewardModel",
    "SearchSpace",
    "SearchState",
    "SearchTransitionModel",
    "Sensor",
    "SlippingMotion",
    "Step",
    "TargetState",
    "expected_bits",
    "fan_offsets",
    "list_planners",
    "make_planner",
    "notify_compiling",
    "planner_of",
    "read_episode",
    "register_native",
    "run_search",
    "uniform",
    "warm_up",
    "write_episode",
]

_HOMES = {
    "_compile": ("notify_compiling",),
    "belief": ("GridBelief",),
    "environment": ("Environment", "GridEnvironment", "Outcome", "Report", "SearchEnded"),
    "episode": ("Episode", "PlanInfo", "SearchInterrupted", "Step"),
    "fast": ("Fast", "warm_up"),
    "files": ("read_episode", "write_episode"),
    "baselines": ("Greedy", "Random"),
    "loop": ("run_search",),
    "models": (
        "PublishedRollout",
        "RandomRollout",
        "SearchObservationModel",
        "SearchPolicyModel",
        "SearchRewardModel",
        "SearchTransitionModel",
    ),
    "motion": ("ExactMotion", "FiniteMotion", "Motion", "SlippingMotion"),
    "native_pouct": (
        "NativeFunctions",
        "NativeModel",
        "NativePouct",
        "register_native",
        "uniform",
    ),
    "path_search": ("PathSearch",),
    "planners": (
        "PLANNERS",
        "RunningPlanner",
        "SearchPlanner",
        "list_planners",
        "make_planner",
        "planner_of",
    ),
    "information": ("AnswerTables", "expected_bits"),
    "pose": ("Pose",),
    "questions": ("AskedQuestion", "QuestionTable", "Questioner", "Reply"),
    "sensors": ("FanSensor", "MaskSensor", "Sensor", "fan_offsets"),
    "space": ("SearchSpace",),
    "tree_search": ("Pomcp", "Pouct"),
    "values": ("RobotState", "SearchAction", "SearchObservation", "SearchState", "TargetState"),
}


if "gymnasium" in sys.modules:
    import_module(f"{__name__}.gym_register")


__getattr__ = load_later(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted(__all__)
