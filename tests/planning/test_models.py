from __future__ import annotations

import pickle
import random

import pytest
from support.small_searches import space_of

from sloop_ppl.planning import (
    PublishedRollout,
    SearchObservation,
    SearchObservationModel,
    SearchPolicyModel,
    SearchRewardModel,
    SearchState,
    SearchTransitionModel,
)

FORWARD, LEFT, RIGHT, FIND = range(4)


def step(space, state, index):
    action = space.actions[index]
    after = SearchTransitionModel(space).sample(state, action)
    observation = SearchObservationModel(space).sample(after, action)
    return after, observation, SearchRewardModel(space).sample(state, action, after)


def test_find_marks_every_unfound_target_in_view_and_earns_once():
    space = space_of(ids=("A", "B", "C"))
    in_view, out = 3 * 9 + 5, 0
    robot = space.robot(space.encode(3, 4, 0), looked=True)
    after, observation, reward = step(space, SearchState(robot, (in_view, in_view, out)), FIND)
    assert (after.robot.found, after.robot.finds, reward) == (0b011, 1, 1000)
    assert observation == SearchObservation((-1, -1, -1), 0b011)
    again, _, reward = step(space, after, FIND)
    assert (again.robot.found, again.robot.finds, reward) == (0b011, 2, -1000)


def test_find_of_one_target_leaves_the_others():
    space = space_of(ids=("A", "B"), find_each=True)
    robot = space.robot(space.encode(3, 4, 0), looked=True)
    state = SearchState(robot, (3 * 9 + 5, 3 * 9 + 5))
    after, _, reward = step(space, state, 4)
    assert (after.robot.found, reward) == (0b10, 1000)


def test_find_counts_only_after_a_look():
    space = space_of()
    state = SearchState(space.robot(space.encode(3, 4, 0)), (3 * 9 + 5,))
    policy = SearchPolicyModel(space, random.Random(0))
    assert policy.get_all_actions(state) == space.moves
    after, _, reward = step(space, state, FIND)
    assert (after.robot.found, reward) == (0, -1000)
    looked, _, _ = step(space, state, LEFT)
    assert policy.get_all_actions(looked) == space.actions


def test_a_move_senses_and_a_find_does_not():
    space = space_of()
    state = SearchState(space.robot(space.encode(3, 4, 1)), (3 * 9 + 5,))
    after, observation, reward = step(space, state, RIGHT)
    assert observation == SearchObservation((3 * 9 + 5,), 0)
    assert (after.robot.heading, reward) == (0, -10)


def test_a_found_target_is_not_reported_again():
    space = space_of(ids=("A", "B"))
    robot = space.robot(space.encode(3, 4, 1), found=1, finds=1, looked=True)
    _, observation, _ = step(space, SearchState(robot, (3 * 9 + 5, 3 * 9 + 6)), RIGHT)
    assert observation.seen == (-1, 3 * 9 + 6)


@pytest.mark.parametrize("index", range(4))
def test_nothing_happens_and_nothing_is_earned_once_it_is_over(index):
    space = space_of()
    state = SearchState(space.robot(0, found=0, finds=1, looked=True), (5,))
    after, observation, reward = step(space, state, index)
    assert after == state
    assert reward == 0
    assert not observation.any or index < 3


def test_states_are_object_oriented_and_immutable():
    space = space_of(ids=("A", "B"))
    robot = space.robot(space.encode(3, 4, 1))
    state = SearchState(robot, (5, 62))
    assert state.s("A").attributes["cell"] == (0, 5)
    assert state.get_object_attribute("B", "cell") == (6, 8)
    assert state.get_object_class("robot") == "robot"
    assert state.s("robot")["cell"] == (3, 4)
    with pytest.raises(AttributeError, match="SearchState is immutable; make a new one"):
        state.cells = (0, 0)
    with pytest.raises(AttributeError, match="RobotState is immutable"):
        robot["cell"] = (0, 0)
    with pytest.raises(AttributeError, match="SearchAction is immutable"):
        space.actions[0].index = 3


def test_values_that_are_equal_hash_alike_also_after_pickling():
    space = space_of(ids=("A", "B"))
    state = SearchState(space.robot(space.encode(3, 4, 1)), (5, 62))
    other = pickle.loads(pickle.dumps(state))
    assert other == state
    assert hash(other) == hash(state)
    assert other != SearchState(space.robot(space.encode(3, 4, 2)), (5, 62))
    seen = SearchObservation((-1, 4), 0b10)
    assert pickle.loads(pickle.dumps(seen)) == seen
    assert seen != SearchObservation((-1, 4), 0)
    for action in space.actions:
        assert pickle.loads(pickle.dumps(action)) == action


def test_models_give_probability_one_to_what_they_sample():
    space = space_of()
    state = SearchState(space.robot(space.encode(3, 4, 1)), (3 * 9 + 5,))
    transition, observing = SearchTransitionModel(space), SearchObservationModel(space)
    for action in space.actions:
        after = transition.sample(state, action)
        assert transition.probability(after, state, action) == 1
        assert transition.probability(SearchState(space.robot(0), (1,)), state, action) == 0
        observation = observing.sample(after, action)
        assert observing.probability(observation, after, action) == 1


def test_the_published_rollout_finds_what_it_saw_and_else_goes_near():
    space = space_of((41, 41))
    rollout = PublishedRollout(space, random.Random(0))
    robot = space.robot(space.encode(20, 20, 0), looked=True)
    ahead = SearchState(robot, (20 * 41 + 35,))
    assert {rollout.rollout(ahead, ()).name for _ in range(50)} == {"forward"}
    seen = SearchObservation((20 * 41 + 22,), 0)
    assert rollout.rollout(ahead, ((space.actions[0], seen),)).name == "find"
    left = SearchState(robot, (35 * 41 + 20,))
    assert {rollout.rollout(left, ()).name for _ in range(50)} == {"left"}
    diagonal = SearchState(robot, (30 * 41 + 30,))
    assert {rollout.rollout(diagonal, ()).name for _ in range(50)} == {"forward", "left"}
