from __future__ import annotations

import math

import numpy as np
import pytest
from shapely.geometry import box
from support.small_searches import space_of

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap, Grid, Landmark, load_map
from sloop_ppl.planning import (
    SearchConfig,
    SearchRewardModel,
    SearchState,
    SearchTransitionModel,
    run_search,
)
from sloop_ppl.planning._search_tables import likeliest_poses, visible_mass
from sloop_ppl.planning.obstacles import cells_between, height_m, tall_cells


def building(**properties):
    return Landmark("Hall", "building", box(20, 10, 30, 20), properties=properties)


def city(**properties):
    return CityMap("hall", Grid(0, 0, 59, 39), (building(**properties),))


@pytest.mark.parametrize(
    ("properties", "height"),
    [
        ({}, 12.0),
        ({"height": "25"}, 25.0),
        ({"height": "25.5 m"}, 25.5),
        ({"height": "100 ft"}, 30.48),
        ({"building:levels": "4"}, 12.0),
        ({"height": "8", "building:levels": "4"}, 8.0),
        ({"height": "tall"}, 12.0),
        ({"height_m": 6.5, "height": "8"}, 6.5),
        ({"height_m": None}, 12.0),
    ],
)
def test_heights_come_from_tags_and_else_from_the_kind(properties, height):
    assert height_m(building(**properties)) == pytest.approx(height)


def test_only_buildings_as_tall_as_the_flight_are_obstacles():
    assert tall_cells(city(), 10.0).sum() == 4
    assert tall_cells(city(height="8"), 10.0).sum() == 0
    assert tall_cells(city(height="30"), 40.0).sum() == 0


def test_lines_of_sight_are_the_same_either_way_and_turned():
    for rows in range(-4, 5):
        for cols in range(-4, 5):
            there = [set(step) for step in cells_between(rows, cols)]
            back = [{(rows + r, cols + c) for r, c in step} for step in cells_between(-rows, -cols)]
            assert there == back[::-1]
            turned = [{(-c, r) for r, c in step} for step in cells_between(cols, -rows)]
            assert there == [{(r, c) for r, c in step} for step in turned] or len(there) == 0
            for step in cells_between(rows, cols):
                for r, c in step:
                    off = abs(r * cols - c * rows) / math.hypot(rows, cols)
                    assert off <= 0.5 + 1e-9


def test_a_tall_building_hides_what_is_behind_it_but_not_its_front():
    tall = np.zeros((7, 9), dtype=bool)
    tall[3, 5] = True
    space = space_of(occlusion=True)
    hidden = space_of(occlusion=True)
    hidden = type(space)((7, 9), ("A",), SearchConfig(occlusion=True), tall)
    pose = space.encode(3, 4, 0)
    assert space.view(pose) - hidden.view(pose) == {3 * 9 + 6, 3 * 9 + 7}
    assert 3 * 9 + 5 in hidden.view(pose)
    belief = np.random.default_rng(0).dirichlet(np.ones(63))
    mass = visible_mass(hidden, [belief])
    assert mass[pose] == pytest.approx(belief[sorted(hidden.view(pose))].sum())


@pytest.mark.parametrize("wall", [5, 6, 7])
def test_a_no_fly_building_stops_a_step_wherever_it_stands_on_the_way(wall):
    tall = np.zeros((7, 9), dtype=bool)
    tall[3, wall] = True
    space = type(space_of())((7, 9), ("A",), SearchConfig(no_fly=True), tall)
    pose = space.encode(3, 4, 0)
    assert space.next_pose(0, pose) == pose
    assert likeliest_poses(space)[0, pose] == pose
    state = SearchState(space.robot(pose), (0,))
    after = SearchTransitionModel(space).sample(state, space.actions[0])
    assert after.robot.collided
    assert SearchRewardModel(space).sample(state, space.actions[0], after) == -1000
    assert SearchRewardModel(space).sample(state, space.actions[1], state) == -10
    edge = SearchState(space.robot(space.encode(6, 4, 2)), (0,))
    assert SearchRewardModel(space).sample(edge, space.actions[0], edge) == -10


def test_a_start_inside_a_no_fly_building_is_refused_and_never_drawn():
    beliefs, places = {"A": np.ones((8, 12))}, {"A": (50.0, 30.0)}
    config = SearchConfig(no_fly=True, max_steps=1)
    options = {"planner": "random", "config": config}
    with pytest.raises(InputError) as error:
        run_search(
            beliefs, city(), places, start=(25.0, 15.0), rng=np.random.default_rng(0), **options
        )
    assert str(error.value) == (
        "Start (25, 15) is inside a no-fly building; start elsewhere, or fly above 10 m"
    )
    tall = tall_cells(city(), 10.0)
    for seed in range(60):
        rng = np.random.default_rng(seed)
        x, y, _ = run_search(beliefs, city(), places, rng=rng, **options).start
        grid = city().grid
        assert not tall[np.isclose(grid.y_m, y)][0, np.isclose(grid.x_m, x)][0]


def test_searches_around_buildings_that_hide_and_hinder_end_well():
    town = load_map("cleveland")
    config = SearchConfig(no_fly=True, occlusion=True)
    episode = run_search(
        {"A": np.ones(town.grid.shape)},
        town,
        {"A": (-37.5, -72.5)},
        planner="greedy",
        config=config,
        rng=np.random.default_rng(3),
    )
    tall = tall_cells(town, 10.0)
    assert 0.02 < tall.mean() < 0.6
    assert -1000 not in episode.rewards[:-1]
    for x, y, _ in episode.poses:
        assert not tall[np.isclose(town.grid.y_m, y)][0, np.isclose(town.grid.x_m, x)][0]
