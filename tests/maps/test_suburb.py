"""The suburban map: invented, and good for what it is meant for."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest
import shapely
from support.tree import ROOT

from sloop_ppl.maps import bundled_maps, load_map, to_geojson
from sloop_ppl.planning.obstacles import height_m, tall_cells

SUBURB = load_map("suburb")
PLOTS = [m for m in SUBURB.landmarks if m.id.endswith("House")]


def test_it_is_no_city():
    assert "suburb" not in bundled_maps()
    assert "OpenStreetMap" not in SUBURB.attribution


def test_the_file_is_what_the_plan_says():
    path = ROOT / "tests" / "tools" / "build_suburb.py"
    spec = importlib.util.spec_from_file_location("build_suburb", path)
    plan = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(plan)
    planned, there = to_geojson(plan.build()), to_geojson(SUBURB)
    for one, other in zip(planned["features"], there["features"], strict=True):
        assert one["properties"] == other["properties"]
    for one, other in zip(plan.build().landmarks, SUBURB.landmarks, strict=True):
        assert shapely.equals_exact(one.geometry, other.geometry, tolerance=1e-3)


@pytest.mark.parametrize("plot", PLOTS, ids=lambda plot: plot.id)
def test_a_house_is_a_plot_on_which_a_car_can_stand_beside_the_building(plot):
    building = SUBURB.landmark(f"{plot.id}Building")
    assert plot.geometry.contains(building.geometry)
    x, y = np.meshgrid(SUBURB.grid.x_m, SUBURB.grid.y_m)
    free = shapely.contains_xy(plot.geometry, x, y)
    free &= ~shapely.contains_xy(building.geometry.buffer(2.5), x, y)
    assert free.sum() >= 8
    # The plot's cells are its own, not those of the building in it.
    assert SUBURB.cells(plot.id).sum() > 2 * SUBURB.cells(building.id).sum()


def test_plots_and_buildings_keep_off_the_streets_and_one_another():
    for street in SUBURB.of_kind("street", "service"):
        road = street.geometry.buffer(street.width_m / 2)
        for other in (*PLOTS, *SUBURB.of_kind("building")):
            assert not road.intersects(other.geometry), (street.id, other.id)
    for i, one in enumerate(PLOTS):
        assert not any(one.geometry.intersects(other.geometry) for other in PLOTS[i + 1 :])


def test_some_houses_are_lower_and_some_higher_than_the_flight():
    heights = [height_m(b) for b in SUBURB.of_kind("building")]
    assert all("height_m" in b.properties for b in SUBURB.of_kind("building"))
    assert min(heights) < 6.5
    assert sum(h >= 10 for h in heights) >= 6
    assert sum(h < 10 for h in heights) >= 10
    assert max(heights) > 14
    cells = [int(tall_cells(SUBURB, flight).sum()) for flight in (5.0, 10.0, 14.0, 20.0)]
    assert cells == sorted(cells, reverse=True)
    assert cells[0] > cells[1] > cells[2] > cells[3] == 0
