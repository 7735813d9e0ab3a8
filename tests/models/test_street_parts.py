"""Parts of streets as grounds: regions by hand, and what a belief makes of them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely

from sloop_ppl.inference import infer_description
from sloop_ppl.language import SPEAKER, Description, SpatialRelation, StreetPart, TargetObject
from sloop_ppl.maps import bundled_maps, load_map, street_network
from sloop_ppl.models import ground_relations, preset
from sloop_ppl.models._street_parts import part_region
from tests.streets import city, house, street, two_by_two

NORTH, WEST, SOUTHWEST = math.pi / 2, math.pi, -3 * math.pi / 4


def numbered():
    """Even numbers from 100 north of the street, odd ones south, 20 m for two numbers."""
    houses = [
        house(f"H{n}", -80 + 10 * (n - 100), 20 if n % 2 == 0 else -20, house_number=str(n))
        for n in (100, 101, 104, 107, 108, 112)
    ]
    return city(street("Main St", (-105, 0), (105, 0)), *houses)


def belief(relation: SpatialRelation, town, model="bayes"):
    said = Description("", town.name, (TargetObject(relation.figure),), (relation,))
    posterior, _ = infer_description(said, town, model)
    return posterior.belief(relation.figure)


def term(town, word, *grounds, part=None, figure="Car"):
    relation = SpatialRelation(figure, word, grounds, part=part)
    (found,) = ground_relations((relation,), town, joint=True)
    return found


def test_a_side_is_15_m_from_the_kerb():
    region = part_region(two_by_two(), ("NorthSt",), StreetPart("side", NORTH))
    assert region.bounds == pytest.approx((-105, 44, 105, 59), abs=2.6)
    assert part_region(two_by_two(), ("NorthSt",), StreetPart("side", 0.0)) is None
    both = part_region(two_by_two(), ("NorthSt",), StreetPart("side"))
    assert both.covers(shapely.MultiPoint([(0, 50), (0, 30)]))


def test_odd_and_even_sides():
    even, odd = (part_region(numbered(), ("MainSt",), StreetPart("side", number=n)) for n in (2, 1))
    assert even.covers(shapely.Point(0, 10))
    assert not even.intersects(shapely.Point(0, -10))
    assert odd.covers(shapely.Point(0, -10))
    assert part_region(two_by_two(), ("NorthSt",), StreetPart("side", number=1)) is None


def test_corners_of_one_street_and_of_two():
    town = two_by_two()
    every = part_region(town, ("NorthSt",), StreetPart("corner"))
    assert len(every.geoms) == 2
    one = part_region(town, ("NorthSt", "EastAve"), StreetPart("corner"))
    assert one.bounds == pytest.approx((21, 21, 59, 59), abs=0.1)  # 4 m of street and 15 m
    corner = part_region(town, ("NorthSt", "EastAve"), StreetPart("corner", SOUTHWEST))
    assert corner.bounds == pytest.approx((21, 21, 40, 40), abs=0.1)
    assert corner.area == pytest.approx(math.pi * 19**2 / 4, rel=0.01)
    assert part_region(town, ("NorthSt", "SouthSt"), StreetPart("corner")) is None


def test_the_corner_of_a_block_lies_across_from_that_of_a_crossing():
    """The north-east corner of the block in the middle is south-west of its crossing."""
    region = part_region(two_by_two(), ("NorthSt",), StreetPart("block-corner", math.pi / 4))
    middle = shapely.intersection(region, shapely.box(-39, -39, 40, 40))
    assert middle.bounds == pytest.approx((21, 21, 40, 40), abs=0.1)


def test_a_compass_word_of_a_part_keeps_its_direction():
    """South-west of the end of a street is not at its end."""
    town = city(street("Main St", (-60, 0), (105, 0)))
    end = StreetPart("end", WEST)
    beyond = term(town, "south", "MainSt", part=end)
    assert (beyond.width, beyond.compass_rad) == ("directed", -math.pi / 2)
    assert term(town, "west", "MainSt", part=end).width == "contact"


def test_the_middle_of_a_block_is_its_middle_half():
    region = part_region(two_by_two(), ("NorthSt",), StreetPart("mid-block"))
    assert region.bounds == pytest.approx((-20, 21, 20, 59), abs=0.1)


def test_ends_of_a_street():
    town = city(street("Main St", (-60, 0), (105, 0)), street("Side St", (0, -105), (0, 105)))
    assert part_region(town, ("MainSt",), StreetPart("end")).centroid.x == pytest.approx(-60)
    east = part_region(town, ("MainSt",), StreetPart("end", 0.0))
    assert east.centroid.x > 90


def test_a_number_is_interpolated():
    region = part_region(numbered(), ("MainSt",), StreetPart("number", number=106))
    assert region.centroid.coords[0] == pytest.approx((-20, 10))
    assert part_region(numbered(), ("MainSt",), StreetPart("number", number=300)) is None


def test_the_block_of_a_house():
    region = part_region(two_by_two(house("House", 20, 20)), ("House",), StreetPart("block"))
    assert region.area == pytest.approx(6400 - 64)


@pytest.mark.parametrize("name", bundled_maps())
@pytest.mark.parametrize(
    "part",
    [
        *(StreetPart(kind) for kind in ("side", "corner", "mid-block", "end", "block")),
        *(StreetPart(kind, SOUTHWEST) for kind in ("side", "corner", "block-corner", "end")),
        StreetPart("number", number=1200),
    ],
)
def test_regions_of_bundled_maps_are_sound(name, part):
    bundled = load_map(name)
    for axis in street_network(bundled).streets:
        found = part_region(bundled, axis.ids[:1], part)
        assert found is None or (found.is_valid and found.area > 0)


def test_a_part_takes_the_place_of_a_direction():
    """On the north side one is there, not north of it: far north is as false as far south."""
    town = two_by_two()
    side = term(town, "north", "NorthSt", part=StreetPart("side", NORTH))
    assert (side.width, side.compass_rad, side.directions(None)) == ("contact", None, None)
    near, beyond = (town.grid.cell_at(0, y) for y in (50, 95))
    table = belief(
        SpatialRelation("Car", "north", ("NorthSt",), part=StreetPart("side", NORTH)), town
    )
    assert table[near] > 20 * table[beyond]
    assert table[near] > 5 * table[town.grid.cell_at(0, 30)]


def test_a_part_that_the_map_has_not_leaves_the_street():
    town = city(street("Lone St", (-60, 0), (60, 0)))
    whole = SpatialRelation("Car", "on", ("LoneSt",))
    part = replace(whole, part=StreetPart("corner"))
    assert not term(town, "on", "LoneSt", part=part.part).has_part
    assert np.array_equal(belief(whole, town), belief(part, town))


def test_front_and_the_papers_presets_know_no_parts():
    town = two_by_two(house("House", 20, 20))
    part = StreetPart("block")
    assert not term(town, "front", "House", part=part).has_part
    near = SpatialRelation("Car", "near", ("House",))
    tables = [belief(one, town, "sloop-m4") for one in (near, replace(near, part=part))]
    assert np.array_equal(*tables)


def test_a_street_is_measured_from_its_carriageway_and_axis():
    """Square to a street that runs askew, and 0 on it; cells alone would make steps."""
    town = city(street("Slant St", (-100, -50), (100, 50), width_m=10.0))
    slant = term(town, "north", "SlantSt")
    x, y = slant.place_m.unbind(-1)
    inside = (x.abs() < 80) & (y.abs() < 80)
    away = (y - x / 2) / math.hypot(1, 0.5)
    expected = (away.abs() - 5).clamp_min(0)
    assert float((slant.off_street_m - expected)[inside].abs().max()) < 1e-9
    normal = math.atan2(1, -0.5)
    off = inside & slant.has_direction
    turned = (slant.outward_rad - normal).cos() * away.sign()
    assert float((turned[off] - 1).abs().max()) < 1e-9


def test_speakers_place_themselves_less_closely():
    """`own_place` widens words that stand away from a house, `own_lapse` is theirs alone."""
    town = city(house("House", 0, 0, 10.0), street("Main St", (-105, -60), (105, -60)))
    model = preset("bayes")
    far = town.grid.cell_at(0, 90)
    for word in ("near", "north"):
        car = belief(SpatialRelation("Car", word, ("House",)), town)
        own = belief(SpatialRelation(SPEAKER, word, ("House",)), town)
        assert own[far] > 2 * car[far]
    own = term(town, "at", "House", figure=SPEAKER)
    assert model.lapse_of(own) == model.own_lapse
    assert model.lapse_of(term(town, "at", "House")) == model.lapse
    assert preset("sloop").lapse_of(own) == 0.0
