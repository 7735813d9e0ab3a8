from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from support.small_searches import agent_of, city_of, space_of

from sloop_ppl.planning import SearchConfig, make_planner, run_search

TINY = {"sensor_range_cells": 1.0, "step_cells": 1, "turn_deg": 90, "discount": 0.8, "depth": 25}


def value_iteration(space, prior):
    """Return Q of each root action, by value iteration over (pose, cells ruled out or known).

    Derived here from the rules of the search, not from the package's models: one target, a find
    ends the search, a move shows the target when it is in view and else rules its view out.
    """
    config = space.config
    n_cells, n_poses = space.n_cells, space.n_cells * 8
    view = [sorted(space.view(p)) for p in range(n_poses)]
    nexts = [[space.next_pose(i, p) for i in range(3)] for p in range(n_poses)]

    @cache
    def mass(out, cells):
        left = sum(prior[c] for c in range(n_cells) if not out >> c & 1)
        return sum(prior[c] for c in cells if not out >> c & 1) / left

    seen_value = config.right_find_reward  # once seen, the find is the best there is
    values: dict[tuple[int, int], float] = {}

    def q(pose, out, value, find=True):
        told = []
        for index in range(3):
            after = nexts[pose][index]
            fresh = mass(out, tuple(view[after]))
            new = out
            for c in view[after]:
                new |= 1 << c
            total = config.move_reward
            if fresh > 0:
                total += config.discount * fresh * seen_value
            if fresh < 1 - 1e-12:
                total += config.discount * (1 - fresh) * value(after, new)
            told.append(total)
        if find:
            here = mass(out, tuple(view[pose]))
            told.append(here * config.right_find_reward + (1 - here) * config.wrong_find_reward)
        return told

    for _ in range(60):
        fresh = {}

        def value(pose, out, fresh=fresh):
            fresh.setdefault((pose, out), values.get((pose, out), 0.0))
            return values.get((pose, out), 0.0)

        updated = {key: max(q(*key, value)) for key in list(values)}
        q(0, 0, value)
        for key, guess in fresh.items():
            updated.setdefault(key, guess)
        values.update(updated)
    return q(0, 0, lambda pose, out: values[pose, out], find=False)


@pytest.mark.parametrize(
    ("planner", "rollout"),
    [
        ("pouct", "published"),
        ("pouct", "random"),
        ("fast", "published"),
        ("fast", "random"),
        ("fast", "informed"),
    ],
)
def test_planners_agree_with_value_iteration_on_a_small_map(planner, rollout):
    prior = np.array([0.05, 0.05, 0.1, 0.3, 0.1, 0.4])
    space = space_of((2, 3), **TINY, sims=20_000, exploration=1000.0, rollout=rollout)
    exact = value_iteration(space, prior)
    agent = agent_of(space, {"A": prior.reshape(2, 3)}, pose=0, looked=False)
    action, info = make_planner(planner, space, rng=np.random.default_rng(0)).plan(agent)
    assert action.index == int(np.argmax(exact))
    assert info.sims == 20_000 or (rollout == "informed" and info.sims < 20_000)
    assert info.values[action.name] == pytest.approx(max(exact), abs=40)


def test_pomcp_refills_its_particles_and_says_so():
    infos = []
    run_search(
        {"A": np.ones((9, 11))},
        city_of(9, 11),
        {"A": (31.0, 22.0)},
        planner="pomcp",
        config=SearchConfig(sims=80, max_steps=8),
        start=(3.0, 3.0),
        rng=np.random.default_rng(0),
        on_step=lambda step: infos.append(step.info),
    )
    assert infos[0].notes == {"particles_kept": 0, "particles_drawn": 80}
    assert infos[1].notes["particles_kept"] > 0
    for info in infos[1:]:
        assert info.notes["particles_kept"] + info.notes["particles_drawn"] == 80


def test_pouct_goes_on_with_the_tree_it_has_and_forgets_it_when_told():
    space = space_of((9, 11), sims=200)
    agent = agent_of(space, {"A": np.ones((9, 11))}, pose=0)
    planner = make_planner("pouct", space, rng=np.random.default_rng(0))
    action, info = planner.plan(agent)
    assert sum(info.visits.values()) == 199  # the first simulation makes the root
    observation = agent.observation_model.sample(
        agent.transition_model.sample(agent.belief.mpe(), action), action
    )
    agent.update_history(action, observation)
    planner.update(agent, action, observation)
    _, info = planner.plan(agent)
    assert sum(info.visits.values()) > 200
    planner.forget()
    _, info = planner.plan(agent)
    assert sum(info.visits.values()) == 199
