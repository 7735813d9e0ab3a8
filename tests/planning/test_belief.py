from __future__ import annotations

import pickle

import numpy as np
import pytest
from support.small_searches import agent_of, space_of

from sloop_ppl.errors import BeliefCollapse, InputError
from sloop_ppl.planning import (
    GridBelief,
    SearchObservation,
    SearchObservationModel,
    SearchState,
    SearchTransitionModel,
)


def random_belief(space, seed=0, pose=None, looked=True):
    rng = np.random.default_rng(seed)
    tables = {
        t: rng.dirichlet(np.ones(space.n_cells)).reshape(space.shape) for t in space.target_ids
    }
    pose = space.encode(3, 4, 0) if pose is None else pose
    return GridBelief(space, tables, space.robot(pose, looked=looked), rng=rng)


@pytest.mark.parametrize(
    ("index", "find_each"), [*((i, False) for i in range(4)), *((i, True) for i in range(5))]
)
def test_updates_equal_bayes_rule_over_every_joint_state(index, find_each):
    space = space_of((4, 5), ids=("A", "B"), step_cells=1, find_each=find_each)
    belief = random_belief(space, pose=space.encode(1, 1, 0))
    action = space.actions[index]
    transition, observing = SearchTransitionModel(space), SearchObservationModel(space)
    joint: dict[SearchObservation, dict[tuple[int, int], float]] = {}
    robots = {}
    for a in range(space.n_cells):
        for b in range(space.n_cells):
            state = SearchState(belief.robot, (a, b))
            after = transition.sample(state, action)
            observation = observing.sample(after, action)
            joint.setdefault(observation, {})[a, b] = belief[state]
            robots[observation] = after.robot
    assert sum(sum(j.values()) for j in joint.values()) == pytest.approx(1, abs=1e-12)
    for observation, weights in joint.items():
        updated = belief.updated(action, observation, robots[observation])
        total = sum(weights.values())
        for i, table in enumerate(updated.flat):
            marginal = np.zeros(space.n_cells)
            for cells, weight in weights.items():
                marginal[cells[i]] += weight / total
            assert table.sum() == pytest.approx(1, abs=1e-12)
            np.testing.assert_allclose(table, marginal, atol=1e-12)


def test_samples_follow_the_table():
    space = space_of((4, 5), step_cells=1)
    belief = random_belief(space)
    n = 40_000
    counts = np.zeros(space.n_cells)
    for _ in range(n):
        counts[belief.random().cells[0]] += 1
    p = belief.flat[0]
    # Pearson's statistic, 19 degrees of freedom: above 50 with probability 1e-4.
    assert ((counts - n * p) ** 2 / (n * p)).sum() < 50


def test_cells_of_probability_zero_are_never_drawn():
    space = space_of((4, 5), step_cells=1)
    table = np.zeros(space.shape)
    table[2, 3] = 5.0
    belief = GridBelief(space, {"A": table}, space.robot(0), rng=np.random.default_rng(0))
    assert {belief.random().cells for _ in range(1000)} == {(13,)}
    assert belief.mpe().cells == (13,)
    assert belief[belief.mpe()] == 1


def test_an_impossible_observation_collapses_at_once():
    space = space_of()
    table = np.zeros(space.shape)
    table[0, 0] = 1.0
    robot = space.robot(space.encode(3, 4, 0), looked=True)
    belief = GridBelief(space, {"A": table}, robot, rng=np.random.default_rng(0))
    observation = SearchObservation((3 * 9 + 5,), 0)
    after = space.robot(space.encode(3, 4, 0), looked=True)
    with pytest.raises(BeliefCollapse) as error:
        belief.updated(space.actions[1], observation, after)
    assert str(error.value) == (
        "Target 'A' was seen at cell (3, 5), which its belief held impossible; "
        "give a belief that is nowhere zero, or set recovery_weight to mix in the belief of the "
        "start"
    )
    assert error.value.observation == observation
    np.testing.assert_array_equal(error.value.prior, table)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (
            np.ones((3, 3)),
            (
                "The belief of 'A' has shape (3, 3); the map has (7, 9): it was made on another "
                "map or with another cell size"
            ),
        ),
        (
            np.zeros((7, 9)),
            (
                "The belief of 'A' is not a distribution (sum 0, least 0); expected finite numbers "
                ">= 0 that do not all vanish"
            ),
        ),
        (
            np.full((7, 9), np.nan),
            (
                "The belief of 'A' is not a distribution (sum nan, least nan); expected finite "
                "numbers >= 0 that do not all vanish"
            ),
        ),
    ],
)
def test_tables_that_are_no_beliefs_are_refused(table, message):
    space = space_of()
    with pytest.raises(InputError) as error:
        GridBelief(space, {"A": table}, space.robot(0), rng=np.random.default_rng(0))
    assert str(error.value) == message


def test_an_agent_with_its_belief_and_models_can_be_pickled():
    space = space_of()
    agent = agent_of(space, {"A": np.ones(space.shape)}, 0)
    agent.belief.random()
    again = pickle.loads(pickle.dumps(agent))
    assert again.belief.random() == agent.belief.random()
    assert again.belief.robot == agent.belief.robot
    state = again.belief.mpe()
    action = again.valid_actions(state=state)[0]
    assert again.transition_model.sample(state, action).robot == agent.belief.robot.moved(0)
