from __future__ import annotations

import subprocess
import sys
import warnings

import numpy as np
import pytest
from support.small_searches import city_of

from sloop_ppl.errors import InputError
from sloop_ppl.planning import MaskSensor, Pose, SearchConfig

gymnasium = pytest.importorskip("gymnasium", reason="the extra 'gym' is not installed")

from sloop_ppl.planning.gym_env import SearchEnv  # noqa: E402
from sloop_ppl.planning.gym_register import ENVIRONMENT, register  # noqa: E402


def make(**options):
    register()
    return gymnasium.make(ENVIRONMENT, **options).unwrapped


@pytest.mark.parametrize("settings", [{}, {"find_each": True, "true_positive_rate": 0.8}])
def test_gymnasiums_own_check_passes(settings):
    from gymnasium.utils.env_checker import check_env

    beliefs = {"A": np.ones((41, 41)), "B": np.eye(41) + 0.01}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        check_env(make(beliefs=beliefs, config=SearchConfig(**settings), render_mode="rgb_array"))


def test_an_episode_adds_up_and_ends_with_the_find():
    env = make()
    place, start = {"Target": (-17.0, -2.0)}, (-32.0, -2.0, 45.0)
    observed, _ = env.reset(seed=1, options={"places": place, "start": start})
    assert observed["looked"] == 0
    assert observed["belief"].sum() == pytest.approx(1)
    assert not env.action_masks()[3]
    observed, reward, over, cut, info = env.step(2)
    assert (reward, over, cut) == (-10, False, False)
    assert info["reported"] == {"Target": env._city.grid.cell_at(-17.0, -2.0)}
    assert observed["belief"].max() == 1
    observed, reward, over, _, _ = env.step(3)
    assert (reward, over, observed["found"].tolist()) == (1000, True, [1])


def test_a_find_before_the_first_look_is_wrong():
    env = make()
    env.reset(seed=1)
    _, reward, over, _, _ = env.step(3)
    assert (reward, over) == (-1000, True)


def test_steps_are_cut_off_at_the_limit():
    env = make(config=SearchConfig(max_steps=2))
    env.reset(seed=1, options={"places": {"Target": (90.0, 90.0)}, "start": (-90.0, -90.0)})
    assert env.step(1)[2:4] == (False, False)
    assert env.step(1)[2:4] == (False, True)


def test_pictures_have_north_up_and_the_robot_in_its_cell():
    env = make(render_mode="rgb_array")
    env.reset(seed=1, options={"start": (-97.0, 97.0)})
    picture = env.render()
    assert picture.shape == (41 * 8, 41 * 8, 3)
    assert picture[0, 0].tolist() == [214, 94, 0]


def test_misuse_is_one_line():
    env = make()
    with pytest.raises(InputError, match="was not reset; call reset"):
        env.step(0)
    with pytest.raises(InputError, match="render_mode is 'human'; expected 'rgb_array' or None"):
        SearchEnv(render_mode="human")


@pytest.mark.parametrize(
    "action", [-1, 4, 1.5, "find", None, (1, 2), np.float64(2.0), np.array([], dtype=int)]
)
def test_an_action_that_is_none_is_one_line_and_changes_nothing(action):
    env = make()
    env.reset(seed=1)
    before = env.belief
    with pytest.raises(InputError) as error:
        env.step(action)
    message = f"Action {action!r} is none of: 0 forward, 1 left, 2 right, 3 find"
    assert str(error.value) == message
    assert env.belief is before


@pytest.mark.parametrize("action", [np.int64(1), np.array(1), np.uint8(1)])
def test_whole_numbers_of_numpy_are_actions(action):
    env = make()
    env.reset(seed=1, options={"start": (0.0, 0.0)})
    assert env.step(action)[0]["pose"].tolist() == [20, 20, 1]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"starts": (0.0, 0.0)},
            (
                "Option of reset 'starts' is unknown; expected one of places, start; did you mean "
                "'start'?"
            ),
        ),
        (
            {"places": {"Car": (0.0, 0.0)}},
            "'Target' has no place; expected a place for each of: Target",
        ),
        (
            {"start": (0.0, 0.0, 10.0)},
            (
                "The start's heading is 10; expected a multiple of 45 degrees, anticlockwise from "
                "east"
            ),
        ),
        (
            {"places": 5},
            "The places are 5; expected a mapping from target to x and y in metres",
        ),
        ("start", "The options of reset are 'start'; expected a mapping with places, start"),
    ],
)
def test_options_of_reset_that_are_none_are_one_line(options, message):
    with pytest.raises(InputError) as error:
        make().reset(seed=1, options=options)
    assert str(error.value) == message


class Disk(MaskSensor):
    def view(self, pose):
        x, y = np.meshgrid(self.grid.x_m, self.grid.y_m)
        return np.hypot(x - pose.x_m, y - pose.y_m) <= 12.0


class Creeping:
    """Steps of 3 to 4 m: poses do not stay in the middle of cells."""

    def sample(self, pose, action, rng):
        if action != "forward":
            return pose._replace(heading_rad=pose.heading_rad + (1.0 if action == "left" else -1.0))
        length = 3.0 + rng.random()
        return Pose(
            pose.x_m + length * np.cos(pose.heading_rad),
            pose.y_m + length * np.sin(pose.heading_rad),
            pose.heading_rad,
        )

    def log_probability(self, next_pose, pose, action):
        return 0.0


def test_sensor_and_motion_of_ones_own_are_stepped_with_and_beliefs_follow_the_true_pose():
    city = city_of(9, 11)
    table = np.random.default_rng(1).dirichlet(np.ones(99)).reshape(9, 11)
    env = make(beliefs={"A": table}, city=city, sensor=Disk(city.grid), motion=Creeping())
    env.reset(seed=2, options={"places": {"A": (52.0, 40.0)}, "start": (8.0, 9.0)})
    for action in (0, 0, 1, 0):
        observed, reward, _, _, info = env.step(action)
        pose = env._environment.pose
        table = table * ~Disk(city.grid).view(pose)
        np.testing.assert_allclose(observed["belief"][0], table / table.sum())
        assert observed["pose"][:2].tolist() == list(city.grid.cell_covering(*pose[:2]))
        assert (reward, info) == (-10.0, {"reported": {}})
    assert pose.x_m % 5 != 2.5


@pytest.mark.parametrize(
    ("imports", "name"),
    [
        ("gymnasium", "sloop_ppl.planning.gym_register:sloop_ppl/Search-v0"),
        ("gymnasium, sloop_ppl.planning", "sloop_ppl/Search-v0"),
        ("sloop_ppl.planning.gym_register, gymnasium", "sloop_ppl/Search-v0"),
    ],
)
def test_gymnasium_makes_the_environment_by_its_name(imports, name):
    code = f"import {imports}; print(gymnasium.make({name!r}).unwrapped.space.shape)"
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=False
    )
    assert done.stdout == "(41, 41)\n", done.stderr
