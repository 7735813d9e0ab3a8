"""One trial of the paper's experiment: search for one described target under one belief."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl._records import Fault, checked
from sloop_ppl.errors import InputError
from sloop_ppl.eval._run_records import TrialRecord
from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.maps import CityMap, Grid
from sloop_ppl.planning import SearchConfig
from sloop_ppl.planning.planners import NOT_SIMULATING, planner_of
from sloop_ppl.rng import child

if TYPE_CHECKING:
    from sloop_ppl.planning import Episode

__all__ = ["Searching", "Trial", "TrialKey", "compile_ahead", "run_trial", "trial_of"]

_LEAST = 1e-15
# What each search needs of a belief: a target in a cell that was excluded can still be seen.


@dataclass(frozen=True, order=True)
class TrialKey:
    """What makes a trial the one it is; its random numbers follow from it alone.

    Parameters
    ----------
    description
        Id of the description.
    target
        Id of the target.
    model
        Name of the model.
    range_cells
        How far the sensor sees, cells.
    start
        Number of the start, from 0.
    questions
        How many questions may be asked.
    question_cost
        What each costs; 0 where none may be asked.
    """

    description: str
    target: str
    model: str
    range_cells: float
    start: int
    questions: int = 0
    question_cost: float = 0.0


@dataclass(frozen=True)
class Trial:
    """What came of a trial.

    Parameters
    ----------
    key
        Which trial it is.
    map, configuration
        Where, and of which placement of the objects.
    found
        Whether the target was found.
    steps
        Steps taken.
    discounted_reward
        Sum of the discounted rewards.
    reward
        Sum of the rewards.
    start_m
        Where the robot began, x and y in metres.
    seconds
        Wall time of the search; two runs of a trial differ in nothing else.
    asked
        Questions that were asked.
    gross_reward
        Sum of the discounted rewards without the costs of questions; None in a sweep that does not
        ask.
    expected_bits, realised_bits
        Expected information of the questions, and by how many bits the belief in the true cell
        rose by their answers.
    log_score
        Natural log of the belief at the true cell before the search; None in a sweep that does not
        ask.
    """

    key: TrialKey
    map: str
    configuration: str
    found: bool
    steps: int
    discounted_reward: float
    reward: float
    start_m: tuple[float, float]
    seconds: float
    asked: int = 0
    gross_reward: float | None = None
    expected_bits: float = 0.0
    realised_bits: float = 0.0
    log_score: float | None = None

    def to_json(self) -> dict[str, Any]:
        """Return the trial as one flat JSON object."""
        x, y = self.start_m
        return {
            **asdict(self.key),
            "map": self.map,
            "configuration": self.configuration,
            "found": self.found,
            "steps": self.steps,
            "discounted_reward": self.discounted_reward,
            "reward": self.reward,
            "start_x_m": x,
            "start_y_m": y,
            "seconds": self.seconds,
            "asked": self.asked,
            "gross_reward": self.gross_reward,
            "expected_bits": self.expected_bits,
            "realised_bits": self.realised_bits,
            "log_score": self.log_score,
        }

    @classmethod
    def of(
        cls, key: TrialKey, annotated: AnnotatedDescription, episode: Episode, seconds: float
    ) -> Trial:
        """Return what came of an episode, as if nothing was asked."""
        return cls(
            key=key,
            map=annotated.map,
            configuration=annotated.configuration,
            found=episode.found,
            steps=episode.steps,
            discounted_reward=episode.discounted_return,
            reward=math.fsum(episode.rewards),
            start_m=episode.start[:2],
            seconds=seconds,
        )

    @classmethod
    def from_json(cls, record: Mapping[str, Any]) -> Trial:
        """Return the trial that `to_json` told.

        Raises
        ------
        InputError
            When a member is missing or unusable.
        """
        try:
            known = checked(record, TrialRecord)
        except Fault as fault:
            raise InputError(f"is no trial ({fault})") from fault
        return cls(
            key=TrialKey(
                known.description,
                known.target,
                known.model,
                known.range_cells,
                known.start,
                known.questions,
                known.question_cost,
            ),
            map=known.map,
            configuration=known.configuration,
            found=known.found,
            steps=known.steps,
            discounted_reward=known.discounted_reward,
            reward=known.reward,
            start_m=(known.start_x_m, known.start_y_m),
            seconds=known.seconds,
            asked=known.asked,
            gross_reward=known.gross_reward,
            expected_bits=known.expected_bits,
            realised_bits=known.realised_bits,
            log_score=known.log_score,
        )


@dataclass(frozen=True)
class Searching:
    """How the trials of a sweep search; the sensor's range is each trial's own.

    Parameters
    ----------
    planner
        Name of the planner.
    sims
        Simulations per step.
    rollout
        The planner's rollout; its own when None.
    fov_deg
        Opening of the sensor's fan, degrees.
    max_steps
        Steps after which a search ends; 200, more on a larger map, when None.
    seed
        Seed of all random numbers.

    Raises
    ------
    InputError
        When a value is out of its range.
    UnknownName
        When there is no such planner or rollout.
    """

    planner: str = "fast"
    sims: int = 1000
    rollout: str | None = None
    fov_deg: float = 90.0
    max_steps: int | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        planner_of(self.planner)
        if self.seed < 0:
            raise InputError(f"The seed is {self.seed}; expected 0 or more")
        self.config(max(3.0, SearchConfig.sensor_min_range_cells))

    def config(self, range_cells: float) -> SearchConfig:
        """Return the settings of a search with this range."""
        own = {f.name: getattr(self, f.name) for f in fields(self)}
        del own["planner"], own["seed"]
        return SearchConfig(sensor_range_cells=range_cells, **own)

    @property
    def label(self) -> str:
        """The planner in a few words, such as ``"fast 1000, published rollout"``."""
        if self.planner in NOT_SIMULATING:
            return self.planner
        rollout = f", {self.rollout} rollout" if self.rollout else ""
        return f"{self.planner} {self.sims}{rollout}"


def compile_ahead(searching: Searching) -> None:
    """Have a planner's machine code made and kept before many processes ask for it at once.

    Each would make it for itself, and numba saves it in two steps, between which another process
    may load what an older version left behind.
    """
    from sloop_ppl.planning import run_search

    city = CityMap("small", Grid.square(50.0), ())
    config = replace(searching.config(3.0), sims=20, max_steps=1)
    belief = np.full(city.grid.shape, 1.0)
    rng = np.random.default_rng(0)
    run_search(
        {"T": belief}, city, {"T": (0.0, 0.0)}, planner=searching.planner, config=config, rng=rng
    )


def run_trial(
    key: TrialKey,
    annotated: AnnotatedDescription,
    city: CityMap,
    belief: NDArray[np.float64],
    searching: Searching,
) -> Episode:
    """Search for the target of a trial.

    Parameters
    ----------
    belief
        Where the target is believed to be, shape (H, W), summing to one.

    Notes
    -----
    The start and the noise of the environment are drawn from streams named after description,
    target and number of the start, so that every model, range and planner meets the same ones.
    The start of a line with ``area_m`` lies in that area.
    Cells that the belief excludes altogether count as 1e-15.
    """
    from sloop_ppl.planning import run_search  # takes a second to import

    place, area = annotated.targets[key.target], annotated.search_area(city.grid)
    rng = child(
        np.random.default_rng(searching.seed), "trial", key.description, key.target, key.start
    )
    return run_search(
        {key.target: np.maximum(belief, _LEAST)},
        city,
        {key.target: (place.x_m, place.y_m)},
        planner=searching.planner,
        config=searching.config(key.range_cells),
        rng=rng,
        start_area=None if area is None else area.cells,
    )


def trial_of(
    key: TrialKey,
    annotated: AnnotatedDescription,
    city: CityMap,
    belief: NDArray[np.float64],
    searching: Searching,
) -> Trial:
    """Run a trial and return what came of it; arguments as in `run_trial`."""
    begun = time.perf_counter()
    episode = run_trial(key, annotated, city, belief, searching)
    return Trial.of(key, annotated, episode, time.perf_counter() - begun)
