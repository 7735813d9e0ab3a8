"""Moves: what they do exactly, how they slip, and that planners reckon with their slips."""

from __future__ import annotations

import math
import random
from functools import cache

import numpy as np
import pytest
from support.small_searches import agent_of, city_of

from sloop_ppl.errors import InputError
from sloop_ppl.planning import (
    ExactMotion,
    GridEnvironment,
    Motion,
    Pose,
    SearchConfig,
    SearchSpace,
    SearchState,
    SlippingMotion,
    make_planner,
    run_search,
)
from sloop_ppl.planning.motion import MOVES, move_table

SLIPS = {"stay_rate": 0.2, "overshoot_rate": 0.3, "overturn_rate": 0.1}


class Wading:
    """A user's motion without `outcomes`: a quarter of the moves does nothing."""

    def sample(self, pose, action, rng):
        if rng.random() < 0.25:
            return pose
        return ExactMotion(5.0, 1).sample(pose, action, rng)

    def log_probability(self, next_pose, pose, action):
        moved = ExactMotion(5.0, 1).log_probability(next_pose, pose, action)
        return math.log(0.75 * math.exp(moved) + 0.25 * (next_pose == pose))


def slipping_space(shape=(3, 5), tall=None, no_fly=False, **rates):
    config = SearchConfig(no_fly=no_fly, sensor_range_cells=1)
    motion = SlippingMotion(5.0, 1, 90, **(rates or SLIPS))
    return SearchSpace(shape, ("A",), config, tall, motion=motion)


@pytest.mark.parametrize(
    ("step_cells", "straight", "diagonal"), [(3, 15.0, 10.0), (2, 10.0, 5.0), (1, 5.0, 5.0)]
)
def test_a_step_is_that_of_the_paper_at_each_of_the_eight_headings(step_cells, straight, diagonal):
    motion, s, d = ExactMotion(5.0, step_cells), straight, diagonal
    east_north = [(s, 0), (d, d), (0, s), (-d, d), (-s, 0), (-d, -d), (0, -s), (d, -d)]
    for eighth, (east, north) in enumerate(east_north):
        pose = Pose(7.0, -3.0, eighth * math.pi / 4)
        after = motion.sample(pose, "forward", rng=None)  # nothing is drawn
        assert after == pytest.approx((7.0 + east, -3.0 + north, pose.heading_rad))
        assert motion.log_probability(after, pose, "forward") == 0
        assert motion.log_probability(pose, pose, "forward") == -math.inf


@pytest.mark.parametrize(
    ("heading_deg", "length"), [(20, 15.0), (50, math.hypot(10, 10)), (-100, 15.0), (365, 15.0)]
)
def test_between_two_headings_a_step_goes_where_the_robot_faces(heading_deg, length):
    angle = math.radians(heading_deg)
    after = ExactMotion().sample(Pose(0.0, 0.0, angle), "forward", None)
    assert after[:2] == pytest.approx((length * math.cos(angle), length * math.sin(angle)))


def test_turns_go_either_way_and_come_round():
    motion = ExactMotion(turn_deg=90)
    assert motion.sample(Pose(1.0, 2.0, 0.0), "left", None) == (1.0, 2.0, math.pi / 2)
    assert motion.sample(Pose(1.0, 2.0, 0.0), "right", None) == (1.0, 2.0, 3 * math.pi / 2)
    off = motion.sample(Pose(1.0, 2.0, math.radians(350)), "left", None)
    assert off.heading_deg == pytest.approx(80)
    assert motion.log_probability(Pose(1.0, 2.0, -math.pi / 2), Pose(1.0, 2.0), "right") == 0
    with pytest.raises(InputError) as error:
        motion.sample(Pose(0.0, 0.0), "back", None)
    assert str(error.value) == "'back' is no move; expected one of: forward, left, right"


