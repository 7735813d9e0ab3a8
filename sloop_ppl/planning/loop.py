"""Run a search: plan, act, sense, update the belief, until all is found."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.maps import CityMap
from sloop_ppl.planning._pomdp import Agent
from sloop_ppl.planning.belief import GridBelief, observation_likelihoods
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.detection import Detector
from sloop_ppl.planning.episode import Episode, SearchInterrupted, Step
from sloop_ppl.planning.explain import expected_sightings
from sloop_ppl.planning.models import (
    SearchObservationModel,
    SearchPolicyModel,
    SearchRewardModel,
    SearchTransitionModel,
)
from sloop_ppl.planning.names import check_planner
from sloop_ppl.planning.obstacles import tall_cells
from sloop_ppl.planning.placing import start_pose, true_cells
from sloop_ppl.planning.planners import SearchPlanner, make_planner
from sloop_ppl.planning.record import Record
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.tree import scalar_rng
from sloop_ppl.planning.values import SearchAction, SearchObservation, SearchState
from sloop_ppl.rng import child

__all__ = ["Tables", "run_search"]

Tables = Mapping[str, NDArray[np.float64]]


def run_search(
    beliefs: Tables,
    city: CityMap,
    places: Mapping[str, tuple[float, float]],
    *,
    planner: str = "pouct",
    config: SearchConfig = SearchConfig(),  # noqa: B008 - frozen
    start: tuple[float, ...] | None = None,
    rng: np.random.Generator,
    on_step: Callable[[Step], None] | None = None,
    on_observation: Callable[[Tables], Tables | None] | None = None,
    keep_beliefs: bool = False,
) -> Episode:
    """Search a map for targets that stand still.

    Parameters
    ----------
    beliefs : where each target is believed to be: a table over the cells per target id, shape
        (H, W), finite and >= 0; normalised here.
    city : the map.
    places : true place of each target, x and y in metres; the keys of `beliefs`.
    planner : name of a planner.
    config : the settings.
    start : x and y in metres and, if given, heading in degrees anticlockwise from east, a
        multiple of 45. By default any cell, heading east, drawn from `rng`; the draw depends
        neither on the planner nor on the beliefs.
    rng : where start, environment and planner draw from, each from its own child stream.
    on_step : called with every `Step` when it is done.
    on_observation : called after every step with ``{target: log_likelihood}``, tables of shape
        (H, W) of what the step showed of each target's cell (those of which it told nothing are
        left out). What it returns, if not None, replaces the beliefs of the targets in it.
    keep_beliefs : keep the beliefs at every pose in the `Episode`.

    Returns
    -------
    Episode
        What was done, seen and earned.

    Raises
    ------
    OutsideMap : when a place or the start is outside the map.
    InputError : when places or beliefs do not fit each other or the map, or are malformed.
    UnknownName : when there is no such planner.
    BeliefCollapse : when something was observed that the beliefs held impossible.
    SearchInterrupted : on Ctrl-C; it is a KeyboardInterrupt and holds the episode so far.
    """
    check_planner(planner)
    ids = tuple(beliefs)
    truth = true_cells(ids, places, city.grid)
    tall = None
    if config.no_fly or config.occlusion:
        tall = tall_cells(city, config.flight_height_m)
    space = SearchSpace(city.grid.shape, ids, config, tall)
    robot = space.robot(start_pose(start, city.grid, space, rng))
    state = SearchState(robot, truth)
    transition, reward_model = SearchTransitionModel(space), SearchRewardModel(space)
    imagined = SearchObservationModel(space, scalar_rng(child(rng, "planner", planner, "sensor")))
    sensor = SearchObservationModel(space, scalar_rng(child(rng, "environment")))
    agent = Agent(
        GridBelief(space, beliefs, robot, rng=child(rng, "planner", planner, "belief")),
        SearchPolicyModel(space, scalar_rng(child(rng, "policy"))),
        transition,
        imagined,
        reward_model,
    )
    chooser = make_planner(planner, space, rng=rng)

    record = Record(city.grid, space, keep_beliefs)
    record.begin(agent.belief)

    def so_far() -> Episode:
        return Episode(
            map_name=city.name,
            map_digest=city.digest,
            planner=planner,
            config=config,
            places=MappingProxyType({t: (float(places[t][0]), float(places[t][1])) for t in ids}),
            **record.columns(),
        )

    try:
        while not state.robot.ended and len(record.actions) < config.max_steps:
            action, info = chooser.plan(agent)
            info = replace(info, expected=expected_sightings(agent.belief))
            after = transition.sample(state, action)
            observation = sensor.sample(after, action)
            reward = reward_model.sample(state, action, after)
            _learn(agent, chooser, action, observation, after, on_observation)
            state = after
            step = record.add(action, observation, reward, agent.belief, info)
            if on_step is not None:
                on_step(step)
    except KeyboardInterrupt:
        raise SearchInterrupted(so_far()) from None
    return so_far()


def _learn(
    agent: Agent,
    chooser: SearchPlanner,
    action: SearchAction,
    observation: SearchObservation,
    after: SearchState,
    on_observation: Callable[[Tables], Tables | None] | None,
) -> None:
    """Bring the agent's history, belief and planner up to date after one step."""
    before: GridBelief = agent.belief
    agent.update_history(action, observation)
    updated = before.updated(action, observation, after.robot)
    agent.set_belief(updated)
    chooser.update(agent, action, observation)
    if on_observation is None:
        return
    space = before.space
    told = observation_likelihoods(Detector(space), before.robot, action, observation, after.robot)
    replacing = on_observation(
        {
            name: likelihood.log_table(space.shape)
            for name, likelihood in zip(space.target_ids, told, strict=True)
            if likelihood is not None
        }
    )
    if replacing is not None:
        new = updated.replaced({**updated.tables, **replacing}, after.robot)
        agent.set_belief(new)
        moved = (np.abs(a - b).sum() > 1e-9 for a, b in zip(new.flat, updated.flat, strict=True))
        if any(moved):
            chooser.forget()
