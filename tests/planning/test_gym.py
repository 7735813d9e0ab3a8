from __future__ import annotations

import subprocess
import sys
import warnings

import numpy as np
import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.planning import SearchConfig

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