@pytest.mark.parametrize("action", MOVES)
def test_slips_sum_to_one_and_are_drawn_as_often_as_they_say(action):
    motion, pose, n = SlippingMotion(5.0, 3, 45, **SLIPS), Pose(1.0, 2.0, math.pi / 4), 5000
    outcomes = {after: chance for chance, after in motion.outcomes(pose, action)}
    assert sum(outcomes.values()) == pytest.approx(1)
    rng, counts = np.random.default_rng(4), dict.fromkeys(outcomes, 0)
    for _ in range(n):
        counts[motion.sample(pose, action, rng)] += 1
    for after, chance in outcomes.items():
        assert motion.log_probability(after, pose, action) == pytest.approx(math.log(chance))
        # nine comparisons at 4.5 standard deviations: one test in 16 000 fails by chance
        assert abs(counts[after] / n - chance) < 4.5 * math.sqrt(chance * (1 - chance) / n)


def test_slips_are_to_stay_to_go_one_cell_further_and_to_turn_twice_as_far():
    motion, pose = SlippingMotion(5.0, 3, 45, **SLIPS), Pose(0.0, 0.0, math.pi / 2)
    forward = {after: chance for chance, after in motion.outcomes(pose, "forward")}
    assert {(round(x), round(y)): c for (x, y, _), c in forward.items()} == pytest.approx(
        {(0, 15): 0.5, (0, 0): 0.2, (0, 20): 0.3}
    )
    left = {round(after.heading_deg): c for c, after in motion.outcomes(pose, "left")}
    assert left == pytest.approx({135: 0.7, 90: 0.2, 180: 0.1})
    about = SlippingMotion(5.0, 3, 180, stay_rate=0.1, overturn_rate=0.2)  # 360 degrees stay, too
    assert math.exp(about.log_probability(pose, pose, "left")) == pytest.approx(0.3)


def test_the_table_of_moves_is_exact_where_the_outcomes_are_known():
    table = move_table(SlippingMotion(5.0, 1, 45, **SLIPS), 5.0)
    assert (table.exact, table.stochastic, table.offsets.shape) == (True, True, (3, 8, 3, 3))
    assert table.chance[0, 2].tolist() == pytest.approx([0.5, 0.3, 0.2])
    # north-east, a step of one cell and of two are round(0.7) and round(1.4): one cell, added up
    assert table.chance[0, 1].tolist() == pytest.approx([0.8, 0.2, 0.0])
    assert table.offsets[0, 2].tolist() == [[1, 0, 0], [2, 0, 0], [0, 0, 0]]
    assert table.offsets[2, 5].tolist() == [[0, 0, 7], [0, 0, 0], [0, 0, 6]]
    assert not move_table(ExactMotion(), 5.0).stochastic


def test_the_table_of_a_motion_that_only_draws_is_estimated_and_the_same_each_time():
    assert isinstance(Wading(), Motion)
    table, again = move_table(Wading(), 5.0), move_table(Wading(), 5.0)
    assert not table.exact
    assert table.offsets[0, 0].tolist() == [[0, 1, 0], [0, 0, 0]]
    np.testing.assert_allclose(table.chance.sum(axis=2), 1)
    # 24 shares of 1000 draws at 4.5 standard deviations: one test in 6000 fails by chance
    assert np.abs(table.chance[:, :, 0] - 0.75).max() < 4.5 * math.sqrt(0.75 * 0.25 / 1000)
    assert table.chance.tobytes() == again.chance.tobytes()


def test_off_the_map_and_into_a_building_an_outcome_leaves_the_pose():
    tall = np.zeros((3, 5), dtype=bool)
    tall[1, 4] = True
    space = slipping_space(tall=tall, no_fly=True)
    edge, wall = space.encode(2, 3, 0), space.encode(1, 2, 0)
    on, beyond = space.encode(2, 4, 0), space.encode(1, 3, 0)
    assert space.outcomes(0, edge) == ((0.5, on, False), (0.3, edge, False), (0.2, edge, False))
    assert space.outcomes(0, wall) == ((0.5, beyond, False), (0.3, wall, True), (0.2, wall, False))


def test_states_follow_as_often_as_the_transition_model_says():
    space, n = slipping_space(), 4000
    agent = agent_of(space, {"A": np.ones((3, 5))}, pose=0)
    state = SearchState(space.robot(space.encode(1, 3, 0), looked=True), (7,))
    for action in space.moves:
        counts: dict[SearchState, int] = {}
        for _ in range(n):
            after = agent.transition_model.sample(state, action)
            counts[after] = counts.get(after, 0) + 1
        chances = {s: agent.transition_model.probability(s, state, action) for s in counts}
        assert sum(chances.values()) == pytest.approx(1)
        for after, chance in chances.items():
            # eight shares at 4.5 standard deviations: one test in 18 000 fails by chance
            assert abs(counts[after] / n - chance) < 4.5 * math.sqrt(chance * (1 - chance) / n)
        elsewhere = SearchState(space.robot(0, looked=True), (7,))
        assert agent.transition_model.probability(elsewhere, state, action) == 0


