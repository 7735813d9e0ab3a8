"""What is near a point, against a search of everything."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from sloop_ppl.errors import InputError
from sloop_ppl.maps import PATH_KINDS, load_map

CITY = load_map("washington_dc")
coordinate = st.floats(-120, 120)


def measured(x, y, among):
    return [(CITY.footprint(m.id).distance(shapely.Point(x, y)), i) for i, m in enumerate(among)]


@given(coordinate, coordinate, st.sampled_from([(), ("building",), ("street", "service")]))
def test_nearest_is_the_first_of_the_nearest(x, y, kinds):
    among = CITY.of_kind(*kinds) if kinds else CITY.landmarks
    distance, i = min(measured(x, y, among))
    for given_ in (among, list(among)):
        landmark, found = CITY.nearest(x, y, given_)
        assert landmark is among[i]
        assert found == pytest.approx(distance, abs=1e-9)


@given(coordinate, coordinate, st.floats(0, 80))
def test_landmarks_near_are_all_within_reach_nearest_first(x, y, reach):
    found = CITY.landmarks_near(x, y, reach)
    expected = sorted(t for t in measured(x, y, CITY.landmarks) if t[0] <= reach)
    assert [m.id for m, _ in found] == [CITY.landmarks[i].id for _, i in expected]
    assert [d for _, d in found] == sorted(d for _, d in found)


def test_landmarks_near_of_some_kinds():
    found = CITY.landmarks_near(0, 0, 100, kinds=("parking", "park"))
    assert {m.kind for m, _ in found} == {"parking", "park"}
    assert CITY.landmarks_near(0, 0, 100, kinds=("water",)) == []


@pytest.mark.parametrize("reach", [-1, np.nan])
def test_a_reach_that_is_no_distance(reach):
    with pytest.raises(InputError, match="expected a distance of 0 metres or more"):
        CITY.landmarks_near(0, 0, reach)


def test_nearest_of_none():
    assert CITY.nearest(0, 0, ()) is None


def test_bearing_to_the_nearest_path_by_brute_force():
    paths = CITY.of_kind(*PATH_KINDS)
    for landmark in CITY.landmarks:
        x, y = CITY.centroid(landmark.id)
        point = shapely.Point(x, y)
        others = [m for m in paths if m.id != landmark.id]
        path = min(others, key=lambda m: m.geometry.distance(point))
        foot = shapely.get_coordinates(shapely.shortest_line(point, path.geometry))[1]
        bearing = CITY.bearing_to_nearest_path(landmark.id)
        if bearing is None:
            assert path.geometry.distance(point) < 1e-6
        else:
            assert bearing == pytest.approx(np.arctan2(foot[1] - y, foot[0] - x), abs=1e-9)
