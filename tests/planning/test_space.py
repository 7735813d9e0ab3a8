from __future__ import annotations

import json
import math
from dataclasses import asdict

import numpy as np
import pytest
from support.small_searches import space_of

from sloop_ppl.errors import InputError, OutsideMap, UnknownName
from sloop_ppl.planning import Pose, SearchConfig
from sloop_ppl.planning._search_tables import likeliest_poses, reach_from, visible_mass


def test_actions_come_in_their_declared_order():
    assert [a.name for a in space_of().actions] == ["forward", "left", "right", "find"]
    each = space_of(ids=("A", "B"), find_each=True)
    assert [a.name for a in each.actions] == ["forward", "left", "right", "find(A)", "find(B)"]


@pytest.mark.parametrize(
    ("heading", "after"),
    [(0, (3, 7)), (1, (5, 6)), (2, (6, 4)), (3, (5, 2)), (4, (3, 1)), (6, (0, 4)), (7, (1, 6))],
)
def test_a_step_goes_three_cells_and_is_rounded_on_diagonals(heading, after):
    space = space_of()
    pose = space.next_pose(0, space.encode(3, 4, heading))
    assert space.decode(pose) == (*after, heading)


def test_a_step_off_the_map_leaves_the_pose():
    space = space_of()
    pose = space.encode(3, 7, 0)
    assert space.next_pose(0, pose) == pose


@pytest.mark.parametrize(("turn", "left"), [(45, 1), (90, 2)])
def test_left_is_anticlockwise(turn, left):
    space = space_of(turn_deg=turn)
    assert space.decode(space.next_pose(1, space.encode(3, 4, 0)))[2] == left
    assert space.decode(space.next_pose(2, space.encode(3, 4, 0)))[2] == 8 - left


@pytest.mark.parametrize(("row", "col"), [(-1, 0), (7, 0), (0, -1), (0, 9)])
def test_a_cell_outside_the_grid_has_no_pose(row, col):
    with pytest.raises(OutsideMap) as error:
        space_of().encode(row, col, 0)
    assert str(error.value) == (
        f"Cell ({row}, {col}) is outside the grid; expected a row in [0, 7) and a column in [0, 9)"
    )


def test_a_continuous_pose_snaps_to_the_cell_that_covers_it_and_the_nearest_heading():
    """The grid of 7 x 9 cells begins in the west at 0 and ends in the north at 32.5."""
    space = space_of()
    assert space.decode(space.snap(Pose(9.99, 32.4, math.radians(22)))) == (6, 1, 0)
    assert space.decode(space.snap(Pose(10.0, 27.4, math.radians(23)))) == (5, 2, 1)
    assert space.decode(space.snap(Pose(10.0, 27.4, math.radians(-23)))) == (5, 2, 7)
    assert space.decode(space.snap(Pose(10.0, 27.4, math.radians(740)))) == (5, 2, 0)
    for number in range(space.n_cells * 8):
        assert space.snap(space.pose_at(number)) == number
    with pytest.raises(
        OutsideMap, match=r"Place \(10, 33\) is off the map; expected x in \[0, 45\)"
    ):
        space.snap(Pose(10.0, 33.0))


@pytest.mark.parametrize(
    ("shape", "settings", "steps", "horizon"),
    [
        ((41, 41), {}, 200, 30),  # the paper's
        ((9, 41), {"step_cells": 1}, 200, 30),
        ((20, 82), {}, 400, 60),  # twice as wide
        ((82, 82), {"step_cells": 6}, 400, 60),
        ((401, 401), {}, 1957, 90),  # 0.95 ** 90 is just below a hundredth
        ((401, 401), {"discount": 1.0}, 1957, 294),
        ((401, 401), {"discount": 0.5}, 1957, 30),
        ((401, 401), {"max_steps": 50}, 50, 90),
        ((401, 401), {"depth": 12}, 1957, 12),
        ((401, 401), {"depth": 12, "max_steps": 50}, 50, 12),
    ],
)
def test_steps_and_horizon_grow_with_the_map(shape, settings, steps, horizon):
    config = SearchConfig(**settings).filled_in(shape)
    assert (config.max_steps, config.depth) == (config.step_limit, config.horizon)
    assert (config.max_steps, config.depth) == (steps, horizon)
    assert config.filled_in((999, 999)) == config


def test_what_the_size_of_the_map_sets_is_said():
    def notes(shape, **settings):
        given = SearchConfig(**settings)
        return given.filled_in(shape).size_notes(given)

    steps, depth = "1957 steps at most (max_steps)", "a horizon of 90 steps (depth)"
    assert notes((41, 41)) == ()
    assert notes((401, 401)) == (f"set by the size of the map: {steps}, {depth}",)
    assert notes((401, 401), depth=12) == (f"set by the size of the map: {steps}",)
    assert notes((401, 401), max_steps=9) == (f"set by the size of the map: {depth}",)
    assert notes((401, 401), depth=12, max_steps=9) == ()