def test_the_environment_moves_by_the_motion_and_stops_where_the_map_ends():
    space, n = slipping_space(), 2000
    rng, counts = np.random.default_rng(5), {}
    for _ in range(n):
        at = space.pose_at(space.encode(1, 3, 0))
        environment = GridEnvironment(space, {"A": (2.0, 2.0)}, at, rng=rng)
        pose, _, collision = environment.execute(space.actions[0])
        assert not collision
        counts[pose] = counts.get(pose, 0) + 1
    assert set(counts) == {at, space.pose_at(space.encode(1, 4, 0))}
    # one share at 4.5 standard deviations: one test in 147 000 fails by chance
    assert abs(counts[at] / n - 0.5) < 4.5 * math.sqrt(0.25 / n)


PRIOR = np.array([0.05, 0.05, 0.1, 0.3, 0.1, 0.4])


def exact_values(stay, further, prior=PRIOR, discount=0.5, depth=12):
    """Return the value of each first move on 2 x 3 cells, derived from the rules alone.

    The robot starts in the south-west, looks at the one cell ahead of it, goes a cell or turns by
    90 degrees; with `stay` it does neither, with `further` twice as much. Once seen, the target is
    found, which ends the search; a find of what was not seen is wrong for sure.
    """
    ahead = {0: (0, 1), 2: (1, 0), 4: (0, -1), 6: (-1, 0)}

    def after(row, col, heading, action, amount):
        if action:
            return row, col, (heading + (2 if action == 1 else -2) * amount) % 8
        r, c = row + ahead[heading][0] * amount, col + ahead[heading][1] * amount
        return (r, c, heading) if 0 <= r < 2 and 0 <= c < 3 else (row, col, heading)

    @cache
    def value(pose, ruled_out, left):
        return max(of_moves(pose, ruled_out, left)) if left else 0.0

    def of_moves(pose, ruled_out, left):
        alive = sum(p for cell, p in enumerate(prior) if cell not in ruled_out)
        told = []
        for action in range(3):
            total = -10.0
            for chance, amount in ((1 - stay - further, 1), (stay, 0), (further, 2)):
                if not chance:
                    continue
                row, col, heading = new = after(*pose, action, amount)
                r, c = row + ahead[heading][0], col + ahead[heading][1]
                view = {r * 3 + c} if 0 <= r < 2 and 0 <= c < 3 else set()
                hit = sum(prior[cell] for cell in view - ruled_out) / alive
                total += chance * discount * hit * (1000.0 if left > 1 else 0.0)
                if hit < 1 - 1e-12:
                    rest = value(new, ruled_out | frozenset(view), left - 1)
                    total += chance * discount * (1 - hit) * rest
            told.append(total)
        return told

    return of_moves((0, 0, 0), frozenset(), depth)


@pytest.mark.parametrize(("stay", "further"), [(0.0, 0.0), (0.3, 0.0), (0.1, 0.3), (0.0, 0.6)])
def test_pouct_agrees_with_value_iteration_when_moves_slip(stay, further):
    rates = {"stay_rate": stay, "overshoot_rate": further, "overturn_rate": further}
    config = SearchConfig(
        sensor_range_cells=1, discount=0.5, depth=12, sims=12_000, exploration=300.0
    )
    motion = SlippingMotion(5.0, 1, 90, **rates)
    space = SearchSpace((2, 3), ("A",), config, motion=motion)
    agent = agent_of(space, {"A": PRIOR.reshape(2, 3)}, pose=0, looked=False)
    exact = exact_values(stay, further)
    action, info = make_planner("pouct", space, rng=np.random.default_rng(0)).plan(agent)
    assert action.index == int(np.argmax(exact))
    # 174, 134, 117 and 81; what few simulations miss makes the search's own a little lower
    assert info.values[action.name] == pytest.approx(max(exact), abs=15)


