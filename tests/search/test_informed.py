from __future__ import annotations

import numpy as np
import pytest
from support.small_searches import agent_of, city_of, space_of

from sloop_ppl.search import SearchConfig, SearchObservation, make_planner, run_search
from sloop_ppl.search.goals import flood
from sloop_ppl.search.hindsight import STRETCH, _counted, _estimated, hindsight_bounds
from sloop_ppl.search.informed import InformedPlanner
from sloop_ppl.search.pose_tables import reach_from


def expected_return(planner, belief, pose, steps=60):
    """Return what a planner earns on average over the belief, along the path that sees nothing."""
    space = space_of(belief.shape, sims=300)
    agent = agent_of(space, {"A": belief}, pose, looked=False)
    chooser = make_planner(planner, space, rng=np.random.default_rng(0))
    left, total, table = 1.0, 0.0, belief.ravel() / belief.sum()
    nothing = SearchObservation((-1,), 0)
    for step in range(steps):
        action, _ = chooser.plan(agent)
        robot = agent.belief.robot.moved(action.index)
        view = list(robot.view)
        total += 0.95**step * -10 * left + 0.95 ** (step + 1) * 1000 * table[view].sum()
        left -= table[view].sum()
        table[view] = 0.0
        if left < 1e-3:
            break
        agent.set_belief(agent.belief.updated(action, nothing, robot))
        agent.update_history(action, nothing)
        chooser.update(agent, action, nothing)
    return total


def test_looking_ahead_beats_greed_on_average():
    rng = np.random.default_rng(0)
    gaps = []
    for _ in range(6):
        belief = rng.dirichlet(np.full(15 * 15, 0.05)).reshape(15, 15)
        pose = int(rng.integers(15 * 15 * 8))
        returns = [expected_return(p, belief, pose) for p in ("fast", "greedy")]
        gaps.append(returns[0] - returns[1])
    assert np.mean(gaps) > 10


def test_two_heaps_of_belief_are_taken_in_the_order_that_pays():
    """A little on the way to a lot: greed passes by it, foresight does not lose by a look."""
    belief = np.full((9, 40), 1e-6)
    belief[4, 34], belief[4, 3] = 0.7, 0.3
    space = space_of((9, 40), sims=500)
    agent = agent_of(space, {"A": belief}, space.encode(4, 8, 2), looked=True)
    action, info = make_planner("fast", space, rng=np.random.default_rng(0)).plan(agent)
    assert action.name == "left"
    assert info.values["left"] > info.values["right"]


def test_it_is_deterministic_and_keeps_its_plan():
    space = space_of((15, 15), sims=200)
    belief = np.random.default_rng(3).dirichlet(np.full(225, 0.1)).reshape(15, 15)
    told = []
    for seed in (0, 1):
        agent = agent_of(space, {"A": belief}, 800, looked=True, seed=seed)
        action, info = make_planner("fast", space, rng=np.random.default_rng(seed)).plan(agent)
        told.append((action, dict(info.values), info.notes))
    assert told[0] == told[1]


@pytest.mark.parametrize("settings", [{"turn_deg": 90}, {"no_fly": True}])
def test_moves_to_a_goal_are_those_of_breadth_first_search(settings):
    walls = np.random.default_rng(1).random((9, 11)) < 0.1
    plain = space_of((9, 11), **settings)
    space = type(plain)((9, 11), ("A",), plain.config, walls)
    planner = InformedPlanner(space)
    nexts = planner._ground.nexts
    field = np.empty(9 * 11 * 8, dtype=np.int16)
    flood(planner._ground, 400, field, planner._queue)
    assert field[400] == 0
    for pose in range(0, len(field), 7):
        if pose != 400:
            assert field[pose] == reach_from(pose, nexts).steps[400]


def test_who_knows_where_the_target_is_earns_what_the_moves_leave():
    space = space_of((9, 11))
    counted = _counted(space, (17, 21))
    bounds = hindsight_bounds(space)
    east, here = 0, (8, 10)
    assert counted[east][here[0], here[1] + 3] == 0  # in view
    assert counted[east][here[0], here[1] + 6] == 1  # one step
    assert counted[east][here[0] + 3, here[1]] == 1  # one turn
    assert counted[east][here[0], here[1] - 3] == 3  # three turns of 45 degrees, range 3
    assert bounds[0][here[0], here[1] + 3] == 1000
    once = 0.95**STRETCH
    assert bounds[0][here[0], here[1] + 6] == pytest.approx(once * 1000 - 10 * (1 - once) / 0.05)
    guessed = _estimated(space, (17, 21))
    assert np.abs(guessed - counted).mean() < 1.5


@pytest.mark.parametrize("noise", [{"true_positive_rate": 0.7}, {"false_positive_rate": 0.05}])
def test_a_noisy_sensor_is_believed_as_far_as_it_deserves(noise):
    config = SearchConfig(sims=100, **noise)
    found = [
        run_search(
            {"A": np.ones((15, 15))},
            city_of(15, 15),
            {"A": (41.0, 22.0)},
            planner="fast",
            config=config,
            rng=np.random.default_rng(seed),
        ).found
        for seed in range(12)
    ]
    # A find is taken when the belief in view is above one half, in truth mostly far above.
    assert sum(found) >= 8