def test_preferred_moves_go_nearer_or_turn_towards():
    space = space_of()
    rng = np.random.default_rng(0)
    for _ in range(500):
        pose = int(rng.integers(space.n_cells * 8))
        cell = int(rng.integers(space.n_cells))
        target = divmod(cell, space.n_cols)

        def distance(p, target=target):
            return math.dist(space.decode(p)[:2], target)

        def off(p, target=target):
            row, col, heading = space.decode(p)
            bearing = math.atan2(target[0] - row, target[1] - col)
            return abs(math.remainder(bearing - heading * math.pi / 4, math.tau))

        nexts = [space.next_pose(i, pose) for i in range(3)]
        expected = (distance(nexts[0]) < distance(pose)) * 1
        if space.decode(pose)[:2] != target:
            expected |= (off(nexts[1]) < off(pose) - 1e-9) * 2
            expected |= (off(nexts[2]) < off(pose) - 1e-9) * 4
        assert space.preferred_moves(pose, cell) == expected


def test_all_poses_at_once_agree_with_one_pose_at_a_time():
    space = space_of(turn_deg=90)
    table = likeliest_poses(space)
    for pose in range(space.n_cells * 8):
        assert [space.next_pose(i, pose) for i in range(3)] == table[:, pose].tolist()
    belief = np.random.default_rng(0).dirichlet(np.ones(space.n_cells))
    mass = visible_mass(space, [belief])
    for pose in range(space.n_cells * 8):
        assert mass[pose] == pytest.approx(belief[sorted(space.view(pose))].sum(), abs=1e-15)


def test_reach_counts_the_fewest_moves_and_its_first_move_leads_there():
    space = space_of()
    nexts = likeliest_poses(space)
    start = space.encode(3, 4, 0)
    reach = reach_from(start, nexts)
    assert reach.steps[space.encode(3, 7, 0)] == 1
    assert reach.steps[space.encode(3, 4, 1)] == 1
    assert reach.steps[space.encode(3, 4, 4)] == 4
    assert reach.first[space.encode(3, 4, 4)] == 1  # left and right tie; left comes first
    assert reach.steps[start] == 2  # there and back
    for pose in np.flatnonzero(reach.steps > 1):
        before = reach_from(int(nexts[reach.first[pose], start]), nexts)
        assert before.steps[pose] in (reach.steps[pose] - 1, 1, 2)


def test_a_sensor_that_sees_further_than_the_map_is_refused():
    with pytest.raises(InputError) as error:
        space_of(sensor_range_cells=10.0)
    assert str(error.value) == (
        "sensor_range_cells is 10, more than the map, which is 7 x 9 cells; expected at most 9"
    )


def test_a_find_is_looked_up_by_its_target():
    assert space_of(ids=("A", "B"), find_each=True).find("B").name == "find(B)"
    assert space_of(ids=("A", "B")).find("B").name == "find"
    with pytest.raises(UnknownName) as error:
        space_of(ids=("Car", "Bike")).find("Bikes")
    assert str(error.value) == (
        "Target of a find 'Bikes' is unknown; expected one of Car, Bike; did you mean 'Bike'?"
    )


def test_more_than_ten_targets_are_refused():
    with pytest.raises(InputError) as error:
        space_of(ids=[f"T{i}" for i in range(11)])
    assert str(error.value) == (
        "11 targets were given; expected 1 to 10: search for the others in a second search"
    )


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"sims": 0}, "sims is 0; expected a whole number of at least 1"),
        ({"sims": -5}, "sims is -5; expected a whole number of at least 1"),
        ({"depth": 2.5}, "depth is 2.5; expected a whole number of at least 1"),
        ({"sims": True}, "sims is True; expected a whole number of at least 1"),
        ({"tree_depth": -1}, "tree_depth is -1; expected a whole number of at least 0"),
        ({"max_finds": 0}, "max_finds is 0; expected a whole number of at least 1"),
        ({"turn_deg": 30}, "turn_deg is 30; expected 45 or 90"),
        ({"fov_deg": 0.0}, "fov_deg is 0.0; expected a number in (0, 360]"),
        ({"discount": 1.5}, "discount is 1.5; expected a number in (0, 1]"),
        ({"exploration": -1.0}, "exploration is -1.0; expected a number >= 0"),
        ({"move_reward": math.nan}, "move_reward is nan; expected a finite number"),
        (
            {"rollout": "rndom"},
            (
                "Rollout 'rndom' is unknown; expected one of published, random, informed; "
                "did you mean 'random'?"
            ),
        ),
        (
            {"sensor_range_cells": 0.5},
            (
                "sensor_range_cells is 0.5; expected a finite number of at least "
                "sensor_min_range_cells, 1.0"
            ),
        ),
    ],
)
def test_settings_out_of_range_are_named(settings, message):
    with pytest.raises(InputError) as error:
        SearchConfig(**settings)
    assert str(error.value) == message


def test_whole_numbers_of_numpy_are_taken_and_saved_as_json():
    settings = {"sims": 10, "depth": 5, "max_finds": 2, "turn_deg": 90}
    config = SearchConfig(**{name: np.int32(value) for name, value in settings.items()})
    assert config == SearchConfig(**settings)
    assert json.loads(json.dumps(asdict(config)))["sims"] == 10
