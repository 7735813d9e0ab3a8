"""Regions of streets and blocks that relations may measure from, on two by two streets."""

from __future__ import annotations

from dataclasses import replace

import pytest
import shapely

from sloop_ppl.language import RELATIONS
from sloop_ppl.maps import bundled_maps, load_map, street_network
from sloop_ppl.models import REGIONS, ground_relations
from tests.scenes import relation
from tests.streets import city, house, street, two_by_two

NAMES = ("street side", "crossing", "block", "stretch", "same block")


def region(name, *grounds, town=None):
    return REGIONS[name](town or two_by_two(house("House", 20, 20)), grounds)


def test_sides_of_a_street_or_the_one_where_something_is():
    both = region("street side", "NorthSt")
    assert both.covers(shapely.MultiPoint([(0, 50), (0, 30)]))
    south = region("street side", "NorthSt", "House")
    assert south.covers(shapely.Point(0, 30))
    assert not south.intersects(shapely.Point(0, 50))
    assert region("street side", "House") is None


def test_crossings_of_streets():
    one = region("crossing", "NorthSt", "EastAve")
    assert one.centroid.coords[0] == pytest.approx((40, 40))
    assert one.area == pytest.approx(201, rel=0.02)  # a disc as wide as both streets
    assert len(region("crossing", "NorthSt").geoms) == 2
    assert region("crossing", "NorthSt", "SouthSt") is None
    assert region("crossing", "House") is None


def test_blocks_between_streets_and_of_a_house():
    streets = ("NorthSt", "SouthSt", "WestAve", "EastAve")
    assert region("block", *streets).area == pytest.approx(6400)
    assert region("block", "House").equals(region("block", *streets))
    assert region("block", "House", "NorthSt").equals(region("block", "House"))
    # Three on either side, of which the border cuts all but the one in the middle.
    assert region("block", "NorthSt").area == pytest.approx(205 * 142.5, rel=0.01)
    town = two_by_two(house("House", 20, 20), house("Far", 80, 80))
    assert region("block", "House", "Far", town=town) is None


def test_the_rest_of_the_block():
    rest = region("same block", "House")
    assert rest.area == pytest.approx(6400 - 64)
    assert not rest.intersects(shapely.Point(20, 20))


def test_a_stretch_between_two_streets_in_any_order():
    stretch = region("stretch", "NorthSt", "WestAve", "EastAve")
    assert stretch.bounds == pytest.approx((-40, 21, 40, 59))
    assert region("stretch", "WestAve", "EastAve", "NorthSt").equals(stretch)
    assert region("stretch", "NorthSt").bounds[2] > 100
    assert region("stretch", "NorthSt", "WestAve") is None
    assert region("stretch", "NorthSt", "SouthSt", "WestAve").bounds == pytest.approx(
        (-59, -40, -21, 40)
    )
    assert region("stretch", "NorthSt", "SouthSt", "House") is None


@pytest.mark.parametrize("name", NAMES)
def test_maps_without_streets_or_crossings_have_no_region_or_a_sound_one(name):
    bare = city(house("House", 0, 0))
    lone = city(street("Lone St", (-50, 0), (50, 0)), house("House", 0, 20))
    assert region(name, "House", town=bare) is None
    for grounds in (("LoneSt",), ("House",), ("LoneSt", "House"), ("House", "LoneSt")):
        found = region(name, *grounds, town=lone)
        assert found is None or (found.area > 0 and found.is_valid)


@pytest.mark.parametrize("name", NAMES)
def test_a_relation_may_measure_from_it(name):
    record = replace(RELATIONS["near"], region=name, grounds="any")
    RELATIONS.add("hereabouts", record)
    try:
        town = two_by_two(house("House", 20, 20))
        (term,) = ground_relations((relation("hereabouts", "EastAve"),), town, joint=True)
        assert term.reference_region.shape.area > 0
        assert float(term.distance_m.min()) == 0
    finally:
        RELATIONS.remove("hereabouts")


@pytest.mark.parametrize("name", bundled_maps())
def test_regions_of_bundled_maps_are_sound(name):
    bundled = load_map(name)
    ids = [axis.ids[0] for axis in street_network(bundled).streets if axis.named]
    for one in ids:
        for word in NAMES:
            for grounds in ((one,), *((one, other) for other in ids if other != one)):
                found = REGIONS[word](bundled, grounds)
                assert found is None or (found.is_valid and not found.is_empty)
        corner = REGIONS["crossing"](bundled, (one,))
        assert (corner is None) == (not street_network(bundled).crossings_of(one))
