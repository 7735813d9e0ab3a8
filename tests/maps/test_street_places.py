"""Places named by streets: the block of a landmark, across the street, one side of it."""

from __future__ import annotations

import math

import pytest
import shapely

from sloop_ppl.maps import (
    Landmark,
    across_street,
    blocks_of,
    bundled_maps,
    load_map,
    same_block,
    street_network,
    street_side,
)
from tests.streets import GRID, city, house, street, two_by_two


def test_the_block_of_a_landmark():
    town = two_by_two(house("House", 20, 20), Landmark("Sign", "poi", shapely.Point(60, 0)))
    (block,) = blocks_of(town, "House")
    assert block.polygon.area == pytest.approx(6400)
    assert same_block(town, "House").sum() == pytest.approx(16 * 16, abs=33)
    assert same_block(town, "House")[GRID.cell_at(-35, -35)]
    assert not same_block(town, "House")[GRID.cell_at(50, 0)]
    (other,) = blocks_of(town, "Sign")
    assert other.number != block.number


def test_a_house_that_reaches_over_its_street_is_on_one_block_and_a_street_on_two():
    town = two_by_two(house("House", 0, 31, half=10), street("Short Ln", (-40, 0), (40, 0)))
    assert len(blocks_of(town, "House")) == 1
    assert len(blocks_of(town, "ShortLn")) == 2


def test_across_the_street_is_the_other_side_of_the_same_stretch():
    town = two_by_two(house("House", 0, 30))
    across = across_street(town, "House")
    assert across.bounds == pytest.approx((-36, 44, 36, 59))
    assert across.covers(shapely.Point(0, 50))
    assert not across.covers(shapely.Point(0, 30))
    assert not across.covers(shapely.Point(60, 50))
    assert across_street(town, "House", depth_m=5).bounds[3] == pytest.approx(49)


def test_across_a_street_is_either_side():
    town = two_by_two()
    across = across_street(town, "NorthSt")
    assert across.covers(shapely.MultiPoint([(0, 50), (0, 30), (80, 50)]))
    assert not across.intersects(shapely.LineString([(-100, 40), (100, 40)]))


def test_one_side_of_a_street():
    north = street_side(two_by_two(), "NorthSt", math.pi / 2)
    assert north.covers(shapely.MultiPoint([(0, 50), (80, 50)]))
    assert not north.intersects(shapely.box(-100, -100, 100, 40))
    # It runs east and west.
    assert street_side(two_by_two(), "NorthSt", 0.0) is None


def test_a_winding_street_has_a_north_side_where_it_runs_east():
    town = city(street("Bent St", (-100, 0), (0, 0), (0, 80), (100, 80)))
    north = street_side(town, "BentSt", math.pi / 2)
    assert north.covers(shapely.MultiPoint([(-50, 10), (50, 90)]))
    assert not north.intersects(shapely.MultiPoint([(-50, -10), (50, 70), (10, 40)]))
    west = street_side(town, "BentSt", math.pi)
    assert west.covers(shapely.Point(-10, 40))
    assert not west.intersects(shapely.MultiPoint([(10, 40), (50, 90)]))


def test_the_far_side_of_a_divided_road_is_beyond_both_carriageways():
    road = [
        street("Main St", (-105, 10), (105, 10), id="MainEast"),
        street("Main St", (105, -10), (-105, -10), id="MainWest"),
    ]
    town = city(*road, house("North", 0, 30), house("South", 0, -30))
    for one, y in (("North", -20), ("South", 20)):
        across = across_street(town, one)
        assert across.covers(shapely.Point(0, y))
        assert not across.intersects(shapely.box(-50, -13, 50, 13))
        assert not across.intersects(shapely.Point(0, -y))


def test_a_map_without_streets_has_no_other_side_and_no_blocks():
    bare = city(house("House", 0, 0))
    assert across_street(bare, "House") is None
    assert street_side(bare, "House", 0.0) is None
    assert blocks_of(bare, "House") == ()
    assert not same_block(bare, "House").any()


@pytest.mark.parametrize("name", bundled_maps())
def test_across_from_each_building_is_another_block_or_the_same_street_end(name):
    bundled = load_map(name)
    network = street_network(bundled)
    found = other = 0
    for building in bundled.of_kind("building"):
        across = across_street(bundled, building.id)
        blocks = blocks_of(bundled, building.id)
        if across is None or not blocks:
            continue
        found += 1
        assert not across.intersects(building.geometry.centroid)
        largest = max(network.blocks, key=lambda b: b.polygon.intersection(across).area)
        other += largest not in blocks
    assert found > 10
    assert other / found > 0.9
