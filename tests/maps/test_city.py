"""What a map answers about its landmarks: hand-made blocks, and the bundled cities."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Point, box

from sloop_ppl.errors import MapError, UnknownName
from sloop_ppl.maps import CityMap, Grid, Landmark, bundled_maps, load_map

GRID = Grid.square(50, 5)


def city(*landmarks, grid=GRID):
    return CityMap("block", grid, landmarks)


HALL = Landmark("Hall", "building", box(-20, -10, 0, 10), name="Old Hall")
MAIN = Landmark("MainSt", "street", LineString([(-50, -25), (50, -25)]), width_m=12)
CAFE = Landmark("Cafe", "poi", Point(-1, 0), within="Hall")
SHOP = Landmark("Shop", "poi", Point(-19, 9))
TREE = Landmark("Tree", "poi", Point(31, 31))
BLOCK = city(HALL, MAIN, CAFE, SHOP, TREE)


def test_landmarks_are_found_by_id_and_kind():
    assert "Hall" in BLOCK
    assert "Hal" not in BLOCK
    assert BLOCK.landmark("Hall") is HALL
    assert BLOCK.of_kind("poi", "street") == (MAIN, CAFE, SHOP, TREE)
    assert BLOCK.counts() == {"building": 1, "street": 1, "poi": 3}
    assert (HALL.label, MAIN.label) == ("Old Hall", "MainSt")


def test_an_unknown_landmark_is_told_with_the_nearest():
    with pytest.raises(UnknownName) as caught:
        BLOCK.landmark("Halle")
    assert str(caught.value) == (
        "Landmark of map block 'Halle' is unknown; expected one of Hall, MainSt, Cafe, Shop, Tree; "
        "did you mean 'Hall'?"
    )


def test_a_poi_takes_the_cells_of_its_building_named_or_containing():
    assert (BLOCK.cells("Cafe") == BLOCK.cells("Hall")).all()
    assert (BLOCK.cells("Shop") == BLOCK.cells("Hall")).all()
    assert BLOCK.centroid("Shop") == (-10, 0)


def test_a_poi_in_the_open_takes_its_own_cell():
    cells = BLOCK.cells("Tree")
    assert cells.sum() == 1
    assert cells[GRID.cell_at(31, 31)]


def test_a_poi_with_an_outline_of_its_own_keeps_it():
    campus = Landmark("Campus", "poi", box(10, 10, 40, 40))
    assert city(HALL, campus).cells("Campus").sum() > 36


@pytest.mark.parametrize(("width", "rows"), [(None, 2), (3, 2), (12, 4), (16, 4)])
def test_a_line_is_widened_to_its_width_or_a_cell(width, rows):
    # Rows lie on multiples of five metres; the line runs down the middle of the border at -25.
    street = Landmark("S", "street", LineString([(-50, -25), (50, -25)]), width_m=width)
    footprint = city(street).footprint("S")
    _, south, _, north = footprint.bounds
    assert north - south == pytest.approx(max(width or 0, 5))
    assert city(street).cells("S")[:, 10].sum() == rows


def test_fields_of_a_point_by_hand():
    fields = BLOCK.fields("Tree")
    row, col = GRID.cell_at(31, 31)
    assert fields.distance_m[row, col] == 0
    assert fields.distance_m[row - 3, col - 4] == pytest.approx(25)  # a 3-4-5 triangle of cells
    assert tuple(fields.nearest[:, row - 3, col - 4]) == (row, col)
    # Bearings are from the point itself, here 1.5 m west and south of its cell's centre.
    x, y = GRID.centre_of(row - 3, col)
    assert fields.bearing_rad[row - 3, col] == pytest.approx(math.atan2(y - 31, x - 31))
    assert fields.from_centroid_m[row - 3, col] == pytest.approx(math.hypot(x - 31, y - 31))
    assert fields.extent_m == 0
    assert BLOCK.fields("Hall").extent_m == 20


@settings(max_examples=25, deadline=None)
@given(st.floats(-45, 30), st.floats(-45, 30), st.floats(1, 15), st.floats(1, 15))
def test_distance_is_to_the_nearest_cell_by_brute_force(west, south, wide, high):
    block = city(Landmark("A", "building", box(west, south, west + wide, south + high)))
    fields = block.fields("A")
    taken = np.argwhere(block.cells("A"))
    rows, cols = np.indices(GRID.shape)
    gaps = np.hypot(rows[..., None] - taken[:, 0], cols[..., None] - taken[:, 1]).min(axis=-1)
    assert np.allclose(fields.distance_m, gaps * GRID.cell_m)
    assert ((fields.distance_m == 0) == block.cells("A")).all()
    reached = block.cells("A")[fields.nearest[0], fields.nearest[1]]
    assert reached.all()


def test_translating_a_block_translates_its_fields():
    moved = city(Landmark("Hall", "building", box(-15, 0, 5, 20)))
    assert np.allclose(
        moved.fields("Hall").distance_m[2:, 1:], BLOCK.fields("Hall").distance_m[:-2, :-1]
    )
    assert np.allclose(
        moved.fields("Hall").bearing_rad[2:, 1:], BLOCK.fields("Hall").bearing_rad[:-2, :-1]
    )


def test_the_front_looks_to_the_nearest_path():
    assert BLOCK.bearing_to_nearest_path("Hall") == pytest.approx(-math.pi / 2)
    lane = Landmark("Lane", "service", LineString([(5, -50), (5, 50)]))
    assert city(HALL, MAIN, lane).bearing_to_nearest_path("Hall") == pytest.approx(0)


def test_a_path_does_not_face_itself():
    lane = Landmark("Lane", "pedestrian", LineString([(-50, 40), (50, 40)]))
    assert city(MAIN, lane).bearing_to_nearest_path("MainSt") == pytest.approx(math.pi / 2)
    assert city(MAIN).bearing_to_nearest_path("MainSt") is None
    assert city(HALL).bearing_to_nearest_path("Hall") is None


def test_a_path_through_the_centroid_gives_no_front():
    through = Landmark("Arcade", "pedestrian", LineString([(-10, -50), (-10, 50)]))
    assert city(HALL, through).bearing_to_nearest_path("Hall") is None


def test_the_nearest_landmark():
    found, distance = BLOCK.nearest(-10, -16, BLOCK.of_kind("street", "building"))
    # The street is drawn 12 m wide: its near edge is at -19, the hall's at -10.
    assert (found.id, distance) == ("MainSt", pytest.approx(3))
    assert BLOCK.nearest(-10, 0, [HALL, MAIN]) == (HALL, 0)
    assert BLOCK.nearest(0, 0, []) is None


def test_the_same_landmarks_on_other_cells():
    finer = BLOCK.with_grid(Grid.square(50, 2.5))
    assert finer.cells("Hall").shape == (41, 41)
    assert finer.landmarks == BLOCK.landmarks
    assert BLOCK.cells("Hall").shape == (21, 21)
    assert finer.digest != BLOCK.digest
    assert finer.with_grid(GRID).digest == BLOCK.digest


def test_a_map_survives_pickling():
    again = pickle.loads(pickle.dumps(BLOCK))
    assert again.digest == BLOCK.digest
    assert (again.cells("Cafe") == BLOCK.cells("Cafe")).all()


def test_ids_are_unique():
    with pytest.raises(MapError) as caught:
        city(HALL, MAIN, HALL)
    assert str(caught.value) == "Map 'block' has two features with id 'Hall'; ids are unique"
    assert (caught.value.feature, caught.value.field) == ("Hall", "id")


def test_a_poi_stands_within_something_known():
    with pytest.raises(MapError) as caught:
        city(CAFE)
    assert str(caught.value) == (
        "Feature 'Cafe' of map 'block': field 'within' names 'Hall', which is not on the map"
    )
    assert (caught.value.feature, caught.value.field) == ("Cafe", "within")


@pytest.mark.parametrize("name", bundled_maps())
def test_every_landmark_of_a_bundled_city_has_cells_and_fields(name):
    bundled = load_map(name)
    assert bundled.grid.shape == (41, 41)
    for landmark in bundled.landmarks:
        fields = bundled.fields(landmark.id)
        cells = bundled.cells(landmark.id)
        assert cells.any()
        assert ((fields.distance_m == 0) == cells).all()
        for array in (fields.bearing_rad, fields.from_centroid_m, fields.distance_m):
            assert array.shape == (41, 41)
            assert np.isfinite(array).all()
        if landmark.within:
            assert (cells == bundled.cells(landmark.within)).all()
