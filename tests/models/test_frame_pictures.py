"""Pictures of what surrounds a landmark, and the streets it may face."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from support.facing_block import facing_town

from sloop_ppl.errors import UnknownName
from sloop_ppl.maps import CityMap, Grid, Landmark
from sloop_ppl.models.frames import context_image, context_planes
from sloop_ppl.models.frames.image import GREYS, PIXELS, PLANES, VIEWS
from sloop_ppl.models.frames.streets import FEATURES, facing_choices
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
