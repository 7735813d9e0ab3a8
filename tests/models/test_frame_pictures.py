"""Pictures of what surrounds a landmark, and the streets it may face."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from support.facing_block import facing_town

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import CityMap, Grid, Landmark
from sloop_ppl.models.frames import VIEWS, choices_of, context_image, context_planes, pictures_of
from sloop_ppl.models.frames._pictures import GREYS, PIXELS, PLANES
from sloop_ppl.models.frames._streets import FEATURES, facing_choices
from tests.scenes import point_city, symmetric_grid

GRID = Grid.square(200.0)
COLUMN = {name: i for i, name in enumerate(FEATURES)}


def city(*landmarks):
    return CityMap("block", GRID, landmarks)


def house(name, x, y, half=8.0):
    return Landmark(name, "building", shapely.box(x - half, y - half, x + half, y + half))


def street(name, *places, kind="street", called=None):
    return Landmark(name, kind, shapely.LineString(places), name=called, width_m=8.0)


CROSSING = city(
    house("House", 0, 0),
    house("Next", 30, 0),
    street("Main", (-99, -20), (99, -20), called="Main Street"),
    street("Lane", (-20, -99), (-20, 99), kind="service"),
)


def test_a_picture_has_the_paper_size_and_four_greys():
    image = context_image(CROSSING, "House")
    assert image.shape == (28, 28)
    assert {round(float(v), 2) for v in np.unique(image)} == {0.0, 0.35, 0.7, 1.0}
    assert sorted(GREYS.values()) == [0.0, 0.35, 0.7, 1.0]


def test_the_landmark_is_in_the_middle_and_south_is_row_0():
    ground, streets, paths, buildings = context_planes(CROSSING, "House")
    middle = PIXELS // 2
    assert ground[middle - 1 : middle + 1, middle - 1 : middle + 1].min() == 1
    rows, cols = np.nonzero(streets > 0.4)
    assert rows.max() < middle  # Main Street runs south of the house
    assert cols.min() == 0
    assert cols.max() == PIXELS - 1
    rows, cols = np.nonzero(paths > 0.4)
    assert cols.max() < middle  # the lane runs west of it
    _, cols = np.nonzero(buildings > 0.4)
    assert cols.min() > middle  # the next house stands east of it


def test_shares_add_up_to_the_area_a_landmark_covers_and_its_outline():
    ground = context_planes(CROSSING, "House")[PLANES.index("ground")]
    pixel = (VIEWS["ego-ctx"].side_m / PIXELS) ** 2
    assert ground.sum() * pixel == pytest.approx(16 * 16, rel=0.3)


def test_a_big_landmark_fits_into_its_picture():
    ground = context_planes(city(house("Hall", 0, 0, half=90.0)), "Hall")[0]
    assert ground[0].sum() == ground[:, 0].sum() == 0
    assert ground.sum() > 100


def test_without_context_only_the_landmark_is_drawn():
    planes = context_planes(CROSSING, "House", "ego")
    assert planes[0].sum() > 0
    assert planes[1:].sum() == 0


def test_a_picture_that_is_not_centred_is_the_same_for_all_of_its_tile():
    tile = VIEWS["ctx"]
    assert not tile.centred
    one, two = (context_planes(CROSSING, name, "ctx") for name in ("House", "Next"))
    np.testing.assert_array_equal(one[1:3], two[1:3])  # streets and paths
    assert not np.array_equal(one[0], two[0])


def test_turning_the_scene_turns_the_picture():
    """An anticlockwise quarter turn takes what is south to the east."""
    upright = context_planes(CROSSING, "House")
    turned = context_planes(CROSSING, "House", turn_rad=math.pi / 2)
    np.testing.assert_allclose(np.rot90(upright, -1, (1, 2)), turned, atol=0.51)
    _, cols = np.nonzero(turned[1] > 0.4)
    assert cols.min() >= PIXELS // 2


def test_a_picture_is_the_same_wherever_the_scene_lies():
    moved = city(
        house("House", 24, 16),
        house("Next", 54, 16),
        street("Main", (-75, -4), (123, -4), called="Main Street"),
        street("Lane", (4, -83), (4, 115), kind="service"),
    )
    np.testing.assert_array_equal(context_planes(moved, "House"), context_planes(CROSSING, "House"))


def test_points_and_streets_can_be_looked_at_too():
    lonely = point_city(symmetric_grid(21), Pole=(0.0, 0.0))
    assert context_planes(lonely, "Pole")[0].sum() > 0
    assert context_planes(CROSSING, "Main")[0].sum() > 0


def test_an_unknown_view_or_landmark_is_named():
    with pytest.raises(UnknownName, match="View 'top' is unknown"):
        context_planes(CROSSING, "House", "top")
    with pytest.raises(UnknownName, match="'Hous' is unknown"):
        context_planes(CROSSING, "Hous")


def test_streets_around_come_nearest_first_with_their_direction():
    choices = facing_choices(CROSSING, "House")
    assert np.degrees(choices.bearing_rad) == pytest.approx([-90, 180])
    assert choices.distance_m == pytest.approx([20, 20])
    assert choices.features[:, COLUMN["street"]].tolist() == [1, 0]
    assert choices.features[:, COLUMN["named"]].tolist() == [1, 0]
    assert choices.features[:, COLUMN["nearest named"]].tolist() == [1, 0]


def test_pieces_of_one_name_are_one_street():
    pieces = city(
        house("House", 0, 0),
        street("A", (-90, -20), (-10, -20), called="Main Street"),
        street("B", (-10, -20), (90, -20), called="Main Street"),
    )
    assert np.degrees(facing_choices(pieces, "House").bearing_rad) == pytest.approx([-90])


def test_a_house_in_between_hides_a_street():
    hidden = city(
        house("House", 0, 0),
        house("Wall", 0, 25),
        street("North", (-90, 45), (90, 45), called="North Street"),
        street("South", (-90, -45), (90, -45), called="South Street"),
    )
    choices = facing_choices(hidden, "House")
    seen = dict(zip(np.round(np.degrees(choices.bearing_rad)), choices.features, strict=True))
    assert seen[90][COLUMN["seen"]] == 0
    assert seen[-90][COLUMN["seen"]] == 1


def test_what_the_neighbours_are_near_to_is_told():
    town = facing_town()
    choices = facing_choices(town, "House1n5")
    share = choices.features[:, COLUMN["share of neighbours"]]
    named = choices.features[:, COLUMN["named"]] == 1
    assert share[named].max() > 0.9


def test_a_turned_map_turns_the_directions_and_nothing_else():
    turn = 0.7
    for name in ("House0n3", "House2n6"):
        one = facing_choices(facing_town(), name)
        two = facing_choices(facing_town(turn_rad=turn), name)
        order = np.argsort(one.distance_m, kind="stable"), np.argsort(two.distance_m, kind="stable")
        gap = two.bearing_rad[order[1]] - one.bearing_rad[order[0]] - turn
        np.testing.assert_allclose(np.exp(1j * gap), 1, atol=1e-6)
        np.testing.assert_allclose(two.features[order[1]], one.features[order[0]], atol=1e-4)


def test_a_map_without_ways_gives_no_choice():
    choices = facing_choices(city(house("House", 0, 0)), "House")
    assert len(choices.bearing_rad) == len(choices.distance_m) == 0
    assert choices.features.shape == (0, len(FEATURES))


def test_a_way_is_no_choice_of_its_own_and_one_through_the_centroid_is_none():
    through = city(house("House", 0, 0), street("Passage", (-50, 0), (50, 0)))
    assert len(facing_choices(through, "House").bearing_rad) == 0
    assert len(facing_choices(through, "Passage").bearing_rad) == 0


PATHS = shapely.MultiLineString([[(0, -30), (9, -30)], [(0, -50), (9, -60)]])
YARD = shapely.Polygon(
    shapely.box(-60, 40, -20, 80).exterior, [shapely.box(-50, 50, -30, 70).exterior]
)
MIXED = city(
    house("House", 0, 0),
    Landmark("Yard", "building", YARD),
    Landmark("Wings", "building", shapely.MultiPolygon([shapely.box(40, 30, 60, 40), YARD])),
    Landmark("Cafe", "poi", shapely.Point(1, 1), within="House"),
    Landmark("Pole", "poi", shapely.Point(20, -40)),
    Landmark("Far", "building", shapely.box(-2000, -2000, -1980, -1990)),
    Landmark("Plaza", "pedestrian", shapely.GeometryCollection([shapely.Point(30, -30), PATHS])),
    street("Main", (-99, -20), (99, -20), called="Main Street"),
    street("Lane", (-20, -99), (-20, 99), kind="service"),
)  # fmt: skip
MIXED_IDS = [landmark.id for landmark in MIXED.landmarks]


@pytest.mark.parametrize("view", ["ego-ctx", "ctx", "ego"])
def test_many_pictures_are_those_drawn_one_by_one(view):
    turns = np.linspace(0, 3, len(MIXED_IDS))
    shifts = np.stack([3 * turns, -turns], 1)
    many = pictures_of(MIXED, MIXED_IDS, view, turns_rad=turns, shifts_m=shifts)
    for i, name in enumerate(MIXED_IDS):
        one = context_planes(MIXED, name, view, turn_rad=turns[i], shift_m=tuple(shifts[i]))
        np.testing.assert_array_equal(many[i], one)
    again = pictures_of(MIXED, ["Pole", "House", "Pole"], view)
    np.testing.assert_array_equal(again[0], again[2])
    np.testing.assert_array_equal(again[1], context_planes(MIXED, "House", view))


def test_the_streets_around_many_are_those_around_each():
    for name, choices in zip(MIXED_IDS, choices_of(MIXED, MIXED_IDS), strict=True):
        one = facing_choices(MIXED, name)
        np.testing.assert_array_equal(choices.distance_m, one.distance_m)
        np.testing.assert_allclose(choices.bearing_rad, one.bearing_rad, atol=1e-12)
        np.testing.assert_allclose(choices.features, one.features, atol=1e-6)


def test_of_none_there_is_no_picture_and_no_street():
    assert pictures_of(MIXED, []).shape == (0, 4, 28, 28)
    assert pictures_of(MIXED, [], turns_rad=[], shifts_m=np.zeros((0, 2))).shape[0] == 0


@pytest.mark.parametrize(
    "given",
    [{"turns_rad": [0.0, 1.0]}, {"shifts_m": [3.0]}, {"shifts_m": np.zeros((3, 2))}],
)
def test_turns_and_shifts_of_another_shape_are_refused(given):
    with pytest.raises(InputError, match=r"expected one for all, \(\) and \(2,\), or one for each"):
        pictures_of(MIXED, ["House"], **given)
    assert choices_of(MIXED, []) == []


def test_what_stands_alone_is_drawn_alone():
    planes = context_planes(MIXED, "Far")
    assert planes[0].sum() > 0
    assert planes[1:].sum() == 0


def test_the_building_a_poi_stands_in_is_its_ground_alone():
    ground, _, _, buildings = context_planes(MIXED, "Cafe")
    np.testing.assert_array_equal(ground, context_planes(MIXED, "House")[0])
    assert not (buildings * ground).any()


def test_a_courtyard_is_left_out_and_all_parts_are_drawn():
    ground = context_planes(MIXED, "Yard")[0]
    middle = slice(PIXELS // 2 - 2, PIXELS // 2 + 2)
    assert ground[middle, middle].sum() == 0
    assert ground[:, middle].max() == 1
    pixel = (VIEWS["ctx"].side_m / PIXELS) ** 2
    wings = context_planes(MIXED, "Wings", "ctx")[0].sum() * pixel
    assert wings == pytest.approx(YARD.area + 20 * 10, rel=0.4)
    assert context_planes(MIXED, "Pole")[PLANES.index("paths")].sum() > 0  # the plaza's


def test_walls_tell_the_narrow_side_and_what_is_square_to_it():
    shed = city(
        Landmark("Shed", "building", shapely.box(-5, -20, 5, 20)),
        street("South", (-90, -40), (90, -40), called="South Street"),
        street("East", (30, -90), (30, 90), called="East Street"),
    )
    choices = facing_choices(shed, "Shed")
    assert np.degrees(choices.bearing_rad) == pytest.approx([0, -90])
    narrow = choices.features[:, COLUMN["towards narrow side"]]
    assert narrow == pytest.approx([math.log(10 / 40), math.log(40 / 10)])
    assert choices.features[:, COLUMN["square to walls"]] == pytest.approx([1, 1])
    pole = city(Landmark("Pole", "poi", shapely.Point(0, 0)), *shed.landmarks[1:])
    assert not facing_choices(pole, "Pole").features[:, COLUMN["square to walls"]].any()