def test_a_motion_may_stay_half_the_time():
    motion = SlippingMotion(stay_rate=0.5)
    assert [chance for chance, _ in motion.outcomes(Pose(0.0, 0.0), "left")] == [0.5, 0.5]


def test_slips_of_the_settings_and_of_a_motion_are_one_search():
    beliefs, city, place = {"A": np.ones((5, 6))}, city_of(5, 6), {"A": (22.0, 17.0)}
    settings = {"max_steps": 12, "sims": 40}
    told = []
    for given in (
        {"config": SearchConfig(**settings, **SLIPS)},
        {"config": SearchConfig(**settings), "motion": SlippingMotion(**SLIPS)},
    ):
        rng = np.random.default_rng(2)
        told.append(run_search(beliefs, city, place, planner="pouct", rng=rng, **given))
    assert told[0].actions == told[1].actions
    assert told[0].poses == told[1].poses


@pytest.mark.parametrize("planner", ["pouct", "pomcp", "fast", "greedy", "random"])
@pytest.mark.parametrize("motion", [SlippingMotion(5.0, 1, **SLIPS), Wading()])
def test_every_planner_searches_with_moves_that_slip(planner, motion):
    table = np.full((4, 5), 0.01)
    table[3, 4] = 1.0
    episode = run_search(
        {"A": table},
        city_of(4, 5),
        {"A": (22.0, 17.0)},
        planner=planner,
        motion=motion,
        config=SearchConfig(sims=60, max_steps=60, sensor_range_cells=2),
        start=(3.0, 3.0),
        rng=np.random.default_rng(1),
    )
    assert planner == "random" or episode.found
    assert len({(p.x_m, p.y_m) for p in episode.poses}) > 1


class Leaking(SlippingMotion):
    def outcomes(self, pose, action):
        return ((0.9, pose),)


class Surer(SlippingMotion):
    def outcomes(self, pose, action):
        return (1.5, pose), (-0.5, pose)


class Single(SlippingMotion):
    def outcomes(self, pose, action):
        return 1.0, 0


class Lost(Wading):
    def sample(self, pose, action, rng):
        return (pose[0], math.nan, pose[2])


def moving(motion, **settings):
    return SearchSpace((7, 9), ("A",), SearchConfig(**settings), motion=motion)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: SlippingMotion(stay_rate=0.5, overshoot_rate=0.5),
            (
                "overshoot_rate is 0.5 and stay_rate 0.5; expected numbers in [0, 1) that sum to "
                "less than 1"
            ),
        ),
        (
            lambda: SlippingMotion(stay_rate=-0.1),
            (
                "overshoot_rate is 0 and stay_rate -0.1; expected numbers in [0, 1) that sum to "
                "less than 1"
            ),
        ),
        (
            lambda: moving(Leaking()),
            "The outcomes of 'forward' have probabilities that sum to 0.9; expected 1",
        ),
        (
            lambda: moving(Surer()),
            "An outcome of 'forward' has probability 1.5; expected a number in [0, 1]",
        ),
        (
            lambda: moving(Single()),
            ("The outcomes of 'forward' are (1.0, 0); expected pairs of probability and pose"),
        ),
        (
            lambda: moving(Lost()),
            (
                "The pose after 'forward' is (0.0, nan, 0.0); expected (x_m, y_m, heading_rad) "
                "as three finite numbers"
            ),
        ),
        (
            lambda: moving(Wading(), step_cells=2),
            (
                "step_cells is 2, but the motion is a Wading, which has its own; leave step_cells "
                "out, or the motion"
            ),
        ),
        (
            lambda: moving("sideways"),
            (
                "The motion is a str; expected an object with the methods "
                "sample(pose, action, rng) and log_probability(next_pose, pose, action), such as "
                "a SlippingMotion"
            ),
        ),
    ],
)
def test_motions_that_are_none_are_refused_in_one_line(make, message):
    with pytest.raises(InputError) as error:
        make()
    assert str(error.value) == message


def test_draws_of_the_same_seed_slip_alike():
    motion, pose = SlippingMotion(**SLIPS), Pose(0.0, 0.0)
    told = [
        [motion.sample(pose, "forward", rng) for _ in range(20)]
        for rng in (random.Random(3), random.Random(3))
    ]
    assert told[0] == told[1]
    assert len(set(told[0])) == 3
