"""Wherever a table over cells is given, one of xarray is read by coordinate, never by position."""

from __future__ import annotations

import numpy as np
import pytest
import xarray

from sloop_ppl.errors import InputError
from sloop_ppl.inference import infer_description
from sloop_ppl.models.simulation import simulate
from sloop_ppl.planning import SearchConfig, run_search
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid
from tests.support.small_searches import city_of

CITY = house_and_street(symmetric_grid(15), house=(12.0, -7.0), street_y=30.0)
POSTERIOR = infer_description(said(relation("near", "House")), CITY)[0]


def labelled(values, grid):
    return xarray.DataArray(values, dims=("y", "x"), coords={"y": grid.y_m, "x": grid.x_m})


TURNS = {
    "y from the north": lambda table: table.sortby("y", ascending=False),
    "x from the east": lambda table: table.sortby("x", ascending=False),
    "x before y": lambda table: table.transpose("x", "y"),
}
PARTS = {
    "half": lambda table: table.isel(x=slice(0, 3)),
    "coarse": lambda table: table.isel(x=slice(None, None, 2)),
    "shifted": lambda table: table.assign_coords(y=table.y + 2.0),
}


def sensed(table):
    return POSTERIOR.condition({TARGET: table}).belief(TARGET)


def searched(table):
    small = city_of(5, 6)
    episode = run_search(
        {"A": table}, small, {"A": (11.0, 12.0)}, planner="greedy",
        config=SearchConfig(max_steps=6), rng=np.random.default_rng(2), keep_beliefs=True,
    )  # fmt: skip
    return np.array([b["A"] for b in episode.beliefs])


def drawn(table):
    made = [
        simulate(CITY, [TARGET], prior=table, phrases=1, rng=np.random.default_rng(seed))
        for seed in range(4)
    ]
    return np.array([one.latents[TARGET].place_m for one in made])


USES = {
    "condition": (sensed, CITY.grid),
    "run_search": (searched, city_of(5, 6).grid),
    "simulate": (drawn, CITY.grid),
}


def table_of(grid):
    return labelled(np.random.default_rng(1).random(grid.shape) ** 3, grid)


@pytest.mark.parametrize("use", USES)
@pytest.mark.parametrize("turn", TURNS)
def test_turned_axes_change_nothing(use, turn):
    read, grid = USES[use]
    table = table_of(grid)
    np.testing.assert_array_equal(read(TURNS[turn](table)), read(table.values))


@pytest.mark.parametrize("use", USES)
@pytest.mark.parametrize("part", PARTS)
def test_other_cells_are_refused(use, part):
    read, grid = USES[use]
    with pytest.raises(InputError, match="give the whole table on the map's own cells"):
        read(PARTS[part](table_of(grid)))


@pytest.mark.parametrize("spoilt", [np.nan, np.inf, -1.0])
def test_a_prior_of_no_weights_draws_nothing(spoilt):
    weights = np.ones(CITY.grid.shape)
    weights[0, 0] = spoilt
    with pytest.raises(InputError, match="The prior holds"):
        drawn(weights)
    with pytest.raises(InputError, match=r"The prior has shape \(2, 3\)"):
        drawn(np.ones((2, 3)))
