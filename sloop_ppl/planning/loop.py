"""Run a search: plan, act, sense, update the belief, until all is found."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError, OutsideMap
from sloop_ppl.maps import CityMap
from sloop_ppl.planning._ask_models import (
    AskObservationModel,
    AskPolicyModel,
    AskRewardModel,
    AskTransitionModel,
)
from sloop_ppl.planning._dialogue import Dialogue
from sloop_ppl.planning._pomdp import Agent
from sloop_ppl.planning.belief import GridBelief, observation_likelihoods
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.environment import (
    Environment,
    GridEnvironment,
    Outcome,
    SearchEnded,
    checked_outcome,
    given_places,
    observation_of,
    robot_after,
    start_pose,
)
from sloop_ppl.planning.episode import Episode, PlanInfo, SearchInterrupted, Step
from sloop_ppl.planning.explain import expected_sightings, unreachable_notes
from sloop_ppl.planning.models import (
    SearchObservationModel,
    SearchPolicyModel,
    SearchRewardModel,
    SearchTransitionModel,
)
from sloop_ppl.planning.motion import Motion
from sloop_ppl.planning.planners import RunningPlanner, SearchPlanner, make_planner, planner_of
from sloop_ppl.planning.pose import Pose, as_pose
from sloop_ppl.planning.questions import AskedQuestion, Questioner
from sloop_ppl.planning.sensors import MaskSensor, Sensor
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import RobotState, SearchAction, SearchObservation
from sloop_ppl.rng import child, scalar_rng

__all__ = ["Tables", "run_search"]

Tables = Mapping[str, NDArray[np.float64]]


def run_search(
    beliefs: Tables,
    city: CityMap,
    places: Mapping[str, tuple[float, float]] | None = None,
    *,
    planner: str | SearchPlanner | Any = "fast",
    config: SearchConfig = SearchConfig(),  # noqa: B008 - frozen
    start: tuple[float, ...] | None = None,
    environment: Environment | None = None,
    sensor: Sensor | str | None = None,
    motion: Motion | None = None,
    rng: np.random.Generator,
    on_step: Callable[[Step], None] | None = None,
    on_observation: Callable[[Tables], Tables | None] | None = None,
    notify: Callable[[str], None] | None = None,
    keep_beliefs: bool = False,
    start_area: NDArray[np.bool_] | None = None,
    questioner: Questioner | None = None,
    max_questions: int = 1,
    on_question: Callable[[AskedQuestion], None] | None = None,
) -> Episode:
    """Search a map for targets that stand still.

    Parameters
    ----------
    beliefs
        Where each target is believed to be: a table over the cells per target id, shape (H, W),
        finite and >= 0; normalised here.
    city
        The map.
    places
        True place of each target, x and y in metres; the keys of `beliefs`. An environment that
        is given knows them itself.
    planner
        Name of a planner, or a planner: an object with a method `plan`; see `SearchPlanner`.
    config
        The settings.
    start
        x and y in metres and, if given, heading in degrees anticlockwise from east, a multiple of
        45; or a `Pose`. By default any cell, heading east, drawn from `rng`; the draw depends
        neither on the planner nor on the beliefs. An environment that is given has its own.
    environment
        Where the search takes place; a `GridEnvironment` of the true places when None.
    sensor
        What the robot senses, or ``FILE.py:NAME`` of it; the fan of the settings when None.
    motion
        How moves change the pose; the moves of the settings when None. Planners plan with it,
        and the grid environment moves by it.
    rng
        Where start, environment and planner draw from, each from its own child stream.
    on_step
        Called with every `Step` when it is done.
    on_observation
        Called after every step with ``{target: log_likelihood}``, tables of shape (H, W) of what
        the step showed of each target's cell (those of which it showed nothing are left out). What
        it returns, if not None, replaces the beliefs of the targets in it.
    notify
        Called with each line that is to be said before the first step: what the size of the map
        sets, belief that is out of reach, that machine code is compiled.
    keep_beliefs
        Keep the beliefs at every pose in the `Episode`.
    start_area
        True for the cells from which a start is drawn, shape (H, W); all when None.
    questioner
        Who can be asked during the search; nobody when None. ``pouct`` and ``pomcp`` have asking
        as an action; for all other planners the expected gain in discounted return decides before
        each step.
    max_questions
        How many questions may be asked.
    on_question
        Called with every `AskedQuestion`.

    Returns
    -------
    Episode
        What was done, seen and earned.

    Raises
    ------
    OutsideMap
        When a place, the start or a reported pose is outside the map.
    InputError
        When places or beliefs do not fit each other or the map, or something is malformed: beliefs,
        the planner, the sensor's mask, what the environment reports.
    UnknownName
        When there is no such planner.
    BeliefCollapse
        When something was observed that the beliefs held impossible.
    SearchInterrupted
        On Ctrl-C; it is a KeyboardInterrupt and holds the episode so far.

    Examples
    --------
    >>> import numpy as np
    >>> from sloop_ppl.maps import load_map
    >>> city = load_map("cleveland")
    >>> uniform, places = np.ones(city.grid.shape), {"RedBike": (2.5, 12.5)}
    >>> rng = np.random.default_rng(0)
    >>> run_search({"RedBike": uniform}, city, places, planner="greedy", rng=rng).found
    True
    """
    chosen = planner_of(planner)
    ids = tuple(beliefs)
    if not ids:
        raise InputError("No belief was given; expected one per target that is searched for")
    space = SearchSpace.of_city(city, ids, chosen.settings(config), sensor=sensor, motion=motion)
    if environment is None:
        # The start's stream depends on neither planner nor beliefs: searches can be compared.
        at, known = start_pose(start, space, rng, start_area), places or {}
        environment = GridEnvironment(space, known, at, rng=child(rng, "environment"))
    else:
        _refuse_with_environment(environment, start)
        known = given_places(places or {}, ids)
    pose = as_pose(environment.pose, "The environment's pose")
    try:
        robot = space.robot(space.snap(pose))
    except OutsideMap as error:
        raise OutsideMap(f"The environment's pose: {error}") from None
    reward_model = SearchRewardModel(space)
    name = chosen.name
    models: tuple[Any, ...] = (
        SearchPolicyModel(space, scalar_rng(child(rng, "policy"))),
        SearchTransitionModel(space, scalar_rng(child(rng, "planner", name, "motion"))),
        SearchObservationModel(space, scalar_rng(child(rng, "planner", name, "sensor"))),
        reward_model,
    )
    dialogue = None
    if questioner is not None:
        in_tree = bool(getattr(chosen, "asks", False))
        cells = {t: space.grid.cell_at(x, y) for t, (x, y) in known.items()}
        flat = {t: row * space.n_cols + col for t, (row, col) in cells.items()}
        dialogue = Dialogue(
            space, questioner, max_questions, in_tree=in_tree, cells=flat, on_question=on_question
        )
        if in_tree:
            answers = scalar_rng(child(rng, "planner", name, "answers"))
            models = (
                AskPolicyModel(models[0], dialogue.board),
                AskTransitionModel(models[1]),
                AskObservationModel(models[2], dialogue.board, len(ids), answers),
                AskRewardModel(models[3], dialogue.board),
            )
    agent = Agent(
        GridBelief(space, beliefs, robot, rng=child(rng, "planner", name, "belief"), pose=pose),
        *models,
    )
    running = make_planner(chosen, space, rng=rng)
    record = _Record(space, keep_beliefs)
    record.begin(pose, agent.belief)
    notes = [*space.config.size_notes(config), *unreachable_notes(agent.belief)]
    if notify is not None:
        for note in notes:
            notify(note)

    def so_far() -> Episode:
        return Episode(
            map_name=city.name,
            map_digest=city.digest,
            planner=name,
            config=space.config,
            places=MappingProxyType({t: (float(x), float(y)) for t, (x, y) in known.items()}),
            targets=ids,
            notes=tuple(notes),
            questions=tuple(dialogue.asked) if dialogue is not None else (),
            **record.columns(),
        )

    try:
        with _noting_compilation(notify):
            while not robot.ended and len(record.actions) < space.config.step_limit:
                # The order of a step: plan, act, sense, update; the reward is of the robot before
                # and after.
                if dialogue is None:
                    action, info = running.plan(agent)
                else:
                    action, info = dialogue.choose(agent, running, len(record.actions))
                info = replace(info, expected=expected_sightings(agent.belief))
                try:
                    done = environment.execute(action)
                except SearchEnded as ended:
                    notes.append(ended.reason)
                    if notify is not None:
                        notify(ended.reason)
                    break
                outcome = checked_outcome(space, action, done)
                after = robot_after(space, robot, action, outcome)
                observation = observation_of(space, action, after, outcome)
                _learn(agent, running, action, observation, after, outcome, on_observation)
                reward = reward_model.of(robot, action, after)
                robot = after
                step = record.add(action, outcome, reward, agent.belief, info)
                if on_step is not None:
                    on_step(step)
    except KeyboardInterrupt:
        raise SearchInterrupted(so_far()) from None
    return so_far()


def _noting_compilation(notify: Callable[[str], None] | None) -> AbstractContextManager[None]:
    """Say once that machine code is compiled, where the planner runs any."""
    if notify is None or "numba" not in sys.modules:
        return nullcontext()
    from sloop_ppl.planning._compile import COMPILING, notify_compiling

    return notify_compiling(lambda: notify(COMPILING))


def _refuse_with_environment(environment: Any, start: object) -> None:
    """Refuse an environment that is none, or a start beside it."""
    if not callable(getattr(environment, "execute", None)) or not hasattr(environment, "pose"):
        raise InputError(
            f"The environment is a {type(environment).__name__}; expected an object with a method "
            "execute(action) -> (pose, report, collision) and an attribute pose, where it starts"
        )
    if start is not None:
        raise InputError("start is given, but the environment has its own; leave start out")


def _learn(
    agent: Agent,
    running: RunningPlanner,
    action: SearchAction,
    observation: SearchObservation,
    after: RobotState,
    outcome: Outcome,
    on_observation: Callable[[Tables], Tables | None] | None,
) -> None:
    """Bring the agent's history, belief and planner up to date after one step."""
    before: GridBelief = agent.belief
    space = before.space
    agent.update_history(action, observation)
    likelihoods = observation_likelihoods(
        space, before.robot, action, observation, after, outcome.pose
    )
    updated = before.conditioned(likelihoods, observation, after, outcome.pose)
    agent.set_belief(updated)
    running.update(agent, action, observation)
    # With a stochastic motion the tree branches on the pose and knows where the robot is.
    if not space.stochastic and after != _planned(before.robot, action, after):
        running.forget()  # it planned on from another pose
    if on_observation is None:
        return
    replacing = on_observation(
        {
            name: likelihood.log_table(space.shape)
            for name, likelihood in zip(space.target_ids, likelihoods, strict=True)
            if likelihood is not None
        }
    )
    if replacing is not None:
        new = updated.replaced({**updated.tables, **replacing})
        agent.set_belief(new)
        # A table that comes back unchanged but for rounding is no reason to plan anew.
        moved = (np.abs(a - b).sum() > 1e-9 for a, b in zip(new.flat, updated.flat, strict=True))
        if any(moved):
            running.forget()


