from __future__ import annotations

import os
import pickle
import subprocess
import sys
import types
from pathlib import Path

import numba
import numpy as np
import pytest
from support.small_searches import agent_of

from sloop_ppl.planning import (
    SearchConfig,
    SearchObservation,
    SearchSpace,
    _belief_mass,
    _compile,
    _greedy_path,
    _path_kernel,
    _path_map,
    _tree_kernel,
    _value_bound,
    make_planner,
    notify_compiling,
    warm_up,
)
from sloop_ppl.planning._compile import jit

ROOT = Path(__file__).parents[2]
ENTRIES = [
    function
    for module in (_belief_mass, _greedy_path, _path_kernel, _path_map, _tree_kernel, _value_bound)
    for name, function in vars(module).items()
    if isinstance(getattr(function, "_cache", None), _compile._ForgivingCache)
]

SEARCH = """
import logging, sys
logging.basicConfig(level="INFO")
import numpy as np
from sloop_ppl.maps import load_map
from sloop_ppl.planning import Fast, SearchConfig, notify_compiling, run_search

def plan(rollout):
    city = load_map("cleveland")
    config = SearchConfig(sims=50, max_steps=3, rollout=rollout)
    search = {"T": np.ones(city.grid.shape)}, city, {"T": (50.0, 50.0)}
    return run_search(*search, planner="fast", config=config, rng=np.random.default_rng(0))

with notify_compiling(lambda: print("compiling")):
    for rollout in sys.argv[1:]:
        print(*plan(rollout).actions)
"""


def double(number):
    return 2 * number


def python(code, *arguments, cache, folder=ROOT, start=subprocess.run, **options):
    """Run code in a process of its own, whose machine code is kept in a folder of its own."""
    return start(
        [sys.executable, "-c", code, *arguments],
        cwd=folder,
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


def lines_of(done):
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.fixture(scope="module")
def warm(tmp_path_factory):
    """A cache folder with the machine code of the tree search."""
    cache = tmp_path_factory.mktemp("cache")
    assert lines_of(python(SEARCH, "published", cache=cache))[0] == "compiling"
    return cache


def test_without_a_place_for_a_cache_machine_code_is_made_anew():
    nowhere = types.FunctionType(double.__code__.replace(co_filename="<nowhere>"), {}, "double")
    compiled = jit(nowhere)
    assert compiled(21) == 42
    assert compiled.stats.cache_path is None
    assert jit(double).stats.cache_path is not None


def test_a_warm_cache_says_nothing(warm):
    lines = lines_of(python(SEARCH, "published", "random", cache=warm))
    assert len(lines) == 2
    assert "compiling" not in lines


def test_a_domain_of_ones_own_leaves_the_cache_alone(warm, tmp_path):
    tiger = (ROOT / "examples" / "fast_tiger.py").read_text()
    (tmp_path / "my_tiger.py").write_text(tiger)
    before = {path.name: path.read_bytes() for path in warm.rglob("*.nb?")}
    code = "import sys; sys.path.insert(0, '.'); import my_tiger; my_tiger.main()"
    assert "listen" in lines_of(python(code, cache=warm, folder=tmp_path))[0]
    assert {path.name: path.read_bytes() for path in warm.rglob("*.nb?")} == before
    assert "compiling" not in lines_of(python(SEARCH, "published", cache=warm))


GONE = b"csloop_ppl_gone\nSearchData\n."  # a pickle of a class of a module that is not there


@pytest.mark.parametrize(
    ("kind", "broken"),
    [("nbi", GONE), ("nbi", b""), ("nbc", b"\x80\x04")],
    ids=["an index that names what is gone", "a cut index", "cut machine code"],
)
def test_a_cache_that_cannot_be_loaded_is_made_anew(warm, kind, broken):
    version = pickle.dumps(numba.__version__) if kind == "nbi" else b""
    for path in warm.rglob(f"_tree_kernel.find_child-*.{kind}"):
        path.write_bytes(version + broken)
    for _ in range(2):
        done = python(SEARCH, "published", cache=warm)
        assert lines_of(done)[-1].split()[0] in ("forward", "left", "right")
    assert "compiling" not in done.stdout


def test_two_processes_that_compile_at_once_both_work(tmp_path):
    running = [python(SEARCH, "published", cache=tmp_path, start=subprocess.Popen) for _ in "ab"]
    told = [process.communicate(timeout=300) for process in running]
    assert [process.returncode for process in running] == [0, 0], told
    assert told[0][0] == told[1][0]
    assert "compiling" not in lines_of(python(SEARCH, "published", cache=tmp_path))


WALLS = np.random.default_rng(8).random((40, 43)) < 0.1


@pytest.mark.parametrize("rollout", ["informed", "published", "random"])
def test_one_version_serves_all_settings(rollout):
    warm_up()
    settings = [
        {},
        {"sensor_range_cells": 30.0, "fov_deg": 360.0},
        {"sensor_range_cells": 1.0, "turn_deg": 90, "step_cells": 1},
        {"true_positive_rate": 0.8, "false_positive_rate": 0.1, "position_noise_cells": 1.5},
        {"no_fly": True, "occlusion": True, "find_each": True},
        {"stay_rate": 0.1, "overshoot_rate": 0.1, "overturn_rate": 0.1},
    ]
    with notify_compiling(lambda: pytest.fail("another version was compiled")):
        for number, setting in enumerate(settings):
            ids = ("A", "B", "C")[: 1 + number % 3]
            config = SearchConfig(sims=60, rollout=rollout, tree_depth=number % 2, **setting)
            space = SearchSpace(WALLS.shape, ids, config, WALLS)
            agent = agent_of(space, {name: np.ones(WALLS.shape) for name in ids}, 800)
            planner = make_planner("fast", space, rng=np.random.default_rng(0))
            action, _ = planner.plan(agent)
            robot = agent.belief.robot.moved(1)
            planner.update(agent, space.moves[1], _nothing(space, robot))
            planner.plan(agent)
            assert action in space.actions
    assert len(ENTRIES) == 11
    assert [len(function.signatures) for function in ENTRIES] == [1] * 11


def _nothing(space, robot):
    pose = robot.pose if space.stochastic else -1
    return SearchObservation((-1,) * len(space.target_ids), 0, pose)


def test_warm_up_says_where_machine_code_is_kept(tmp_path):
    code = "from sloop_ppl.cli import main; main(['warmup'])"
    first = python(code, cache=tmp_path)
    again = python(code, cache=tmp_path)
    assert (first.returncode, again.returncode) == (0, 0)
    assert first.stdout == again.stdout == ""
    assert first.stderr.startswith(f"{_compile.COMPILING}\n")
    assert str(tmp_path) in again.stderr
    assert len(again.stderr.splitlines()) == 1


def test_the_notice_comes_once_and_for_functions_of_ours_alone():
    said = []
    with notify_compiling(lambda: said.append("compiling")):
        numba.njit(double)(1)
        assert said == []
        for _ in range(2):
            ours = types.FunctionType(double.__code__, {"__name__": "sloop_ppl.planning.x"})
            assert _compile.uncached(ours)(1) == 2
        assert said == ["compiling"]
