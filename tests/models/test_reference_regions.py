"""Relations that do not simply measure from one ground: between, corners, across, the map."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from sloop_ppl.inference import infer_description
from sloop_ppl.maps import CityMap, Grid, Landmark, load_map
from sloop_ppl.models import PRESETS, ground_relations
from sloop_ppl.models._reference_regions import across_region, between_region, meeting_point
from tests.scenes import TARGET, house_and_street, point_city, relation, said, symmetric_grid

GRID = symmetric_grid(41)


def street(name, *coordinates, width_m=6.0):
    return Landmark(name, "street", shapely.LineString(coordinates), name=name, width_m=width_m)


def crossing(*more):
    """Two streets that cross at (20, -10)."""
    return CityMap(
        "cross",
        GRID,
        (
            street("HighSt", (-100, -10), (100, -10)),
            street("LowAve", (20, -100), (20, 100)),
            *more,
        ),
    )


def term(city, word, *grounds, joint=True, **said_of):
    from dataclasses import replace

    spoken = replace(relation(word, *grounds), **said_of)
    (only,) = ground_relations((spoken,), city, joint=joint)
    return only


def at(term, x, y, table=None):
    return float((term.distance_m if table is None else table)[_flat(term.city.grid, x, y)])


def _flat(grid, x, y):
    row, col = grid.cell_at(x, y)
    return row * grid.n_cols + col


def test_between_two_points_is_the_segment():
    city = point_city(GRID, A=(-40.0, 0.0), B=(40.0, 0.0))
    between = term(city, "between", "A", "B")
    assert between.grounds == ("A", "B")
    assert at(between, 0, 0) == at(between, -20, 0) == 0
    assert at(between, 0, 30) == 30
    # Beyond the ends it is as far as from the end itself, and the ends are not between.
    assert at(between, 70, 0) == pytest.approx(30, abs=5)


def test_between_parallel_streets_is_the_block_and_between_crossing_ones_the_crossing():
    city = crossing(street("UpperSt", (-100, 40), (100, 40)))
    block = term(city, "between", "HighSt", "UpperSt")
    assert at(block, -80, 15) == at(block, 80, 15) == 0
    assert at(block, 0, 70) == pytest.approx(33, abs=5)
    corner = term(city, "between", "HighSt", "LowAve")
    assert at(corner, 15, -5) <= 5
    assert at(corner, -80, -10) > 60


def test_between_three_is_their_hull():
    city = point_city(GRID, A=(-40.0, -40.0), B=(40.0, -40.0), C=(0.0, 60.0))
    between = term(city, "between", "A", "B", "C")
    assert at(between, 0, 0) == 0
    assert at(between, -40, 40) > 20


def test_between_a_house_and_a_street_takes_only_what_faces():
    shapes = [shapely.box(-10, 0, 10, 20), shapely.LineString([(-100, -20), (100, -20)])]
    west, south, east, north = between_region(shapes).bounds
    assert south == -20
    assert 0 <= north <= 10
    assert -50 < west < -10
    assert 10 < east < 50


def test_neighbours_that_touch_still_have_something_between():
    shapes = [shapely.box(-10, 0, 0, 10), shapely.box(0, 0, 10, 10)]
    assert not between_region(shapes).is_empty


@pytest.mark.parametrize("word", ["at", "on", "near"])
def test_a_corner_is_near_both_streets(word):
    city = crossing()
    corner = term(city, word, "HighSt", "LowAve")
    assert at(corner, 20, -10) == 0
    assert at(corner, -60, -10) == at(term(city, word, "LowAve"), -60, -10)
    assert corner.distance_m.argmin() in np.flatnonzero(corner.distance_m.numpy() == 0)


def test_the_northeast_of_a_corner_is_seen_from_the_crossing():
    corner = term(crossing(), "northeast", "HighSt", "LowAve")
    assert at(corner, 50, 20, corner.bearing_rad) == pytest.approx(math.pi / 4, abs=0.1)
    assert meeting_point(
        [shapely.LineString([(0, 0), (4, 0)]), shapely.LineString([(1, -1), (1, 2)])]
    ).equals(shapely.Point(1, 0))


def test_across_from_a_house_that_reaches_the_street_is_away_from_its_middle():
    for house_y, side in ((-3.0, 1), (3.0, -1), (-4.0, 1)):  # walls over the street, or on it
        city = house_and_street(GRID, house=(10.0, house_y), street_y=0.0)
        region = across_region(city, "House", "MainSt")
        assert region.area > 0
        assert side * region.centroid.y > 0


def test_across_from_a_house_is_the_other_side_of_its_street():
    city = house_and_street(GRID, house=(10.0, -20.0), street_y=0.0)
    across = term(city, "across", "House")
    # The wall is 16 m from the street, so its mirror image begins 16 m behind the street.
    assert at(across, 10, 20) == 0
    assert at(across, 10, -20) > 30
    # A poi without a building takes its street too.
    assert across_region(point_city(GRID, Pole=(0.0, 0.0)), "Pole") is None
    assert term(point_city(GRID, Pole=(0.0, 0.0)), "across", "Pole").reference_region is None


def test_across_a_street_is_either_side_of_it():
    across = term(crossing(), "across", "HighSt")
    assert at(across, -50, 0) == at(across, -50, -20) == 0
    assert at(across, -50, 60) > 40


def test_across_names_the_street_it_crosses():
    house = Landmark("House", "building", shapely.box(0, -4, 8, 4), name="House")
    across = term(crossing(house), "across", "LowAve", "House")
    # HighSt is nearer, but it was LowAve that was said: 12 m to it, so 32 m and on.
    assert at(across, 35, 0) == 0
    assert at(across, 0, -25) > 20


def test_along_a_street_has_its_verges():
    along = term(crossing(), "along", "HighSt")
    assert at(along, -50, -2.4) == at(along, 80, -15) == 0
    assert at(along, -50, 30) > 20
    plain = term(crossing(), "along", "HighSt", joint=False)
    assert at(plain, -50, -20) > at(along, -50, -20)


def test_published_models_read_one_relation_per_ground():
    spoken = (relation("between", "HighSt", "LowAve"), relation("at", "HighSt"))
    apart = ground_relations(spoken, crossing())
    assert [t.grounds for t in apart] == [("HighSt",), ("LowAve",), ("HighSt",)]
    assert [t.index for t in apart] == [0, 0, 1]
    assert all(t.reference_region is None for t in apart)
    joint = ground_relations(spoken, crossing(), joint=True)
    assert [t.grounds for t in joint] == [("HighSt", "LowAve"), ("HighSt",)]


def test_senses_do_not_change_with_the_size_of_the_cells():
    coarse = crossing()
    fine = coarse.with_grid(Grid(*GRID.extent_m, 2.5))
    for word, grounds in (("between", ("HighSt", "LowAve")), ("at", ("HighSt", "LowAve"))):
        one, other = term(coarse, word, *grounds), term(fine, word, *grounds)
        for x, y in ((60, 40), (-30, -70), (18, 3)):
            assert at(one, x, y) == pytest.approx(at(other, x, y), abs=5)


def test_sides_of_the_map():
    city = crossing()
    corner = term(city, "northwest", "Map", joint=False)
    assert at(corner, -90, 90) == at(corner, -30, 30) == 0
    assert at(corner, 90, 90) > 90
    assert term(city, "left", "Map").relation_class == "west"
    assert not term(city, "left", "Map").needs_frame
    assert at(term(city, "middle", "Map"), 0, 0) == 0
    assert at(term(city, "middle", "Map"), 90, 0) > 40
    assert float(term(city, "in", "Map").distance_m.max()) == 0


@pytest.mark.parametrize("model", [name for name in PRESETS if name != "informed"])
@pytest.mark.parametrize("word", ["northwest", "north", "in", "at", "left", "front", "between"])
def test_every_model_knows_the_sides_of_the_map(model, word):
    posterior, _ = infer_description(said(relation(word, "Map")), load_map("cleveland"), model)
    belief = posterior.belief(TARGET)
    assert belief.sum() == pytest.approx(1)
    assert posterior.frames(TARGET) == ()
    if word == "northwest" and model != "uniform":
        assert belief[20:, :21].sum() > 0.6
    if word in ("in", "at"):
        np.testing.assert_allclose(belief, 1 / belief.size)


def test_a_landmark_that_is_called_map_is_one():
    city = point_city(GRID, Map=(50.0, 0.0))
    here = term(city, "near", "Map")
    assert not here.is_map
    assert at(here, 50, 0) == 0 < at(here, 0, 0)


def test_a_said_distance_is_a_ring():
    city = point_city(GRID, Pole=(0.0, 0.0))
    far = term(city, "near", "Pole", distance_m=40.0)
    assert at(far, 40, 0, far.off_m) == 0
    assert at(far, 0, 0, far.off_m) == 40
    assert term(city, "near", "Pole").off_m is not None
