"""Environments from outside: beliefs follow what they report, and what is wrong is one line."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.small_searches import city_of

from sloop_ppl.errors import BeliefCollapse, InputError, OutsideMap
from sloop_ppl.planning import (
    Environment,
    ExactMotion,
    FanSensor,
    GridBelief,
    GridEnvironment,
    Outcome,
    Pose,
    Report,
    SearchConfig,
    SearchSpace,
    run_search,
)
from sloop_ppl.planning.baselines import find_value
from sloop_ppl.planning.environment import observation_of

SHAPE = (9, 11)
CITY = city_of(*SHAPE)
PLANNERS = ("pouct", "pomcp", "fast", "greedy", "random")


class Drifting:
    """A robot that ends up 1.3 m further east and turned by 0.1 rad more, each time it moves."""

    def __init__(self, place=(31.0, 22.0), plain=False):
        self.pose = Pose(4.0, 21.0, 0.2)
        self.place, self.plain = place, plain
        self.fan = FanSensor(CITY.grid)
        self.told = [self.pose]

    def execute(self, action):
        seen, found = None, ()
        in_view = self.fan.view(self.pose)[CITY.grid.cell_covering(*self.place)]
        if action.name == "find":
            found = ("A",) if in_view else ()
        else:
            moved = ExactMotion().sample(self.pose, action.name, None)
            x, heading = min(moved.x_m + 1.3, 54.0), moved.heading_rad + 0.1
            self.pose = Pose(max(x, 0.0), min(max(moved.y_m, 0.0), 44.0), heading)
            if self.fan.view(self.pose)[CITY.grid.cell_covering(*self.place)]:
                seen = self.place
        self.told.append(self.pose)
        if self.plain and not found:
            return tuple(self.pose), {"A": seen}, False
        return Outcome(self.pose, Report({"A": seen}, found))


class Scripted:
    """An environment that answers every action with the same words."""

    def __init__(self, answer, pose=(27.5, 21.5, 0.0)):
        self.answer, self.pose = answer, pose

    def execute(self, action):
        return self.answer(action) if callable(self.answer) else self.answer


class Only:
    """A planner that takes one action again and again."""

    def __init__(self, action="left"):
        self.action = action

    def plan(self, agent):
        return self.action


def search(environment, planner="greedy", **options):
    options.setdefault("config", SearchConfig(sims=60, max_steps=40))
    beliefs = options.pop("beliefs", {"A": np.ones(SHAPE)})
    rng = np.random.default_rng(0)
    options = {"planner": planner, "environment": environment, "rng": rng, **options}
    return run_search(beliefs, CITY, **options)


def test_the_simulated_grid_and_a_users_class_are_environments():
    space = SearchSpace(CITY.grid, ("A",), SearchConfig())
    at, rng = Pose(4.0, 21.0), np.random.default_rng(0)
    grid = GridEnvironment(space, {"A": (31.0, 22.0)}, at, rng=rng)
    assert isinstance(grid, Environment)
    assert isinstance(Drifting(), Environment)
    assert search(grid).found


@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize("plain", [False, True])
def test_beliefs_follow_the_pose_that_is_reported(planner, plain):
    environment, steps = Drifting(plain=plain), []
    episode = search(environment, planner, on_step=steps.append)
    assert list(episode.poses) == environment.told
    assert all(isinstance(pose, Pose) for pose in episode.poses)
    belief = np.full(SHAPE, 1 / 99)
    for step in steps:
        view = environment.fan.view(step.pose)
        np.testing.assert_array_equal(step.view, view)
        if step.action == "find":
            belief = belief * (view if step.found_targets else ~view)
        elif step.observation["A"] is None:
            belief = belief * ~view
        else:
            belief = np.zeros(SHAPE)
            belief[CITY.grid.cell_covering(*environment.place)] = 1.0
        belief = belief / belief.sum()
        np.testing.assert_allclose(step.beliefs["A"], belief, atol=1e-12)
    assert episode.found or planner == "random"


@pytest.mark.parametrize("planner", ["greedy", "pouct", "fast"])
def test_planners_start_again_from_the_cell_that_covers_the_reported_pose(planner):
    """The robot goes east to a target, but finds itself at the start, facing north."""
    table = np.full(SHAPE, 1e-9)
    table[4, 10] = 1.0
    turned = Scripted(((7.5, 21.5, math.pi / 2 + 0.3), {}, False), pose=(7.5, 21.5, 0.0))
    config = SearchConfig(sims=4000, max_steps=3)
    episode = search(turned, planner, beliefs={"A": table}, config=config)
    assert episode.actions == ("forward", "right", "right")


def test_a_pose_that_slipped_makes_the_tree_start_anew_and_a_pose_as_planned_keeps_it():
    config = SearchConfig(sims=300, max_steps=2)
    visits = []
    for off_m in (0.0, 5.0):

        def answer(action, off_m=off_m):
            heading = {"forward": 0.0, "left": math.pi / 4, "right": -math.pi / 4}[action.name]
            x = 12.5 + (15.0 if action.name == "forward" else 0.0) + off_m
            return (x, 21.5, heading), {}, False

        scripted = Scripted(answer, pose=(12.5, 21.5, 0.0))
        episode = search(scripted, "pouct", config=config)
        visits.append(sum(episode.info[1].visits.values()))
    assert visits[0] > 320
    assert visits[1] == 299  # the first simulation makes the root


def test_a_collision_that_is_reported_costs_its_reward():
    config = SearchConfig(max_steps=2, collision_reward=-77.0, move_reward=-3.0)
    hits, steps = iter([True, False]), []
    episode = search(
        Scripted(lambda action: ((27.5, 21.5, 0.0), None, next(hits))),
        Only("forward"),
        config=config,
        on_step=steps.append,
    )
    assert episode.rewards == (-77.0, -3.0)
    assert [step.collision for step in steps] == [True, False]


def test_places_may_be_left_out_and_are_kept_where_they_are_told():
    assert search(Drifting()).places == {}
    assert search(Drifting(), places={"A": (31.0, 22.0)}).places == {"A": (31.0, 22.0)}


def test_what_is_found_is_what_the_environment_says():
    beliefs = {"A": np.ones(SHAPE), "B": np.ones(SHAPE)}

    def answer(action):
        found = ("B",) if action.name == "find(B)" else ()
        return (27.5, 21.5, 0.0), Report({"B": (36.0, 22.0)}, found), False

    class Then:
        actions = iter(["left", "find(B)", "find(A)"])

        def plan(self, agent):
            return next(self.actions)

    config = SearchConfig(find_each=True)
    steps = []
    episode = search(Scripted(answer), Then(), beliefs=beliefs, config=config, on_step=steps.append)
    assert episode.found_targets == ("B",)
    assert episode.rewards == (-10.0, 1000.0, -1000.0)
    assert steps[0].observation == {"A": None, "B": (37.5, 21.5)}  # the middle of its cell
    assert steps[0].beliefs["B"][4, 7] == 1


def test_an_observation_that_the_belief_held_impossible_collapses():
    table = np.zeros(SHAPE)
    table[0, 0] = 1.0
    with pytest.raises(BeliefCollapse) as error:
        search(Scripted(((27.5, 21.5, 0.0), {"A": (36.0, 22.0)}, False)), beliefs={"A": table})
    assert str(error.value) == (
        "Target 'A' was seen at cell (4, 7), which its belief held impossible; give a belief that "
        "is nowhere zero, or set recovery_weight to mix in the belief of the start"
    )
    # behind the robot: there the fan never sees anything
    with pytest.raises(BeliefCollapse, match=r"seen at cell \(4, 2\), which its belief held"):
        search(Scripted(((27.5, 21.5, 0.0), {"A": (12.0, 22.0)}, False)))


HERE = (27.5, 21.5, 0.0)


@pytest.mark.parametrize(
    ("answer", "kind", "message"),
    [
        (
            None,
            InputError,
            "The environment returned None for 'left'; expected (pose, report, collision)",
        ),
        (
            (HERE, {}),
            InputError,
            (
                "The environment returned ((27.5, 21.5, 0.0), {}) for 'left'; expected (pose, "
                "report, collision)"
            ),
        ),
        (
            ((27.5, math.nan, 0.0), {}, False),
            InputError,
            (
                "The pose that the environment reports is (27.5, nan, 0.0); expected (x_m, y_m, "
                "heading_rad) as three finite numbers"
            ),
        ),
        (
            ((27.5, 21.5), {}, False),
            InputError,
            (
                "The pose that the environment reports is (27.5, 21.5); expected (x_m, y_m, "
                "heading_rad) as three finite numbers"
            ),
        ),
        (
            ((60.0, 21.5, 0.0), {}, False),
            OutsideMap,
            (
                "The environment reports a pose off the map: Place (60, 21.5) is off the map; "
                "expected x in [0, 55) and y in (-1, 44], metres"
            ),
        ),
        (
            (HERE, ["A"], False),
            InputError,
            (
                "The environment's report is ['A']; expected a Report, or a mapping from target to "
                "what the sensor reports"
            ),
        ),
        (
            (HERE, {"Car": None}, False),
            InputError,
            "The environment reports of 'Car'; expected one of the targets: A",
        ),
        (
            (HERE, Report(found=("Car",)), False),
            InputError,
            "The environment reports of 'Car'; expected one of the targets: A",
        ),
        (
            (HERE, Report(found=("A",)), False),
            InputError,
            (
                "The environment reports that 'left' found 'A', which it does not look for; "
                "expected finds alone to find"
            ),
        ),
        (
            (HERE, {"A": "near"}, False),
            InputError,
            (
                "The environment's report of 'A': The report 'near' is no place; expected "
                "(x_m, y_m) or None"
            ),
        ),
        (
            (HERE, {"A": (math.nan, 3.0)}, False),
            InputError,
            (
                "The environment's report of 'A': The report (nan, 3.0) is no place; expected "
                "(x_m, y_m) or None"
            ),
        ),
        (
            (HERE, {"A": (99.0, 3.0)}, False),
            OutsideMap,
            (
                "The environment's report of 'A': Place (99, 3) is off the map; expected x in "
                "[0, 55) and y in (-1, 44], metres"
            ),
        ),
    ],
)
def test_what_an_environment_gets_wrong_is_one_line(answer, kind, message):
    with pytest.raises(InputError) as error:
        search(Scripted(answer), Only())
    assert (type(error.value), str(error.value)) == (kind, message)


class Loudness:
    """A sensor without a mask."""

    def view(self, pose):
        return np.ones(SHAPE, dtype=bool)

    def log_likelihood(self, pose, report):
        return np.zeros(SHAPE)

    def sample(self, pose, places, rng):
        return dict.fromkeys(places, 1)


def test_a_report_that_cannot_be_hashed_is_one_line():
    with pytest.raises(InputError) as error:
        search(Scripted((HERE, {"A": [1, 2]}, False)), Only(), sensor=Loudness())
    assert str(error.value) == (
        "The environment's report of 'A' is a list, which cannot be hashed; expected a number, a "
        "tuple or None"
    )


class Placeless:
    def execute(self, action):
        return HERE, {}, False


@pytest.mark.parametrize(
    ("environment", "options", "message"),
    [
        (
            3,
            {},
            (
                "The environment is a int; expected an object with a method execute(action) -> "
                "(pose, report, collision) and an attribute pose, where it starts"
            ),
        ),
        (
            Placeless(),
            {},
            (
                "The environment is a Placeless; expected an object with a method execute(action) "
                "-> (pose, report, collision) and an attribute pose, where it starts"
            ),
        ),
        (
            Drifting(),
            {"start": (3.0, 3.0)},
            "start is given, but the environment has its own; leave start out",
        ),
        (
            Drifting(),
            {"places": {"A": "home"}},
            "The place of 'A' is 'home'; expected x, y as finite numbers",
        ),
        (
            Drifting(),
            {"places": {"B": (3.0, 3.0)}},
            "'B' has no belief; expected places of none but: A",
        ),
        (
            Scripted(None, pose=None),
            {},
            (
                "The environment's pose is None; expected (x_m, y_m, heading_rad) as three finite "
                "numbers"
            ),
        ),
        (
            Scripted(None, pose=(-3.0, 3.0, 0.0)),
            {},
            (
                "The environment's pose: Place (-3, 3) is off the map; expected x in [0, 55) and "
                "y in (-1, 44], metres"
            ),
        ),
    ],
)
def test_an_environment_that_is_none_is_one_line(environment, options, message):
    with pytest.raises(InputError) as error:
        search(environment, **options)
    assert str(error.value) == message


class Gusty:
    """A user's motion with Gaussian noise; every draw is another pose."""

    def sample(self, pose, action, rng):
        after = ExactMotion().sample(pose, action, rng)
        return Pose(
            rng.normal(after.x_m, 1.5), rng.normal(after.y_m, 1.5), after.heading_rad + 0.05
        )

    def log_probability(self, next_pose, pose, action):
        after = ExactMotion().sample(pose, action, None)
        return -(math.dist(after[:2], next_pose[:2]) ** 2) / (2 * 1.5**2)


