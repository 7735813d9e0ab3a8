"""How cells lie to streets, corners and blocks, on hand-solved maps."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from sloop_ppl.maps import (
    CityMap,
    Grid,
    block_table,
    bundled_maps,
    edge_tables,
    load_map,
    quadrant_table,
    street_network,
    street_tables,
)
from tests.streets import GRID, city, house, street, two_by_two

NORTH, SOUTH, EAST, WEST = math.pi / 2, -math.pi / 2, 0.0, math.pi


def at(table, x, y):
    return table[GRID.cell_at(x, y)].item()


def test_distance_to_axis_carriageway_and_crossing():
    tables = street_tables(two_by_two(), "NorthSt")
    assert at(tables.axis_m, 0, 0) == pytest.approx(40)
    assert at(tables.carriageway_m, 0, 0) == pytest.approx(36)  # the street is 8 m wide
    assert at(tables.carriageway_m, 0, 40) == 0
    assert at(tables.crossing_m, 0, 40) == pytest.approx(40)
    assert at(tables.crossing_m, 80, 10) == pytest.approx(50)
    east, north = tables.offset_m
    assert at(east, 0, 70) == pytest.approx(0)
    assert at(north, 0, 70) == pytest.approx(30)


def test_sides_of_a_street():
    tables = street_tables(two_by_two(), "NorthSt")
    assert at(tables.side(NORTH), 10, 70) == pytest.approx(1)
    assert at(tables.side(NORTH), 10, 0) == at(tables.side(SOUTH), 10, 70) == pytest.approx(-1)
    assert at(tables.side(EAST), 10, 70) == pytest.approx(0)
    assert at(tables.side(NORTH), 10, 40) == 0  # on the axis
    west = street_tables(two_by_two(), "WestAvenue")
    assert at(west.side(WEST), -90, 20) == at(west.side(EAST), 0, 20) == pytest.approx(1)


def test_a_street_askew_has_two_sides_that_are_half_north():
    tables = street_tables(city(street("A St", (-105, -105), (105, 105))), "ASt")
    assert at(tables.side(NORTH), -20, 20) == pytest.approx(math.sqrt(0.5))
    assert at(tables.side(EAST), -20, 20) == pytest.approx(-math.sqrt(0.5))


def test_between_two_carriageways_is_no_side():
    road = [
        street("Main St", (-105, 10), (105, 10), id="MainEast"),
        street("Main St", (105, -10), (-105, -10), id="MainWest"),
    ]
    tables = street_tables(city(*road), "MainWest")
    assert at(tables.in_median, 0, 0)
    assert at(tables.side(NORTH), 0, 0) == at(tables.carriageway_m, 0, 0) == 0
    assert at(tables.side(NORTH), 0, 30) == pytest.approx(1)
    assert at(tables.side(NORTH), 0, -30) == pytest.approx(-1)
    assert at(tables.carriageway_m, 0, -30) == pytest.approx(16)
    assert not at(tables.in_median, 0, 30)


def test_position_along_the_edge_of_a_block():
    position = street_tables(two_by_two(), "NorthSt").edge.position
    assert at(position, 0, 50) == pytest.approx(0.5)
    assert at(position, -40, 50) == at(position, 40, 30) == pytest.approx(0)
    assert at(position, 20, 50) == at(position, -20, 30) == pytest.approx(0.25)
    # Beyond the corner the border cuts the block: 65 m of it are seen.
    assert at(position, 53, 40) == pytest.approx(15 / 65)
    assert at(position, 100, 40) == pytest.approx(0.5)


def test_the_nearest_street_tells_where_along_the_edge_one_is():
    tables = edge_tables(two_by_two())
    north, west = 1, 2
    assert at(tables.street, 0, 30) == north
    assert at(tables.street, -30, 0) == west
    assert at(tables.position, 10, 30) == pytest.approx(0.375)
    assert at(tables.position, -35, 35) == pytest.approx(5 / 80)
    network = street_network(two_by_two())
    stretch = network.stretches[at(tables.stretch, 10, 30)]
    assert (stretch.street, round(stretch.line.length)) == (north, 80)
    assert at(tables.on_left, 10, 50)
    assert not at(tables.on_left, 10, 30)


def test_a_dead_end_ends_a_stretch_as_a_corner_does():
    tables = street_tables(two_by_two(street("Short Ln", (-40, 0), (0, 0))), "ShortLn")
    assert at(tables.edge.position, -20, 5) == pytest.approx(0.5)
    assert at(tables.edge.position, 20, 0) == pytest.approx(0)


def test_numbers_of_blocks():
    table = block_table(two_by_two())
    assert len(np.unique(table)) == 9
    assert at(table, -100, -100) == 0
    assert at(table, 0, 0) == at(table, 35, -35)
    assert at(table, 0, 0) != at(table, 50, 0)
    # A cell whose centre lies on an axis is in one of the blocks beside it.
    assert at(table, 0, 40) in (at(table, 0, 0), at(table, 0, 60))


def test_cells_that_overhang_the_border_are_in_the_blocks_there():
    square = Grid.square(100.0)
    bare = two_by_two()
    table = block_table(CityMap("toy", square, bare.landmarks))
    assert table.shape == (41, 41)
    assert (table >= 0).all()


def test_quadrants_of_a_crossing():
    network = street_network(two_by_two())
    (crossing,) = network.crossings_of("NorthSt", "WestAve")
    south_west = quadrant_table(GRID, crossing, math.radians(225))
    assert at(south_west, -50, 30)
    assert not any((at(south_west, -30, 30), at(south_west, -50, 50), at(south_west, -30, 50)))
    whole = sum(quadrant_table(GRID, crossing, math.radians(45 + 90 * k)).astype(int)
                for k in range(4))  # fmt: skip
    # Each cell is in one quadrant; those on the arms may be in two.
    assert whole.min() >= 1
    assert (whole > 1).mean() < 0.06


@pytest.mark.parametrize("landmark", ["House", "LoneSt", "NoSuchThing"])
def test_what_is_no_street_has_empty_tables(landmark):
    tables = street_tables(city(house("House", 0, 0)), landmark)
    assert np.isinf(tables.axis_m).all()
    assert np.isinf(tables.carriageway_m).all()
    assert np.isinf(tables.crossing_m).all()
    assert (tables.side(NORTH) == 0).all()
    assert np.isnan(tables.edge.position).all()
    assert (tables.edge.stretch == -1).all()
    assert (edge_tables(city()).street == -1).all()


def test_a_street_without_crossings_has_no_corner():
    through = street_tables(city(street("Lone St", (-105, 0), (105, 0))), "LoneSt")
    assert np.isinf(through.crossing_m).all()
    assert np.isnan(through.edge.position).all()
    assert at(through.side(NORTH), 0, 50) == pytest.approx(1)


@pytest.mark.parametrize("name", bundled_maps())
def test_tables_of_bundled_maps_by_brute_force(name):
    bundled = load_map(name)
    network = street_network(bundled)
    x, y = np.meshgrid(bundled.grid.x_m, bundled.grid.y_m)
    centres = shapely.points(x, y)
    for axis in network.streets:
        tables = street_tables(bundled, axis.ids[0])
        assert np.allclose(tables.axis_m, shapely.distance(centres, axis.lines))
        assert np.allclose(np.hypot(*tables.offset_m), tables.axis_m)
        along = np.stack([shapely.line_locate_point(s, centres) for s in axis.spines])
        assert np.isclose(along, tables.edge.along_m, atol=1e-6).any(axis=0).mean() > 0.99
    edges = edge_tables(bundled)
    known = ~np.isnan(edges.position)
    assert known.mean() > 0.5
    assert edges.position[known].min() >= 0
    assert edges.position[known].max() <= 0.5


@settings(max_examples=20, deadline=None)
@given(
    points=st.lists(
        st.tuples(st.integers(-90, 90), st.integers(-90, 90)), min_size=2, max_size=5, unique=True
    ),
    crossing=st.tuples(st.integers(-90, 90), st.integers(-90, 90)),
    bearing=st.floats(-3, 3),
)
def test_a_quarter_turn_turns_the_tables(points, crossing, bearing):
    ends = [(-crossing[0], -crossing[1] - 1), crossing]

    def turned(point):
        return -point[1], point[0]

    def tables(turn):
        lines = street("A St", *map(turn, points)), street("B St", *map(turn, ends))
        return street_tables(city(*lines), "ASt")

    here, there = tables(lambda point: point), tables(turned)
    # The grid is square: np.rot90 of rows that count northwards turns clockwise, so k is -1.
    for name in ("axis_m", "carriageway_m"):
        assert np.allclose(np.rot90(getattr(here, name), -1), getattr(there, name), atol=0.1)
    sure = here.axis_m > 0.5
    one, other = np.rot90(here.side(bearing), -1), there.side(bearing + math.pi / 2)
    same = np.isclose(one, other, atol=0.02)
    # Of two places on the axis that are as near either may be taken.
    assert same[np.rot90(sure, -1)].mean() > 0.9


def test_a_kilometre_of_two_thousand_landmarks_takes_under_a_second():
    big = Grid(-500, -500, 500, 500)
    places = np.arange(-450, 451, 60)
    streets = [street(f"Row {y}", (-500, y), (500, y)) for y in places]
    streets += [street(f"Column {x}", (x, -500), (x, 500)) for x in places]
    houses = [house(f"House{i}", -480 + 20 * (i % 49), -480 + 20 * (i // 49)) for i in range(2000)]
    town = CityMap("town", big, (*streets, *houses))
    took = []
    for _ in range(2):
        start = time.process_time()
        street_network(town)
        block_table(town)
        edge_tables(town)
        took.append(time.process_time() - start)
    assert took[0] < 2.0  # 0.6 s on the machine it was written on; others may be slower
    assert took[1] < 0.01
