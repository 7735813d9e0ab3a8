"""A window is the map seen through a square hole, in the same frame."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from sloop_ppl.errors import InputError, OutsideMap
from sloop_ppl.maps import CityMap, Grid, Landmark, load_map


def test_landmarks_are_cut_at_its_border():
    street = Landmark("MainSt", "street", shapely.LineString([(-50, 3), (50, 3)]), name="Main")
    away = Landmark("Away", "building", shapely.box(30, 30, 40, 40))
    shop = Landmark("Shop", "poi", shapely.Point(3, 3), within="Away")
    city = CityMap("block", Grid.square(50.0), (street, away, shop), "us", {"made_by": "hand"})
    seen = city.window((0, 0), 20)
    assert [m.id for m in seen.landmarks] == ["MainSt", "Shop"]
    assert seen.landmark("MainSt").geometry.bounds == (-10, 3, 10, 3)
    assert seen.landmark("MainSt").name == "Main"
    assert seen.landmark("Shop").within is None
    assert seen.grid.extent_m == (-10, -10, 10, 10)
    assert (seen.attribution, dict(seen.properties)) == ("us", {"made_by": "hand"})


def test_a_building_that_only_touches_the_border_is_outside():
    house = Landmark("H", "building", shapely.box(10, 0, 20, 10))
    city = CityMap("block", Grid.square(50.0), (house,))
    assert city.window((0, 0), 20).landmarks == ()


@settings(deadline=None)
@given(st.floats(-100, 100), st.floats(-100, 100), st.floats(1, 300))
def test_a_place_is_the_same_on_both(x, y, side):
    city = load_map("cleveland")
    seen = city.window((x, y), side)
    west, south, east, north = seen.grid.extent_m
    assert west >= -100
    assert south >= -100
    assert east <= 100
    assert north <= 100
    for landmark in seen.landmarks:
        whole = city.landmark(landmark.id).geometry
        assert whole.buffer(1e-6).covers(landmark.geometry)
        assert seen.cells(landmark.id).any()


def test_the_whole_map_is_its_own_window():
    city = load_map("denver")
    whole = city.window((0, 0), 500)
    assert [m.id for m in whole.landmarks] == [m.id for m in city.landmarks]
    assert whole.grid == city.grid


@pytest.mark.parametrize("side", [0, -1, np.nan, np.inf])
def test_a_side_that_is_no_length(side):
    with pytest.raises(InputError, match=r"expected a positive number of metres$"):
        load_map("denver").window((0, 0), side)


def test_a_centre_off_the_map():
    with pytest.raises(OutsideMap, match=r"^Place \(101, 0\) is outside the map"):
        load_map("denver").window((101, 0), 20)
