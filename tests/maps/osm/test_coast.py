"""The sea lies on the right of the coastline."""

import pytest
import shapely

from sloop_ppl.maps import Grid
from sloop_ppl.maps.osm._coast import sea
from sloop_ppl.maps.osm._feature import OsmFeature

GRID = Grid.square(50.0)


def coast(number, *places):
    line = shapely.LineString(places)
    closed = places[0] == places[-1]
    shape = shapely.Polygon(places) if closed else line
    return OsmFeature(f"way/{number}", {"natural": "coastline"}, shape, line if closed else None)


def test_a_coast_that_runs_north_has_the_sea_in_the_east():
    water = sea([coast(1, (0, -90), (0, 90))], GRID)
    assert water.geometry.equals(shapely.box(0, -50, 50, 50))
    assert (water.kind, water.word, water.name, water.sources) == ("water", "Sea", None, ["way/1"])


def test_a_coast_in_pieces_is_one_coast():
    water = sea([coast(2, (0, 90), (0, 5)), coast(1, (0, 5), (0, -90))], GRID)
    assert water.geometry.equals(shapely.box(-50, -50, 0, 50))
    assert water.sources == ["way/1", "way/2"]


def test_an_island_is_a_hole_in_the_sea():
    island = coast(1, (-10, -10), (10, -10), (10, 10), (-10, 10), (-10, -10))
    water = sea([island], GRID)
    assert water.geometry.area == pytest.approx(100 * 100 - 20 * 20)
    assert len(water.geometry.interiors) == 1


def test_a_lagoon_is_water_inside_land():
    water = sea([coast(1, (-10, -10), (-10, 10), (10, 10), (10, -10), (-10, -10))], GRID)
    assert water.geometry.equals(shapely.box(-10, -10, 10, 10))


def test_a_strait_leaves_land_on_both_sides():
    water = sea([coast(1, (-10, -90), (-10, 90)), coast(2, (10, 90), (10, -90))], GRID)
    assert water.geometry.equals(shapely.box(-10, -50, 10, 50))


@pytest.mark.parametrize(
    "places",
    [
        [(0, -90), (0, 10)],  # ends inside the extent
        [(60, -90), (60, 90)],  # outside
        [(50, -90), (50, 90)],  # along the border, the sea beyond it
    ],
)
def test_a_coast_that_cuts_nothing_off_makes_no_sea(places):
    assert sea([coast(1, *places)], GRID) is None
    assert sea([], GRID) is None


def test_an_area_is_no_coastline():
    walls = shapely.Polygon([(-60, 0), (60, 0), (60, 40), (-60, 40)], [[(0, 50), (5, 60), (9, 50)]])
    assert sea([OsmFeature("relation/1", {"natural": "coastline"}, walls)], GRID) is None
