from __future__ import annotations

import random

import numpy as np
import pytest
from support.small_searches import space_of

from sloop_ppl.errors import BeliefCollapse
from sloop_ppl.planning import (
    GridBelief,
    SearchObservation,
    SearchObservationModel,
    SearchState,
)

NOISE = [
    {"true_positive_rate": 0.8},
    {"false_positive_rate": 0.1},
    {"true_positive_rate": 0.7, "false_positive_rate": 0.2, "position_noise_cells": 0.8},
]


def every_observation(space):
    return [SearchObservation((cell,), 0) for cell in range(-1, space.n_cells)]


@pytest.mark.parametrize("noise", NOISE)
@pytest.mark.parametrize("pose", [(1, 1, 0), (0, 4, 0), (3, 0, 1)])
def test_probabilities_of_all_observations_sum_to_one_and_make_bayes_rule(noise, pose):
    space = space_of((4, 5), step_cells=1, **noise)
    prior = np.random.default_rng(0).dirichlet(np.ones(20)).reshape(4, 5)
    robot = space.robot(space.encode(*pose), looked=True)
    belief = GridBelief(space, {"A": prior}, robot, rng=np.random.default_rng(0))
    model, left = SearchObservationModel(space), space.actions[1]
    chances = np.array(
        [
            [model.probability(o, SearchState(robot, (c,)), left) for c in range(20)]
            for o in every_observation(space)
        ]
    )
    np.testing.assert_allclose(chances.sum(axis=0), 1, atol=1e-12)
    for observation, chance in zip(every_observation(space), chances, strict=True):
        expected = chance * prior.ravel()
        if expected.sum() == 0:
            continue
        updated = belief.updated(left, observation, robot)
        np.testing.assert_allclose(updated.flat[0], expected / expected.sum(), atol=1e-12)


@pytest.mark.parametrize("noise", NOISE)
def test_samples_follow_the_probabilities(noise):
    space = space_of((4, 5), step_cells=1, **noise)
    robot = space.robot(space.encode(1, 1, 0), looked=True)
    model = SearchObservationModel(space, random.Random(0))
    n, left = 20_000, space.actions[1]
    for cell in (7, 19):
        state = SearchState(robot, (cell,))
        drawn = [model.sample(state, left) for _ in range(n)]
        for observation in every_observation(space):
            p = model.probability(observation, state, left)
            share = drawn.count(observation) / n
            # Five standard deviations: fails with probability below 1e-4 over all cases.
            assert abs(share - p) <= 5 * np.sqrt(p * (1 - p) / n)


def test_what_is_seen_out_of_view_is_impossible():
    space = space_of((4, 5), step_cells=1, false_positive_rate=0.1)
    robot = space.robot(space.encode(1, 1, 0), looked=True)
    belief = GridBelief(space, {"A": np.ones((4, 5))}, robot, rng=np.random.default_rng(0))
    with pytest.raises(BeliefCollapse, match=r"'A' was seen at cell \(3, 0\)"):
        belief.updated(space.actions[1], SearchObservation((15,), 0), robot)


def test_a_collapse_is_recovered_with_the_initial_belief_where_asked():
    space = space_of((4, 5), step_cells=1, recovery_weight=0.1)
    robot = space.robot(space.encode(1, 1, 0), looked=True)
    belief = GridBelief(space, {"A": np.ones((4, 5))}, robot, rng=np.random.default_rng(0))
    nothing, found = SearchObservation((-1,), 0), SearchObservation((7,), 0)
    belief = belief.updated(space.actions[1], nothing, robot)
    assert belief.flat[0][7] == 0
    again = belief.updated(space.actions[1], found, robot)
    assert again.flat[0][7] == 1
