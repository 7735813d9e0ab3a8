"""What a search did, as a frozen value."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning._by_value import ByValue
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.pose import Pose
from sloop_ppl.planning.questions import AskedQuestion

__all__ = ["Episode", "PlanInfo", "SearchInterrupted", "Step"]

Observed = Mapping[str, Any]
Tables = Mapping[str, NDArray[np.float64]]


@dataclass(frozen=True)
class PlanInfo(ByValue):
    """What a planner says about one decision.

    Parameters
    ----------
    planner
        Its name.
    sims
        Simulations run; 0 for planners that run none.
    seconds
        Wall time of the decision.
    values
        Estimated discounted return of each action looked at; of a move of ``fast`` with its own
        rollout, under the hedged belief it plans on.
    visits
        How often each was tried.
    expected
        By move and target, the belief that the move brings the target into view.
    tree
        The top of the search tree as JSON values, where `SearchConfig.tree_depth` asks for it.
    root
        The root of the tree itself, where pomdp-py's tree is asked for; None else.
    notes
        Anything else, such as how many particles were drawn anew.
    """

    planner: str
    sims: int = 0
    seconds: float = 0.0
    values: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    visits: Mapping[str, int] = field(default_factory=lambda: MappingProxyType({}))
    expected: Mapping[str, Mapping[str, float]] = field(
        default_factory=lambda: MappingProxyType({})
    )
    tree: Mapping[str, Any] | None = None
    root: Any = field(default=None, repr=False, compare=False)
    notes: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True)
class Step(ByValue):
    """One step of a search.

    Parameters
    ----------
    index
        Number of the step, from 0.
    action
        Name of what was done.
    pose
        Where the robot is after it.
    observation
        Place at which each target was seen (centre of the cell, metres), or None; of a sensor that
        sees no mask, what it reported.
    reward
        What it earned.
    found_targets
        Targets found so far.
    view
        Cells in view after it, True where seen, shape (H, W).
    beliefs
        Belief of each target after it, shape (H, W).
    info
        What the planner says about the decision.
    collision
        Whether the robot ran into something.
    """

    index: int
    action: str
    pose: Pose
    observation: Observed
    reward: float
    found_targets: tuple[str, ...]
    view: NDArray[np.bool_]
    beliefs: Tables
    info: PlanInfo
    collision: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class Episode(ByValue):
    """A whole search.

    Parameters
    ----------
    map_name
        Name of the map.
    planner
        Name of the planner.
    config
        The settings.
    places
        True place of each target, metres, as far as the search was told.
    poses
        Poses in metres and radians, the start first, so one more than there are actions.
    actions
        Names of the actions.
    observations
        Place at which each target was seen after each step, or None.
    rewards
        Reward of each step.
    found_targets
        The targets found, in the order of `places`.
    views
        Cells in view at each pose, shape (steps + 1, H, W).
    info
        What the planner says about each decision.
    beliefs
        Beliefs at each pose when they were asked for, else empty.
    imagined
        Targets whose place was not known but drawn from the belief.
    map_digest
        `CityMap.digest` of the map; empty where it is not known.
    targets
        The targets that were searched for; those of `places` when empty.
    notes
        What is to be said about the search as a whole, such as belief out of reach.
    questions
        The questions that were asked, in their order.
    """

    map_name: str
    planner: str
    config: SearchConfig
    places: Mapping[str, tuple[float, float]]
    poses: tuple[Pose, ...]
    actions: tuple[str, ...]
    observations: tuple[Observed, ...]
    rewards: tuple[float, ...]
    found_targets: tuple[str, ...]
    views: NDArray[np.bool_]
    info: tuple[PlanInfo, ...] = ()
    beliefs: tuple[Tables, ...] = ()
    imagined: tuple[str, ...] = ()
    map_digest: str = ""
    targets: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    questions: tuple[AskedQuestion, ...] = ()

    def __repr__(self) -> str:
        wanted = self.targets or tuple(self.places)
        return (
            f"Episode({self.map_name!r}, {self.planner!r}: {self.steps} steps, found "
            f"{len(self.found_targets)} of {len(wanted)}, discounted return "
            f"{self.discounted_return:.1f})"
        )

    def _repr_html_(self) -> str:
        from sloop_ppl._html import beside, caption, html_table, svg_map

        path = [(pose.x_m, pose.y_m) for pose in self.poses]
        marks = [(x, y, "#009e73") for x, y in self.places.values()]
        marks.append((*path[0], "#22252b"))
        x, y = ([point[i] for point in (*path, *((m[0], m[1]) for m in marks))] for i in (0, 1))
        reach = max(max(x) - min(x), max(y) - min(y), 20.0) / 2 + 10.0  # metres about what is drawn
        east, north = (max(x) + min(x)) / 2, (max(y) + min(y)) / 2
        extent = east - reach, north - reach, east + reach, north + reach
        drawing = svg_map(extent, path=path, marks=marks, title=f"Path of {self.steps} steps")
        counts = {name: self.actions.count(name) for name in dict.fromkeys(self.actions)}
        rows: list[tuple[object, object]] = [
            ("steps", self.steps),
            ("found", ", ".join(self.found_targets) or "nothing"),
            ("discounted return", self.discounted_return),
            ("questions", len(self.questions)),
            *counts.items(),
        ]
        return caption(repr(self)) + beside([drawing, html_table(rows)])

    @property
    def start(self) -> Pose:
        """Where the robot began."""
        return self.poses[0]

    @property
    def steps(self) -> int:
        """How many steps were taken."""
        return len(self.actions)

    @property
    def found(self) -> bool:
        """Whether every target was found."""
        return len(self.found_targets) == len(self.targets or self.places)

    @property
    def discounted_return(self) -> float:
        """Sum of ``discount ** t * reward`` over the steps t = 0, 1, ..., less what asking cost.

        A question that takes steps delays all that comes after it.
        """
        return math.fsum((self.gross_discounted_return, *self._discounted_costs()))

    @property
    def gross_discounted_return(self) -> float:
        """The same without the costs of questions; the steps that they took count."""
        delays = [sum(q.steps for q in self.questions if q.step <= t) for t in range(self.steps)]
        return math.fsum(
            self.config.discount ** (t + delay) * r
            for t, (r, delay) in enumerate(zip(self.rewards, delays, strict=True))
        )

    def _discounted_costs(self) -> list[float]:
        found, delay = [], 0
        for question in self.questions:
            found.append(-question.cost * self.config.discount ** (question.step + delay))
            delay += question.steps
        return found

    @property
    def undiscounted_return(self) -> float:
        """Sum of the rewards, less what asking cost."""
        return math.fsum((*self.rewards, *(-q.cost for q in self.questions)))

    def to_json(self) -> dict[str, Any]:
        """Return what ``sloop search --json`` prints, but for the model and the seed."""
        return {
            "map": self.map_name,
            "planner": self.planner,
            "sims": self.config.sims,
            "places": {name: list(place) for name, place in self.places.items()},
            "poses": [[pose.x_m, pose.y_m, pose.heading_deg] for pose in self.poses],
            "actions": list(self.actions),
            "observations": [
                {n: list(at) if isinstance(at, tuple) else at for n, at in seen.items()}
                for seen in self.observations
            ],
            "rewards": list(self.rewards),
            **({"notes": list(self.notes)} if self.notes else {}),
            **(
                {"questions": [_question_record(q) for q in self.questions]}
                if self.questions
                else {}
            ),
            **({"imagined": list(self.imagined)} if self.imagined else {}),
            "found": self.found,
            "found_targets": list(self.found_targets),
            "steps": self.steps,
            "discounted_return": self.discounted_return,
        }


def _question_record(question: AskedQuestion) -> dict[str, Any]:
    """Return a question as ``sloop search --json`` prints it."""
    return {
        "step": question.step,
        "text": question.text,
        "answer": question.answer,
        "target": question.target,
        "cost": question.cost,
        "steps": question.steps,
        "bits": question.bits,
        "realised_bits": question.realised,
        "gain": question.gain,
        **({"note": question.note} if question.note else {}),
    }


class SearchInterrupted(KeyboardInterrupt):
    """Ctrl-C ended a search.

    Attributes
    ----------
    episode
        What was done until then.
    """

    def __init__(self, episode: Episode) -> None:
        self.episode = episode
        super().__init__(f"The search was interrupted after {episode.steps} steps")
