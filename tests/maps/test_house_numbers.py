"""House numbers along a street."""

from __future__ import annotations

import numpy as np
import pytest

from sloop_ppl.maps import house_numbers, load_map, street_tables
from tests.streets import city, house, street, two_by_two


def numbered(*extra):
    """Even numbers from 100 north of the street, odd ones south, 20 m for two numbers."""
    houses = [
        house(f"H{n}", -80 + 10 * (n - 100), 20 if n % 2 == 0 else -20, house_number=str(n))
        for n in (100, 101, 104, 107, 108, 112)
    ]
    return city(street("Main St", (-105, 0), (105, 0)), *houses, *extra)


def test_sides_and_places_of_numbers():
    numbers = house_numbers(numbered(), "MainSt")
    assert numbers.numbers.tolist() == [100, 101, 104, 107, 108, 112]
    assert numbers.even_on_left is True
    # 105 lies between 101 and 107 on the south side, 4 m of carriageway and 6 m away.
    assert numbers.locate(105) == pytest.approx((-30, -10))
    assert numbers.locate(106) == pytest.approx((-20, 10))
    assert numbers.locate(112) == pytest.approx((40, 10))
    assert numbers.locate(114) is None
    assert numbers.locate(98) is None


def test_numbers_of_cells():
    town = numbered()
    edge = street_tables(town, "MainSt").edge
    table = house_numbers(town, "MainSt").at(edge.along_m, edge.on_left)
    assert table.shape == town.grid.shape
    assert table[town.grid.cell_at(-20, 20)] == pytest.approx(106)
    assert table[town.grid.cell_at(-20, -20)] == pytest.approx(106)
    # South of the street the last number known is 107, at x = -10.
    assert np.isnan(table[town.grid.cell_at(20, -20)])
    assert table[town.grid.cell_at(20, 20)] == pytest.approx(110)


def test_a_number_of_another_street_is_left_out():
    odd_one = house("Other", -60, 22, house_number="700")
    numbers = house_numbers(numbered(odd_one), "MainSt")
    assert numbers.locate(106) == pytest.approx((-20, 10))
    assert numbers.locate(700) is None


def test_numbers_may_fall_and_sides_may_not_tell():
    houses = [house(f"H{n}", 90 - 10 * n, 20, house_number=n) for n in (1, 2, 4, 7)]
    numbers = house_numbers(city(street("Main St", (-105, 0), (105, 0)), *houses), "MainSt")
    assert numbers.even_on_left is None
    assert numbers.locate(3) == pytest.approx((60, 0))


def test_an_address_says_which_street():
    corner = house("Corner", 30, 33, addresses=["5 East Avenue", "North Street 12", "no number"])
    town = two_by_two(corner, house("Home", 0, 30, **{"addr:street": "South Street",
                                                    "house_number": "22-24"}))  # fmt: skip
    assert house_numbers(town, "EastAve").numbers.tolist() == [5]
    assert house_numbers(town, "NorthSt").numbers.tolist() == [12]
    assert house_numbers(town, "SouthSt") is None  # it stands 70 m from the street of its address
    assert house_numbers(town, "WestAve") is None
    assert house_numbers(town, "Home") is None
    one = house_numbers(town, "EastAve")
    assert one.locate(5) == pytest.approx((40, 33))
    assert one.locate(7) is None


def test_numbers_that_are_none():
    town = city(
        street("Main St", (-105, 0), (105, 0)),
        house("A", 0, 10, house_number="none"),
        house("B", 0, -10, addresses=[7, "", None]),
    )
    assert house_numbers(town, "MainSt") is None


def test_numbers_of_a_bundled_map():
    cleveland = load_map("cleveland")
    numbers = house_numbers(cleveland, "West6thSt")
    assert numbers.even_on_left is not None
    # Known numbers are where their buildings are, those between them between.
    x, y = numbers.locate(1220)
    bradley = cleveland.landmark("TheBradley").geometry.centroid
    assert np.hypot(x - bradley.x, y - bradley.y) < 30
    low, between, high = (np.array(numbers.locate(n)) for n in (1220, 1250, 1280))
    assert np.hypot(*(between - (low + high) / 2)) < 3
    # 700 is a number of West Saint Clair Avenue, at whose corner the building stands.
    assert numbers.locate(800) is None
