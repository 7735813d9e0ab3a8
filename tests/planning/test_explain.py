from __future__ import annotations

import itertools
import json

import numpy as np
import pytest
from support.small_searches import city_of

from sloop_ppl.planning import GridBelief, SearchConfig, SearchSpace, run_search
from sloop_ppl.planning.explain import unreachable_notes


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


def notes_of(shape, table, start, tall=None, **settings):
    config = SearchConfig(no_fly=tall is not None, **settings)
    space = SearchSpace(shape, ("A",), config, tall)
    robot = space.robot(space.encode(*start))
    belief = GridBelief(space, {"A": table}, robot, rng=np.random.default_rng(0))
    return unreachable_notes(belief)


def note(share, steps=None):
    if steps is None:
        line = f"{share} of the belief of A cannot be brought into view from this start, however"
        return (f"{line} many steps: start elsewhere",)
    line = f"{share} of the belief of A cannot be brought into view within {steps} steps from this"
    return (f"{line} start: allow more steps, or start elsewhere",)


def test_belief_in_a_walled_courtyard_is_said_to_be_out_of_reach():
    tall = np.zeros((9, 9), dtype=bool)
    tall[2:7, 2:7] = True
    tall[3:6, 3:6] = False
    table = np.zeros((9, 9))
    table[4, 4], table[8, 8] = 0.4, 0.6
    near = {"sensor_range_cells": 1, "step_cells": 1}
    assert notes_of((9, 9), table, (0, 0, 0), tall, **near) == note("40%")
    assert notes_of((9, 9), table, (4, 4, 0), tall, **near) == note("60%")
    gate = tall.copy()
    gate[4, 6] = False
    assert notes_of((9, 9), table, (0, 0, 0), gate, **near) == ()
    # a longer sensor looks over the wall, unless tall buildings hide what is behind them
    far = {"sensor_range_cells": 3, "step_cells": 1}
    assert notes_of((9, 9), table, (0, 0, 0), tall, **far) == ()
    assert notes_of((9, 9), table, (0, 0, 0), tall, occlusion=True, **far) == note("40%")


@pytest.mark.parametrize(("steps", "lost"), [(2, "75%"), (3, "25%"), (4, None)])
def test_belief_that_is_too_far_for_the_steps_is_said_to_be_out_of_reach(steps, lost):
    """The last step is the find: with three, the robot looks at (1, 3) from two cells on."""
    table = np.zeros((3, 12))
    table[1, 1], table[1, 3], table[1, 4] = 0.25, 0.5, 0.25
    settings = {"sensor_range_cells": 1, "step_cells": 1, "max_steps": steps}
    told = notes_of((3, 12), table, (1, 0, 0), **settings)
    assert told == (note(lost, steps) if lost else ())
    table[1, 4] *= 0.1  # less than a twentieth is not worth saying
    if steps == 3:
        assert notes_of((3, 12), table, (1, 0, 0), **settings) == ()


def test_a_robot_that_only_goes_along_diagonals_never_sees_half_of_the_board():
    """Facing north-east with turns of 90 degrees it stays on the cells of one colour.

    From there it sees the neighbours, which have the other colour.
    """
    settings = {"sensor_range_cells": 1, "step_cells": 1, "turn_deg": 90}
    board = np.indices((4, 4)).sum(axis=0) % 2
    assert notes_of((4, 4), np.ones((4, 4)), (0, 0, 1), **settings) == note("50%")
    assert notes_of((4, 4), board, (0, 0, 1), **settings) == ()
    assert notes_of((4, 4), 1 - board, (0, 0, 1), **settings) == note("100%")
    assert notes_of((4, 4), 1 - board, (0, 0, 1), **{**settings, "turn_deg": 45}) == ()


def test_the_notes_are_told_before_the_first_step_and_kept():
    table = np.zeros((9, 11))
    table[8, 10] = 1.0
    lines = []
    episode = run_search(
        {"A": table},
        city_of(9, 11),
        {"A": (51.0, 42.0)},
        planner="greedy",
        config=SearchConfig(max_steps=2),
        start=(3.0, 3.0),
        rng=np.random.default_rng(2),
        notify=lines.append,
    )
    assert episode.notes == note("100%", 2)
    assert lines[: len(episode.notes)] == list(episode.notes)