def _planned(robot: RobotState, action: SearchAction, after: RobotState) -> RobotState:
    """Return the robot as an exact motion would have left it."""
    if action.index < 3:
        return robot.moved(action.index)
    return robot.marked(after.found)


class _Record:
    """Collects what happens, in metres."""

    def __init__(self, space: SearchSpace, keep_beliefs: bool) -> None:
        self._space, self._keep = space, keep_beliefs
        self.actions: list[str] = []
        self._poses: list[Pose] = []
        self._observations: list[Mapping[str, Any]] = []
        self._rewards: list[float] = []
        self._views: list[NDArray[np.bool_]] = []
        self._infos: list[PlanInfo] = []
        self._beliefs: list[Tables] = []
        self._found = 0

    def begin(self, pose: Pose, belief: GridBelief) -> None:
        """Record where the search begins."""
        self._poses.append(pose)
        self._views.append(self._space.view_mask(pose))
        if self._keep:
            self._beliefs.append(MappingProxyType(belief.tables))

    def add(
        self,
        action: SearchAction,
        outcome: Outcome,
        reward: float,
        belief: GridBelief,
        info: PlanInfo,
    ) -> Step:
        """Record one step and return it."""
        self.begin(outcome.pose, belief)
        self.actions.append(action.name)
        self._rewards.append(float(reward))
        self._infos.append(info)
        self._found = belief.robot.found
        seen = outcome.report.seen
        self._observations.append(
            MappingProxyType({name: self._place(seen.get(name)) for name in self._space.target_ids})
        )
        return Step(
            index=len(self.actions) - 1,
            action=action.name,
            pose=self._poses[-1],
            observation=self._observations[-1],
            reward=float(reward),
            found_targets=self.found_targets(),
            view=self._views[-1],
            beliefs=MappingProxyType(belief.tables),
            info=info,
            collision=outcome.collision,
        )

    def _place(self, report: Any) -> Any:
        """Return the middle of the cell at which a target was seen; other reports as they are."""
        sensor = self._space.sensor
        if report is None or not isinstance(sensor, MaskSensor):
            return report
        return self._space.grid.centre_of(*divmod(sensor.cell_of(report), self._space.n_cols))

    def found_targets(self) -> tuple[str, ...]:
        """Return the ids of the targets found so far."""
        return tuple(t for i, t in enumerate(self._space.target_ids) if self._found >> i & 1)

    def columns(self) -> dict[str, Any]:
        """Return the fields of an `Episode` that were collected, up to the last whole step."""
        # Ctrl-C may come between two columns; a step counts once its observation is there.
        n = len(self._observations)
        return {
            "poses": tuple(self._poses[: n + 1]),
            "actions": tuple(self.actions[:n]),
            "observations": tuple(self._observations),
            "rewards": tuple(self._rewards[:n]),
            "found_targets": self.found_targets(),
            "views": np.array(self._views[: n + 1]),
            "info": tuple(self._infos[:n]),
            "beliefs": tuple(self._beliefs[: n + 1]),
        }
