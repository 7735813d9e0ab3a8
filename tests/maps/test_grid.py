"""Cells, metres and degrees: conversions that must agree with one another and with the contract."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sloop_ppl.errors import InputError, OutsideMap
from sloop_ppl.maps import Grid, load_map

metres = st.floats(-500, 500, allow_nan=False)
sides = st.floats(1, 400, allow_nan=False)
cells = st.sampled_from([0.5, 1.0, 2.5, 3.0, 5.0, 7.3, 10.0])


@st.composite
def grids(draw):
    west, south = draw(metres), draw(metres)
    return Grid(west, south, west + draw(sides), south + draw(sides), draw(cells))


@st.composite
def places(draw):
    grid = draw(grids())
    across, up = draw(st.floats(0, 1)), draw(st.floats(0, 1))
    x = min(grid.west_m + across * (grid.east_m - grid.west_m), grid.east_m)
    y = min(grid.south_m + up * (grid.north_m - grid.south_m), grid.north_m)
    return grid, x, y


def test_the_published_grid():
    grid = Grid.square(100)
    assert grid.shape == (41, 41)
    assert grid.size == 1681
    # The cells are laid from the north-west corner and overhang in the east and the south.
    assert grid.cells_extent_m == (-100, -105, 105, 100)
    assert (grid.x_m[0], grid.x_m[-1]) == (-97.5, 102.5)
    assert (grid.y_m[0], grid.y_m[-1]) == (-102.5, 97.5)


@pytest.mark.parametrize(
    ("place", "row_from_north", "col"),
    [
        ((-100, 100), 0, 0),
        ((100, 100), 0, 40),
        ((-100, -100), 40, 0),
        ((100, -100), 40, 40),
        ((0, 0), 20, 20),
        ((-37.5, -72.5), 34, 12),
        # A place on a border between cells belongs to the eastern and the southern one.
        ((-95, 95), 1, 1),
        ((-95.001, 95.001), 0, 0),
    ],
)
def test_cells_of_hand_picked_places(place, row_from_north, col):
    grid = Grid.square(100)
    row, found = grid.cell_at(*place)
    assert (grid.row_from_north(row), found) == (row_from_north, col)


@pytest.mark.parametrize(
    ("cell_m", "n"), [(5, 41), (0.1, 2001), (2.5, 81), (3, 67), (200, 2), (300, 1)]
)
def test_number_of_cells(cell_m, n):
    assert Grid.square(100, cell_m).shape == (n, n)


def test_extents_need_not_be_square():
    grid = Grid(-10, 0, 20, 12, 5)
    assert grid.shape == (3, 7)
    assert grid.extent_m == (-10, 0, 20, 12)
    assert grid.cell_at(20, 0) == (0, 6)
    assert grid.cell_at(-10, 12) == (2, 0)


@given(places())
def test_a_place_lies_in_its_cell(given_place):
    grid, x, y = given_place
    row, col = grid.cell_at(x, y)
    assert 0 <= row < grid.n_rows
    assert 0 <= col < grid.n_cols
    centre_x, centre_y = grid.centre_of(row, col)
    assert abs(centre_x - x) <= grid.cell_m / 2 + 1e-6
    assert abs(centre_y - y) <= grid.cell_m / 2 + 1e-6


def test_the_overhang_covers_places_beyond_the_extent():
    grid = Grid(0, 0, 12, 13)  # 3 x 3 cells, from 0 to 15 in the east, from -2 to 13 in the north
    assert grid.cell_covering(14.9, -1.9) == (0, 2)
    assert grid.cell_covering(0, 13) == (2, 0)
    assert grid.cell_covering(12, 0) == grid.cell_at(12, 0) == (0, 2)
    for place in ((15.0, 3.0), (-0.1, 3.0), (3.0, 13.1), (3.0, -2.0)):
        with pytest.raises(OutsideMap) as error:
            grid.cell_covering(*place)
        assert str(error.value) == (
            f"Place ({place[0]:g}, {place[1]:g}) is off the map; expected x in [0, 15) and y in "
            "(-2, 13], metres"
        )


@pytest.mark.parametrize(("row", "col"), [(-1, 0), (3, 0), (0, -1), (0, 4)])
def test_a_cell_outside_the_grid_has_no_centre(row, col):
    with pytest.raises(OutsideMap) as error:
        Grid(0, 0, 19, 14).centre_of(row, col)
    assert str(error.value) == (
        f"Cell ({row}, {col}) is outside the grid; expected a row in [0, 3) and a column in [0, 4)"
    )


@given(grids(), st.data())
def test_centres_lie_in_their_own_cells(grid, data):
    row = data.draw(st.integers(0, grid.n_rows - 1))
    col = data.draw(st.integers(0, grid.n_cols - 1))
    x, y = grid.centre_of(row, col)
    if grid.contains(x, y):
        assert grid.cell_at(x, y) == (row, col)
    else:  # only on the overhang
        assert row == 0 or col == grid.n_cols - 1


@given(grids())
def test_cells_cover_the_extent_and_overhang_by_less_than_one(grid):
    west, south, east, north = grid.cells_extent_m
    assert (west, north) == (grid.west_m, grid.north_m)
    for overhang in (east - grid.east_m, grid.south_m - south):
        assert -1e-6 <= overhang <= grid.cell_m + 1e-6


@given(st.floats(-85, 85), st.floats(-179, 179), st.floats(-2000, 2000), st.floats(-2000, 2000))
def test_degrees_round_trip(lat, lon, x, y):
    grid = Grid.square(100, centre=(lat, lon))
    back = grid.from_lonlat(*grid.to_lonlat(x, y))
    # PROJ takes what is within 1e-10 radians, 0.6 mm, of the centre to be the centre.
    assert np.allclose(back, (x, y), atol=1e-3)


def test_north_is_up_and_a_degree_of_latitude_is_its_length():
    grid = Grid.square(100, centre=(41.5, -81.7))
    lon, lat = grid.to_lonlat([0, 0, 100], [0, 100, 0])
    assert (float(lon[0]), float(lat[0])) == pytest.approx((-81.7, 41.5))
    # A metre of latitude at 41.5 degrees on WGS84: 111 064 m a degree.
    assert float(lat[1] - lat[0]) == pytest.approx(100 / 111_064, rel=1e-4)
    assert float(lon[2] - lon[0]) == pytest.approx(
        100 / (111_320 * math.cos(math.radians(41.5))), rel=2e-3
    )


def test_a_published_cell_has_the_published_degrees():
    # Those were computed on a sphere: 0.2 m of difference at this distance from the centre.
    lon, lat = load_map("cleveland").grid.to_lonlat(-37.5, -72.5)
    assert (float(lon), float(lat)) == pytest.approx((-81.6995143, 41.4998068), abs=2e-6, rel=0)


def test_a_grid_that_is_nowhere_has_no_degrees():
    with pytest.raises(InputError) as caught:
        Grid.square(100).to_lonlat(0, 0)
    assert str(caught.value) == ("This grid has no centre on earth; give Grid a centre=(lat, lon)")


@pytest.mark.parametrize("place", [(100.001, 0), (0, -100.001), (math.nan, 0), (0, math.inf)])
def test_a_place_outside_is_refused(place):
    grid = Grid.square(100)
    assert not grid.contains(*place)
    with pytest.raises(OutsideMap) as caught:
        grid.cell_at(*place)
    assert str(caught.value) == (
        f"Place ({place[0]:g}, {place[1]:g}) is outside the map; expected x in [-100, 100] and "
        "y in [-100, 100] metres from the map's centre"
    )


@pytest.mark.parametrize(
    "numbers",
    [
        (0, 0, 0, 10, 5),
        (0, 10, 10, 0, 5),
        (0, 0, 10, 10, 0),
        (0, 0, 10, 10, -1),
        (0, 0, math.nan, 10, 5),
        (0, 0, 10, math.inf, 5),
        (0, 0, 10, 10, math.nan),
    ],
)
def test_a_grid_that_makes_no_sense_is_refused_in_one_line(numbers):
    with pytest.raises(InputError) as caught:
        Grid(*numbers)
    assert "\n" not in str(caught.value)


def test_a_grid_has_fifty_million_cells_at_most():
    fits = Grid(0, 0, 4999, 9999, 1.0)  # 5,000 x 10,000 cells
    assert fits.size == 50_000_000
    assert Grid(0, 0, 1, 1, 1e-3).size == 1001**2  # small cells count, not metres
    with pytest.raises(InputError) as caught:
        Grid(0, 0, 5000, 9999, 1.0)
    assert str(caught.value) == (
        "Grid would have 5e+07 cells; expected 50,000,000 at most: give a larger cell_m or a "
        "smaller extent"
    )


def test_a_place_in_a_cell_lies_inside_the_extent():
    grid = Grid(0, 0, 12, 13)  # cells overhang to 15 in the east and to -2 in the south
    assert grid.place_in(1, 1) == grid.centre_of(1, 1) == (7.5, 5.5)
    assert grid.place_in(0, 2) == (12, 0.5)
    assert Grid(0, 0, 6, 6).place_in(0, 1) == (6, 0)


def test_borders_are_inside_the_extent():
    grid = Grid(-1, -2, 3, 4)
    for place in ((-1, 0), (3, 0), (0, -2), (0, 4)):
        assert grid.contains(*place)
    for place in ((-1.1, 0), (3.1, 0), (0, -2.1), (0, 4.1)):
        assert not grid.contains(*place)


def test_coordinates_of_a_grid_that_is_far_off_its_origin():
    grid = Grid(100, 200, 108, 206, 4)  # 2 rows, 3 columns
    assert grid.x_m.tolist() == [102, 106, 110]
    assert grid.y_m.tolist() == [200, 204]
    assert grid.cells_extent_m == (100, 198, 112, 206)
    assert grid.cell_covering(109, 199) == (0, 2)
    assert grid.row_from_north(0) == 1
