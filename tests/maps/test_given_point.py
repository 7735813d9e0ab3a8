"""Points as people give them: metres, or degrees marked as such."""

from __future__ import annotations

import pytest

from sloop_ppl.errors import InputError, OutsideMap
from sloop_ppl.maps import Grid, load_map, search_area
from sloop_ppl.maps._given_point import GivenPoint, are_degrees_of, read_lat_lon, read_point

GRID = load_map("cleveland").grid


@pytest.mark.parametrize(
    "text",
    [
        "@41.5,-81.7",
        " @41.5, -81.7 ",
        "41.5N,81.7W",
        "81.7w 41.5n",
        "N41.5 W81.7",
        "41.5°N, 81.7°W",
        "41°30'N,81°42'W",
        "N 41° 30.000' W 081° 42.000'",
        "41°30'0\"N 81°42′0″W",
        "@41.5N,81.7W",
    ],
)
def test_degrees_in_many_hands(text):
    assert read_lat_lon(text) == pytest.approx((41.5, -81.7))


@pytest.mark.parametrize(
    "text",
    [
        "", "@", "1", "@1", "1,2,3", "@1,2,3", "a,b", "nan,1", "@inf,1", "@91,0", "@0,181",
        "91N,0E", "41.5N,81.7N", "41.5N,-81.7", "-41.5N,81.7W", "41.5N81.7W5",
        "41°60'N,81W", "N41.5N,81W",
    ],
)  # fmt: skip
def test_what_is_neither(text):
    assert read_point(text) is None


def test_metres_are_never_degrees():
    assert read_point("41.4998,-81.6995") == GivenPoint(41.4998, -81.6995)
    assert read_lat_lon("41.4998,-81.6995") is None


def test_degrees_are_put_on_the_map():
    x, y = 12.25, -80.5
    lon, lat = (float(v) for v in GRID.to_lonlat(x, y))
    assert read_point(f"@{lat:.9f},{lon:.9f}").on(GRID) == pytest.approx((x, y), abs=1e-3)
    assert read_point("500,0").on(GRID) == (500.0, 0.0)  # left to who checks places
    outside = read_point("41.51N,81.7W")
    with pytest.raises(OutsideMap, match=r"expected a latitude in \[41.49956, 41.50136\]"):
        outside.on(GRID)
    assert outside.on(GRID, may_be_outside=True)[1] > 1000
    with pytest.raises(InputError, match="centre"):
        outside.on(Grid.square(10))


def test_which_metres_are_questioned():
    assert are_degrees_of(GRID, 41.4998, -81.6995)
    assert are_degrees_of(GRID, -81.6995, 41.4998)
    assert are_degrees_of(GRID, 41.4993, -81.6944)  # a little beside the map
    assert not are_degrees_of(GRID, 41.4998, 81.6995)
    assert not are_degrees_of(GRID, -37.25, -72.5)
    assert not are_degrees_of(GRID, 410.0, 0.25)
    somewhere = Grid.square(100, centre=(47.5, 7.5))
    assert not are_degrees_of(somewhere, 47.5, 7.5)  # the centre of a cell
    assert are_degrees_of(somewhere, 47.501, 7.5)
    assert not are_degrees_of(Grid.square(100), 41.4998, -81.6995)


def test_an_area_in_degrees():
    lon, lat = GRID.to_lonlat([-30.0, 42.0], [-70.0, 11.0])
    west, east, south, north = (float(v) for v in (*lon, *lat))
    area = search_area(f"@{west},{south},{east},{north}", GRID)
    assert area.polygon.bounds == pytest.approx((-30, -70, 42, 11), abs=0.05)
    with pytest.raises(InputError, match="is in degrees; expected metres from the map's centre"):
        search_area((west, south, east, north), GRID)
