"""Axes, crossings, stretches and blocks: on hand-solved maps, bundled ones and odd ones."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from sloop_ppl.maps import Grid, Landmark, block_table, bundled_maps, load_map, street_network
from sloop_ppl.maps.street_network import NETWORKS
from tests.streets import GRID, city, house, street, two_by_two


def rounded(points):
    return sorted((round(x, 6), round(y, 6)) for x, y in points)


def degrees(arms):
    return sorted(round(math.degrees(arm.bearing_rad)) % 360 for arm in arms)


def test_lines_of_one_name_are_one_street():
    network = street_network(two_by_two())
    assert [axis.label for axis in network.streets] == [
        "South St",
        "North St",
        "West Ave",
        "East Ave",
    ]
    west = network.street("WestAvenue")
    assert west is network.street("WestAve")
    assert west.ids == ("WestAve", "WestAvenue")
    (spine,) = west.spines
    assert spine.length == pytest.approx(210)
    assert network.street("Nowhere") is None


def test_two_by_two_streets_have_four_crossings_with_four_arms():
    network = street_network(two_by_two())
    assert rounded(c.point_m for c in network.crossings) == [
        (-40, -40), (-40, 40), (40, -40), (40, 40),
    ]  # fmt: skip
    for crossing in network.crossings:
        assert degrees(crossing.arms) == [0, 90, 180, 270]
        assert crossing.is_corner
        assert not crossing.at_border
    (corner,) = network.crossings_of("NorthSt", "WestAvenue")
    assert corner.point_m == pytest.approx((-40, 40))
    assert network.crossings_of("NorthSt", "SouthSt") == ()
    assert network.crossings_of("NorthSt", "Nowhere") == network.crossings_of() == ()
    assert len(network.crossings_of("NorthSt")) == 2


def test_two_by_two_streets_part_nine_blocks():
    network = street_network(two_by_two())
    assert len(network.blocks) == 9
    (middle,) = (block for block in network.blocks if not block.cut)
    assert middle.polygon.area == pytest.approx(6400)
    assert middle.streets == (0, 1, 2, 3)
    assert middle.corners == (0, 1, 2, 3)
    assert [block.number for block in network.blocks] == list(range(9))
    south_west = network.blocks[0]
    assert south_west.streets == (0, 2)
    assert south_west.corners == (0,)
    corner = network.corner_of(middle, math.radians(45))
    assert corner.point_m == pytest.approx((40, 40))
    # The only corner of the block in the south-west is its north-eastern one.
    assert network.corner_of(south_west, math.radians(45)) is network.crossings[0]
    assert network.corner_of(south_west, math.radians(225)) is None


def test_streets_are_cut_at_corners():
    stretches = street_network(two_by_two()).stretches_of("WestAve")
    assert [round(s.line.length, 3) for s in stretches] == [65, 80, 65]
    assert [(s.start_open, s.end_open) for s in stretches] == [
        (True, False), (False, False), (False, True),
    ]  # fmt: skip
    assert stretches[0].end == stretches[1].start
    assert street_network(two_by_two()).stretches_of("Nowhere") == ()


def test_between_two_crossings():
    network = street_network(two_by_two())
    part = network.between("NorthSt", "WestAve", "EastAve")
    assert rounded(part.coords) == [(-40, 40), (40, 40)]
    assert network.between("NorthSt", "EastAve", "WestAvenue").equals(part)
    assert network.between("NorthSt", "SouthSt", "WestAve") is None
    assert network.between("NorthSt", "WestAve", "WestAve") is None
    assert network.between("Nowhere", "WestAve", "EastAve") is None


def test_ends_of_a_street():
    network = street_network(
        two_by_two(street("Short Ln", (-40, 0), (0, 0)), street("Loose Ln", (60, 0), (80, 0)))
    )
    assert [(end.point_m, end.kind) for end in network.ends("ShortLn")] == [
        ((-40.0, 0.0), "crossing"),
        ((0.0, 0.0), "dead end"),
    ]
    assert {end.kind for end in network.ends("LooseLn")} == {"dead end"}
    assert {end.kind for end in network.ends("EastAve")} == {"border"}
    assert network.ends("Nowhere") == ()


def test_a_dead_end_parts_no_block():
    dead = street_network(two_by_two(street("Short Ln", (-40, 0), (0, 0))))
    assert len(dead.blocks) == 9
    through = street_network(two_by_two(street("Short Ln", (-40, 0), (40, 0))))
    assert len(through.blocks) == 10


def test_a_street_drawn_up_to_the_kerb_of_another_ends_on_it():
    # 4 m of carriageway and a little: the drawing stops short of the axes.
    network = street_network(two_by_two(street("Short Ln", (-33, 0), (34, 0))))
    assert len(network.blocks) == 10
    (crossing,) = network.crossings_of("ShortLn", "WestAve")
    assert crossing.point_m == pytest.approx((-40, 0), abs=0.05)
    # Twenty metres short is a dead end.
    assert len(street_network(two_by_two(street("Short Ln", (-20, 0), (34, 0)))).blocks) == 9


def test_which_ways_part_blocks():
    def blocks(kind, name="Cut", **properties):
        way = street("Cut", (-40, 0), (40, 0), kind=kind, **properties)
        return len(street_network(two_by_two(replace(way, name=name))).blocks)

    assert blocks("street") == blocks("street", None) == 10
    assert blocks("service") == blocks("pedestrian") == 10
    assert blocks("service", None) == blocks("pedestrian", None) == 9
    assert blocks("pedestrian", highway="footway") == 9
    assert blocks("pedestrian", highway="pedestrian") == 10


def test_a_divided_road_is_one_street_with_one_crossing():
    road = [
        street("Main St", (-105, 6), (105, 6), id="MainEast"),
        street("Main St", (105, -6), (-105, -6), id="MainWest"),
    ]
    network = street_network(city(*road, street("Side St", (0, -105), (0, 105))))
    (crossing,) = network.crossings
    assert crossing.point_m == pytest.approx((0, 0))
    assert degrees(crossing.arms) == [0, 90, 180, 270]
    assert len(network.streets[0].spines) == 1
    # The strip between the carriageways is no block.
    assert len(network.blocks) == 4
    # Twelve metres between two axes of 8 m carriageways leave a strip of 4 m.
    assert network.streets[0].median.intersection(shapely.box(-50, -50, 50, 50)).area == (
        pytest.approx(400, rel=0.02)
    )


def test_a_street_that_jogs_crosses_once():
    jog = [
        street("Main St", (-105, 0), (105, 0)),
        street("Side St", (0, 0), (0, 105)),
        street("Side Street", (15, 0), (15, -105)),
    ]
    (crossing,) = street_network(city(*jog)).crossings
    assert crossing.point_m == pytest.approx((7.5, 0))


def test_where_a_street_changes_its_name_is_no_corner():
    def crossing(turn):
        other = (20 + 80 * math.cos(turn), 80 * math.sin(turn))
        lines = street("Old St", (-105, 0), (20, 0)), street("New St", (20, 0), other)
        (only,) = street_network(city(*lines)).crossings
        return only

    assert not crossing(math.radians(10)).is_corner
    assert crossing(math.radians(90)).is_corner


def test_the_corner_that_a_bearing_means():
    network = street_network(two_by_two(street("Short Ln", (-40, 0), (0, 0))))
    (grid_corner,) = network.crossings_of("NorthSt", "WestAve")
    assert np.degrees(grid_corner.sector(math.radians(225))) == pytest.approx((180, 270), abs=1)
    (t,) = network.crossings_of("ShortLn", "WestAve")
    assert np.degrees(t.sector(math.radians(45))) == pytest.approx((0, 90), abs=1)
    # Beyond the straight side of the T there is no arm: 90 degrees about the bearing.
    assert np.degrees(t.sector(math.radians(225))) == pytest.approx((180, 270), abs=1)


def test_streets_askew_have_a_northeast_corner_too():
    turn = math.radians(30)
    arms = [(100 * math.cos(turn + k * math.pi / 2), 100 * math.sin(turn + k * math.pi / 2))
            for k in range(4)]  # fmt: skip
    (crossing,) = street_network(
        city(street("A St", arms[0], arms[2]), street("B St", arms[1], arms[3]))
    ).crossings
    assert np.degrees(crossing.sector(math.radians(45))) == pytest.approx((30, 120), abs=1)


def test_a_gap_between_lines_that_point_at_one_another_is_bridged():
    (spine,) = street_network(
        city(street("A St", (-105, 0), (-20, 0)), street("A Street", (20, 0), (105, 0)))
    ).streets[0].spines  # fmt: skip
    assert spine.length == pytest.approx(210)
    beside = street_network(
        city(street("A St", (-105, 0), (-20, 0)), street("A Street", (-20, 50), (-105, 50)))
    ).streets[0]
    assert len(beside.spines) == 2


def test_a_ring_has_no_ends_but_a_block():
    turn = np.linspace(0, 2 * math.pi, 41)[:-1]
    points = [*zip(60 * np.cos(turn), 60 * np.sin(turn), strict=True)]
    ring = street("Ring Rd", *points, points[0])
    network = street_network(city(ring))
    assert network.ends("RingRd") == ()
    assert network.crossings == ()
    assert sorted(round(b.polygon.area) for b in network.blocks)[0] == pytest.approx(11263, abs=20)


@pytest.mark.parametrize(
    "landmarks",
    [
        (),
        (house("House", 0, 0),),
        (Landmark("Path", "pedestrian", shapely.LineString([(-9, 0), (9, 0)])),),
        (Landmark("Plaza", "pedestrian", shapely.box(-9, -9, 9, 9), name="Plaza"),),
    ],
)
def test_a_map_without_streets_has_no_crossings_and_no_blocks(landmarks):
    bare = city(*landmarks)
    network = street_network(bare)
    assert network.crossings == network.stretches == network.blocks == ()
    assert (block_table(bare) == -1).all()


def test_a_street_without_crossings():
    network = street_network(city(street("Lone St", (-50, 0), (50, 0))))
    assert network.crossings_of("LoneSt") == ()
    (only,) = network.stretches_of("LoneSt")
    assert (only.start, only.end, only.start_open) == (None, None, False)
    # It parts nothing: all of the map is one block, which the border cuts.
    (block,) = network.blocks
    assert block.cut


def test_odd_lines_make_no_trouble():
    odd = [
        Landmark("Dot", "street", shapely.LineString([(5, 5), (5, 5)]), name="Dot St"),
        street("Eight St", (-50, -50), (50, 50), (50, -50), (-50, 50)),
        street("Off St", (500, 0), (600, 0)),
        street("...", (-90, 0), (-70, 0), id="Dots"),
        Landmark("High", "street", shapely.LineString([(0, 70, 3), (90, 70, 4)]), name="High St"),
    ]
    network = street_network(city(*odd))
    assert len(network.streets) == len(odd)
    for axis in network.streets:
        network.ends(axis.ids[0])
        network.crossings_of(axis.ids[0])


def test_networks_are_found_once_for_all_maps_of_the_same_streets():
    NETWORKS.clear()
    one = street_network(load_map("denver"))
    assert street_network(load_map("denver")) is one
    wide = two_by_two()
    narrow = replace(
        wide, landmarks=tuple(replace(m, width_m=5.0) for m in wide.landmarks), _cache={}
    )
    assert street_network(wide).streets[0].width_m == 8
    assert street_network(narrow).streets[0].width_m == 5


@pytest.mark.parametrize("name", bundled_maps())
def test_blocks_of_bundled_maps_by_brute_force(name):
    """Cells of one block are those one gets to without stepping over an axis."""
    from scipy.ndimage import label

    bundled = load_map(name, cell_m=1.0)
    network = street_network(bundled)
    x, y = np.meshgrid(bundled.grid.x_m, bundled.grid.y_m)
    free = np.ones(bundled.grid.shape, dtype=bool)
    for axis in network.streets:
        if axis.bounds_blocks:
            shapely.prepare(axis.lines)
            free &= ~shapely.dwithin(axis.lines, shapely.points(x, y), 0.75)
    regions, count = label(free)
    table = block_table(bundled)
    sizes = np.bincount(regions.ravel(), minlength=count + 1)
    matched = set()
    for region in range(1, count + 1):
        if sizes[region] < 400:
            continue
        numbers, times = np.unique(table[regions == region], return_counts=True)
        assert times.max() == times.sum(), (name, numbers)
        if numbers[0] >= 0:
            assert numbers[0] not in matched
            matched.add(int(numbers[0]))
    assert len(matched) >= 4


@pytest.mark.parametrize("name", bundled_maps())
def test_bundled_maps_have_crossings_of_named_streets(name):
    network = street_network(load_map(name))
    assert sum(c.is_corner for c in network.crossings) >= 1
    area = shapely.union_all([block.polygon for block in network.blocks]).area
    assert area == pytest.approx(40_000, rel=0.05)
    for block in network.blocks:
        others = [b.polygon for b in network.blocks if b is not block]
        assert shapely.intersection(block.polygon, shapely.union_all(others)).area < 1e-6


@settings(max_examples=15, deadline=None)
@given(
    places=st.lists(st.integers(-80, 80), min_size=1, max_size=3, unique=True),
    across=st.lists(st.integers(-80, 80), min_size=1, max_size=3, unique=True),
    quarter=st.integers(0, 3),
    shift=st.tuples(st.integers(-500, 500), st.integers(-500, 500)),
)
def test_turned_and_moved_streets_have_turned_and_moved_crossings(places, across, quarter, shift):
    lines = [((-105, y), (105, y)) for y in places] + [((x, -105), (x, 105)) for x in across]

    def moved(point):
        x, y = point
        for _ in range(quarter):
            x, y = -y, x
        return x + shift[0], y + shift[1]

    # The grid lies symmetrically about the origin but for a twentieth of a metre.
    there = Grid(GRID.west_m + shift[0], GRID.south_m + shift[1], GRID.east_m + shift[0],
                 GRID.north_m + shift[1])  # fmt: skip
    here = street_network(city(*(street(f"Street {k}", *ends) for k, ends in enumerate(lines))))
    gone = street_network(
        city(
            *(street(f"Street {k}", *map(moved, ends)) for k, ends in enumerate(lines)),
            grid=there,
        )
    )
    assert np.allclose(
        rounded(moved(c.point_m) for c in here.crossings),
        rounded(c.point_m for c in gone.crossings),
    )
    area = sorted(b.polygon.area for b in here.blocks)
    assert sorted(b.polygon.area for b in gone.blocks) == pytest.approx(area, abs=25)
    lengths = sorted(s.line.length for s in here.stretches)
    assert sorted(s.line.length for s in gone.stretches) == pytest.approx(lengths, abs=0.2)
