"""Language beliefs in pomdp-py's own domains."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import sloop_ppl as sloop

EXAMPLES = Path(__file__).parents[2] / "examples"


def example(name):
    spec = importlib.util.spec_from_file_location(f"example_{name}", EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_pomdp_pys_own_search_plans_from_a_language_belief(capsys):
    results = example("multi_object_search").main(smoke=True)
    assert set(results) == {"told", "not told"}
    assert all(0 < result.steps <= 12 for result in results.values())
    assert "told: Result(" in capsys.readouterr().out


def test_words_count_for_the_time_they_speak_of(capsys):
    tag = example("tag")
    result = tag.main(smoke=True)
    assert result.then > 2 * result.unheard
    assert result.then > 2 * result.now
    # The same by hand: infer, then push the table forward with the target's motion.
    city = sloop.load_map("cleveland", cell_m=tag.CELL_M)
    said = sloop.parse(tag.TEXT, city, targets=[tag.DOG])
    table = sloop.infer(said, city).belief(tag.DOG.id)
    robot_y = next(iter(result.belief)).robot_position[1]
    for robot in ((step, robot_y) for step in range(tag.LATE)):
        table = predicted(table, robot)
        seen = (robot[1], robot[0] + 1)
        table[seen] = 0.0  # the robot is there now and saw nothing
        table /= table.sum()
    for state in result.belief:
        col, row = state.target_position
        assert result.belief[state] == pytest.approx(table[row, col], abs=1e-7)


def predicted(table, robot):
    """A step: stay with .2, else one of the four steps that lead away, if there is one."""
    after = np.zeros_like(table)
    height, width = table.shape
    for (row, col), p in np.ndenumerate(table):
        away = [
            (r, c)
            for r, c in ((row, col + 1), (row, col - 1), (row + 1, col), (row - 1, col))
            if 0 <= r < height
            and 0 <= c < width
            and np.hypot(c - robot[0], r - robot[1]) > np.hypot(col - robot[0], row - robot[1])
        ]
        after[row, col] += p * (0.2 if away else 1.0)
        for cell in away:
            after[cell] += 0.8 * p / len(away)
    return after


@pytest.mark.slow
@pytest.mark.parametrize("name", ["multi_object_search", "tag"])
def test_a_script_says_the_same_whatever_the_hash_seed(name):
    told = {
        subprocess.run(
            [sys.executable, EXAMPLES / f"{name}.py", "--smoke"],
            capture_output=True, text=True, check=True, env={**os.environ, "PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("0", "1")
    }  # fmt: skip
    assert len(told) == 1