@pytest.mark.parametrize("planner", ["pouct", "greedy", "random", "fast"])
def test_poses_stay_continuous_and_on_the_map_under_a_motion_with_noise(planner):
    episode = run_search(
        {"A": np.eye(9, 11) + 0.01},
        CITY,
        {"A": (42.0, 40.0)},
        planner=planner,
        motion=Gusty(),
        config=SearchConfig(sims=30, max_steps=40, max_finds=40),
        start=Pose(4.2, 20.9, 0.3),
        rng=np.random.default_rng(3),
    )
    assert episode.poses[0] == Pose(4.2, 20.9, 0.3)
    for x, y, _ in episode.poses:
        assert 0 <= x < 55
        assert -1 < y <= 44
    assert len({(p.x_m, p.y_m) for p in episode.poses}) > 5
    assert len({p.x_m % 5.0 for p in episode.poses}) > 5
    fan = FanSensor(CITY.grid)
    for pose, view in zip(episode.poses, episode.views, strict=True):
        np.testing.assert_array_equal(view, fan.view(pose))


def test_a_pose_as_start_is_taken_as_it_is_and_checked():
    episode = search(None, places={"A": (31.0, 22.0)}, start=Pose(4.1, 20.9, 0.3))
    assert episode.poses[0] == (4.1, 20.9, 0.3)
    with pytest.raises(OutsideMap) as error:
        search(None, places={"A": (31.0, 22.0)}, start=Pose(4.1, 50.0))
    assert str(error.value) == (
        "Start: Place (4.1, 50) is off the map; expected x in [0, 55) and y in (-1, 44], metres"
    )


