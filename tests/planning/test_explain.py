from __future__ import annotations

import itertools
import json

import numpy as np
import pytest
from support.small_searches import city_of

from sloop_ppl.planning import SearchConfig, run_search


def steps_of(planner, **settings):
    steps = []
    run_search(
        {"A": np.ones((9, 11))},
        city_of(9, 11),
        {"A": (51.0, 42.0)},
        planner=planner,
        config=SearchConfig(sims=200, max_steps=4, **settings),
        start=(3.0, 3.0),
        rng=np.random.default_rng(2),
        on_step=steps.append,
    )
    return steps


@pytest.mark.parametrize("planner", ["pouct", "fast", "greedy", "random", "pomcp"])
def test_every_planner_says_what_each_move_is_expected_to_show(planner):
    steps = steps_of(planner)
    for before, after in itertools.pairwise(steps):
        if after.action == "find":
            continue
        chance = after.info.expected[after.action]["A"]
        assert chance == pytest.approx(before.beliefs["A"][after.view].sum())
        assert 0 <= chance <= 1


@pytest.mark.parametrize("rollout", ["published", "informed"])
@pytest.mark.parametrize("planner", ["pouct", "fast"])
def test_the_tree_can_be_kept_as_json(planner, rollout):
    if (planner, rollout) == ("pouct", "informed"):
        pytest.skip("pouct has no informed rollout")
    for step in steps_of(planner, tree_depth=2, rollout=rollout):
        tree = json.loads(json.dumps(step.info.tree))
        for name, value in step.info.values.items():
            assert tree["actions"][name]["value"] == pytest.approx(value)
            assert tree["actions"][name]["visits"] == step.info.visits[name]
        below = [a for b in tree["actions"].values() for a in b["after"].values()]
        assert below
        assert all(b["visits"] >= 0 for b in below)
    assert steps_of(planner, rollout=rollout)[0].info.tree is None


def test_pomdp_pys_tree_debugger_works_on_pouct():
    from pomdp_py.utils import TreeDebugger

    root = steps_of("pouct", tree_depth=1)[0].info.root
    debugger = TreeDebugger(root)
    assert debugger.nn > 10
    assert {str(a) for a in root.children} == {"forward", "left", "right"}


def test_fast_tells_the_path_it_follows_and_what_it_shows():
    info = steps_of("fast")[1].info
    path, chances = info.notes["path"], info.notes["expected_seen"]
    assert len(path) == len(chances) > 1
    assert max(info.values, key=info.values.__getitem__) == path[0]
    assert 0 <= sum(chances) <= 1 + 1e-9
