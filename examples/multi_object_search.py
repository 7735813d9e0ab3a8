"""Put a language belief into pomdp-py's own multi-object search and plan with its own POUCT.

Nothing of `sloop_ppl.planning` is used: domain, models, belief update and planner are those that
come with pomdp-py. Only the histograms it starts from are the posterior's.

    python examples/multi_object_search.py
"""

from __future__ import annotations

import argparse
import random
from dataclasses import dataclass

import numpy as np
import pomdp_py
from pomdp_py.problems.multi_object_search.agent.agent import MosAgent
from pomdp_py.problems.multi_object_search.domain.action import FindAction
from pomdp_py.problems.multi_object_search.domain.state import MosOOState, ObjectState, RobotState
from pomdp_py.problems.multi_object_search.env.env import MosEnvironment
from pomdp_py.problems.multi_object_search.models.components.sensor import Laser2DSensor

import sloop_ppl as sloop
from sloop_ppl.bridge import as_histogram

TEXT = (
    "The green Toyota is behind Velvet Dog, and the red bike is on West 4th Street "
    "in front of the Bolton-Pratt Building."
)
PLACES = {"GreenToyota": (-47.5, -62.5), "RedBike": (57.5, 32.5)}
START = (-10.0, -10.0)
ROBOT = -1
CELL_M = 20.0


@dataclass(frozen=True)
class Result:
    """What came of one search."""

    reward: float
    finds: int
    steps: int
    found: tuple[str, ...]


def main(smoke: bool = False) -> dict[str, Result]:
    """Search once with what was said and once without."""
    city = sloop.load_map("cleveland", cell_m=CELL_M)
    posterior = sloop.infer(sloop.parse(TEXT, city), city)
    informed = {target: posterior.belief(target) for target in posterior.targets}
    uninformed = {target: np.ones(city.grid.shape) for target in informed}
    sims, steps = (60, 12) if smoke else (2000, 60)
    print(f"“{TEXT}”")
    results = {}
    for name, beliefs in (("told", informed), ("not told", uninformed)):
        random.seed(0)
        np.random.seed(0)  # noqa: NPY002 - pomdp-py draws from there
        results[name] = search(city, beliefs, sims, steps)
        print(f"{name}: {results[name]}")
    return results


def search(
    city: sloop.CityMap, beliefs: dict[str, np.ndarray], sims: int, max_steps: int
) -> Result:
    """Search with pomdp-py alone, from histograms over its own states."""
    ids = {target: number for number, target in enumerate(beliefs)}
    height, width = city.grid.shape
    states = {
        number: ObjectState(number, "target", _pose(city, PLACES[target]))
        for target, number in ids.items()
    }
    robot = RobotState(ROBOT, (*_pose(city, START), 0.0), (), None)
    sensor = Laser2DSensor(ROBOT, fov=90, min_range=1, max_range=3, angle_increment=5)
    world = MosEnvironment((width, height), MosOOState({**states, ROBOT: robot}), {ROBOT: sensor})
    agent = MosAgent(ROBOT, robot, set(states), (width, height), sensor, prior={})
    for target, number in ids.items():
        agent.cur_belief.set_object_belief(
            number,
            as_histogram(
                beliefs[target],
                lambda row, col, number=number: ObjectState(number, "target", (col, row)),
            ),
        )
    planner = pomdp_py.POUCT(
        max_depth=10,
        discount_factor=0.95,
        num_sims=sims,
        exploration_const=100,
        rollout_policy=agent.policy_model,
    )
    reward, finds, steps = 0.0, 0, 0
    while steps < max_steps and finds < len(ids) and len(_found(world)) < len(ids):
        action = planner.plan(agent)
        reward += world.state_transition(action, execute=True, robot_id=ROBOT)
        observation = world.provide_observation(agent.observation_model, action)
        agent.update_history(action, observation)
        planner.update(agent, action, observation)
        _learn(agent, action, observation, world.state.object_states[ROBOT], ids.values())
        finds += isinstance(action, FindAction)
        steps += 1
    names = {number: target for target, number in ids.items()}
    return Result(reward, finds, steps, tuple(sorted(names[n] for n in _found(world))))


def _learn(agent, action, observation, robot, numbers) -> None:
    """Update each object's histogram with the domain's own models."""
    for number in numbers:
        agent.cur_belief.set_object_belief(
            number,
            pomdp_py.update_histogram_belief(
                agent.cur_belief.object_belief(number),
                action,
                observation.for_obj(number),
                agent.observation_model[number],
                agent.transition_model[number],
                static_transition=True,
                oargs={"next_robot_state": robot},
            ),
        )
    agent.cur_belief.set_object_belief(ROBOT, pomdp_py.Histogram({robot: 1.0}))


def _pose(city: sloop.CityMap, place_m: tuple[float, float]) -> tuple[int, int]:
    row, col = city.grid.cell_at(*place_m)
    return col, row


def _found(world: MosEnvironment) -> set[int]:
    return set(world.state.object_states[ROBOT].objects_found)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="plan hardly at all, for tests")
    main(parser.parse_args().smoke)