class TwoAndAHalf:
    """A motion that goes 12.5 m, from the middle of a cell to a border of one."""

    def sample(self, pose, action, rng):
        turn = {"forward": 0.0, "left": math.pi / 4, "right": -math.pi / 4}[action]
        go = 12.5 if action == "forward" else 0.0
        x, y = (
            pose.x_m + go * math.cos(pose.heading_rad),
            pose.y_m + go * math.sin(pose.heading_rad),
        )
        return x, y, pose.heading_rad + turn

    def log_probability(self, next_pose, pose, action):
        return 0.0


@pytest.mark.parametrize("planner", ["fast", "greedy"])
def test_a_cell_that_only_the_middle_of_the_robots_cell_would_show_is_not_waited_for(planner):
    city = city_of(41, 41)
    x, y = np.meshgrid(city.grid.x_m, city.grid.y_m)
    for seed in (3, 14):  # `fast` turned left and right for ever, and marked what was not in view
        episode = run_search(
            {"A": np.exp(-np.hypot(x - 72.5, y - 42.5) / 30)},
            city,
            {"A": (65.0, 30.0)},
            motion=TwoAndAHalf(),
            planner=planner,
            config=SearchConfig(sims=200),
            rng=np.random.default_rng(seed),
        )
        assert episode.found


def test_a_find_is_decided_on_what_is_in_view_from_the_reported_pose():
    space = SearchSpace(CITY.grid, ("A",), SearchConfig())
    middle = space.encode(4, 5, 0)
    x, y, _ = space.pose_at(middle)
    only_middle = sorted(space.view(middle) - set(_seen(space, Pose(x - 2.4, y, 0.0))))
    assert only_middle
    table = np.zeros(SHAPE)
    table.flat[only_middle[0]] = 1.0
    robot = space.robot(middle, looked=True)
    rng = np.random.default_rng(0)
    there = GridBelief(space, {"A": table}, robot, rng=rng)
    assert find_value(there, space.finds[0]) == 1000
    beside = GridBelief(space, {"A": table}, robot, rng=rng, pose=Pose(x - 2.4, y, 0.0))
    assert find_value(beside, space.finds[0]) == -1000
    assert only_middle[0] in beside.unseen
    assert beside.in_view == tuple(_seen(space, beside.pose))
    assert there.unseen == frozenset()


def _seen(space, pose):
    return np.flatnonzero(space.view_mask(pose)).tolist()


@pytest.mark.parametrize(
    ("made", "message"),
    [
        ({"seen": None}, "What a report has seen is None; expected a mapping from target to what "),
        ({"found": None}, "What a report has found is None; expected the names of targets in a "),
        (
            {"found": "A"},
            "What a report has found is 'A'; expected the names of targets in a tuple",
        ),
    ],
)
def test_a_report_that_is_none_is_one_line(made, message):
    with pytest.raises(InputError) as error:
        Report(**made)
    assert str(error.value).startswith(message)
    assert "\n" not in str(error.value)


def test_what_is_said_of_a_target_that_was_found_is_not_heard():
    space = SearchSpace(CITY.grid, ("A", "B"), SearchConfig())
    robot = space.robot(space.encode(4, 5, 0), found=1, finds=1, looked=True)
    outcome = Outcome(Pose(*HERE), Report({"A": (27.5, 22.0), "B": None}))
    observation = observation_of(space, space.moves[1], robot, outcome)
    assert observation.seen == (-1, -1)
    assert not observation.any
