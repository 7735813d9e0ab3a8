"""Map files: what is written is what is read, and one line for every file that is no map."""

import copy
import json

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sloop_ppl.errors import MapError, UnknownName
from sloop_ppl.maps import (
    bundled_maps,
    from_geojson,
    load_map,
    map_names,
    read_map,
    to_geojson,
    write_map,
)

SQUARE = [[[-81.7, 41.5], [-81.6998, 41.5], [-81.6998, 41.5002], [-81.7, 41.5002], [-81.7, 41.5]]]
MAP = {
    "type": "FeatureCollection",
    "name": "small",
    "attribution": "nobody",
    "centre": {"lat": 41.5, "lon": -81.7},
    "half_extent_m": 50,
    "made_by": "hand",
    "features": [
        {
            "type": "Feature",
            "properties": {"id": "Hall", "kind": "building", "name": "Hall", "levels": "3"},
            "geometry": {"type": "Polygon", "coordinates": SQUARE},
        },
        {
            "type": "Feature",
            "properties": {"id": "Cafe", "kind": "poi", "within": "Hall", "aliases": ["Coffee"]},
            "geometry": {"type": "Point", "coordinates": [-81.69995, 41.50005]},
        },
        {
            "type": "Feature",
            "properties": {"id": "Lane", "kind": "street", "width_m": 4.5},
            "geometry": {
                "type": "LineString",
                "coordinates": [[-81.7003, 41.4999], [-81.6997, 41.4999]],
            },
        },
    ],
}


def changed(*path, to):
    """Return the small map with the value at a path replaced, or removed where `to` is None."""
    data = copy.deepcopy(MAP)
    place = data
    for step in path[:-1]:
        place = place[step]
    if to is None:
        del place[path[-1]]
    else:
        place[path[-1]] = to
    return data


def test_a_map_is_read():
    city = from_geojson(MAP)
    assert (city.name, city.attribution, city.properties) == (
        "small",
        "nobody",
        {"made_by": "hand"},
    )
    assert city.grid.shape == (21, 21)
    assert city.grid.centre == (41.5, -81.7)
    hall, cafe, lane = city.landmarks
    assert (hall.name, hall.kind, hall.properties) == ("Hall", "building", {"levels": "3"})
    assert (cafe.within, cafe.aliases, cafe.name) == ("Hall", ("Coffee",), None)
    assert (lane.width_m, lane.geometry.geom_type) == (4.5, "LineString")
    # 0.0002 degrees of longitude at 41.5 N are 16.7 m, of latitude 22.2 m.
    assert hall.geometry.bounds == pytest.approx((0, 0, 16.7, 22.2), abs=0.05)


@pytest.mark.parametrize(
    ("given_m", "in_file", "shape"),
    [(None, None, (21, 21)), (None, 10, (11, 11)), (2, 10, (51, 51)), (2, None, (51, 51))],
)
def test_the_cell_is_the_one_asked_for_else_the_files_else_five_metres(given_m, in_file, shape):
    data = MAP if in_file is None else MAP | {"cell_m": in_file}
    assert from_geojson(data, cell_m=given_m).grid.shape == shape


def test_an_extent_need_not_be_square():
    data = changed("half_extent_m", to=None) | {"extent_m": [-20, -10, 40, 30]}
    grid = from_geojson(data).grid
    assert grid.extent_m == (-20, -10, 40, 30)
    assert to_geojson(from_geojson(data))["extent_m"] == [-20, -10, 40, 30]


def test_what_is_written_is_what_was_read():
    city = from_geojson(MAP)
    again = from_geojson(json.loads(json.dumps(to_geojson(city))))
    assert to_geojson(again) == to_geojson(city)
    for one, other in zip(city.landmarks, again.landmarks, strict=True):
        assert (one.id, one.kind, one.name, one.aliases, one.within, one.width_m) == (
            other.id, other.kind, other.name, other.aliases, other.within, other.width_m,
        )  # fmt: skip
        assert one.properties == other.properties
        assert shapely.equals_exact(one.geometry, other.geometry, tolerance=1e-3)


@pytest.mark.parametrize("name", map_names())
def test_bundled_maps_survive_a_round_trip_through_a_file(name, tmp_path):
    city = load_map(name)
    path = tmp_path / f"{name}.geojson"
    write_map(city, path)
    again = load_map(path)
    assert again.name == city.name
    assert [m.id for m in again.landmarks] == [m.id for m in city.landmarks]
    for landmark in city.landmarks:
        assert np.array_equal(again.cells(landmark.id), city.cells(landmark.id)), landmark.id
    write_map(again, tmp_path / "twice.geojson")
    assert (tmp_path / "twice.geojson").read_bytes() == path.read_bytes()


def test_bundled_names_and_paths_are_loaded_and_others_told():
    cities = ["austin", "cleveland", "denver", "honolulu", "washington_dc"]
    assert bundled_maps() == cities
    assert map_names() == sorted([*cities, "suburb"])
    with pytest.raises(UnknownName) as caught:
        load_map("clevland")
    assert str(caught.value) == (
        "Map 'clevland' is unknown; expected one of austin, cleveland, denver, honolulu, "
        "suburb, washington_dc; did you mean 'cleveland'? (or give the path of a .geojson file)"
    )


FIRST = ("features", 0)


@pytest.mark.parametrize(
    ("data", "feature", "field"),
    [
        ([], None, "type"),
        (changed("type", to="Topology"), None, "type"),
        (changed("features", to=None), None, "features"),
        (changed("features", to={}), None, "features"),
        (changed("centre", to=None), None, "centre"),
        (changed("centre", "lat", to=None), None, "centre.lat"),
        (changed("centre", "lat", to=-181.7), None, "centre.lat"),
        (changed("half_extent_m", to=None), None, "half_extent_m"),
        (changed("half_extent_m", to=-5), None, "half_extent_m"),
        (changed("half_extent_m", to="wide"), None, "half_extent_m"),
        (changed(*FIRST, to=7), "number 0", "properties"),
        (changed(*FIRST, "properties", to=None), "number 0", "properties"),
        (changed(*FIRST, "properties", "id", to=None), "number 0", "id"),
        (changed(*FIRST, "properties", "id", to=""), "number 0", "id"),
        (changed(*FIRST, "properties", "kind", to=None), "Hall", "kind"),
        (changed(*FIRST, "properties", "kind", to="castle"), "Hall", "kind"),
        (changed(*FIRST, "properties", "name", to=3), "Hall", "name"),
        (changed("features", 1, "properties", "aliases", to="x"), "Cafe", "aliases"),
        (changed("features", 1, "properties", "within", to="Nowhere"), "Cafe", "within"),
        (changed("features", 1, "properties", "id", to="Hall"), "Hall", "id"),
        (changed("features", 2, "properties", "width_m", to=float("nan")), "Lane", "width_m"),
        (changed("features", 2, "properties", "width_m", to="4"), "Lane", "width_m"),
        (changed(*FIRST, "geometry", to=None), "Hall", "geometry"),
        (changed(*FIRST, "geometry", "type", to="Circle"), "Hall", "geometry"),
        (changed(*FIRST, "geometry", "coordinates", to=[]), "Hall", "geometry"),
        (changed(*FIRST, "geometry", "coordinates", to=[[["x", 0]]]), "Hall", "geometry"),
        (
            changed("features", 1, "geometry", "coordinates", to=[41.5, -181.7]),
            "Cafe",
            "geometry",
        ),
        (
            changed("features", 1, "geometry", "coordinates", to=[float("nan"), 41.5]),
            "Cafe",
            "geometry",
        ),
    ],
)
def test_a_fault_names_its_feature_and_field_in_one_line(data, feature, field):
    with pytest.raises(MapError) as caught:
        from_geojson(data, source="town.geojson")
    message = str(caught.value)
    assert "\n" not in message
    assert (caught.value.feature, caught.value.field) == (feature, field)
    assert field in message
    if feature is not None:
        assert f"'{feature}'" in message


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"\xff\xfe\x00", "no text in UTF-8"),
        (b"", "is not JSON"),
        (b"{", "is not JSON"),
        (b"[" * 100_000, "is not JSON"),
        (b"null", "field 'type'"),
    ],
)
def test_a_file_that_is_no_map_is_told_in_one_line(tmp_path, content, words):
    path = tmp_path / "town.geojson"
    path.write_bytes(content)
    with pytest.raises(MapError) as caught:
        read_map(path)
    assert words in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_that_is_not_there_is_told_in_one_line(tmp_path):
    with pytest.raises(MapError, match=r"none\.geojson' cannot be read"):
        read_map(tmp_path / "none.geojson")


values = st.one_of(
    st.none(), st.booleans(), st.integers(-3, 3), st.floats(), st.text(max_size=3),
    st.just([]), st.just({}), st.just([[0, 0]]), st.just(1e308),
)  # fmt: skip


def paths(data, here=()):
    """Return the path of every value in parsed JSON."""
    inner = (
        data.items()
        if isinstance(data, dict)
        else enumerate(data)
        if isinstance(data, list)
        else ()
    )
    return [here, *(p for key, value in inner for p in paths(value, (*here, key)))]


PATHS = [p for p in paths(MAP) if p]


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(st.tuples(st.sampled_from(PATHS), values), min_size=1, max_size=2))
@pytest.mark.filterwarnings("ignore")
def test_a_mutated_map_is_read_or_refused_in_one_line(mutations):
    data = copy.deepcopy(MAP)
    for path, value in mutations:
        place = data
        try:
            for step in path[:-1]:
                place = place[step]
            place[path[-1]] = value
        except (TypeError, KeyError, IndexError):
            continue  # the first mutation took this place away
    try:
        city = from_geojson(data)
    except MapError as error:
        told = str(error)
    else:
        told = ""
        for landmark in city.landmarks:
            assert city.cells(landmark.id).any()
    assert "\n" not in told


def test_an_extent_in_degrees_is_refused():
    data = copy.deepcopy(MAP)
    del data["half_extent_m"]
    data["extent_m"] = [-81.7005, 41.4995, -81.6995, 41.5005]
    with pytest.raises(MapError, match="which looks like degrees; expected metres") as caught:
        from_geojson(data)
    assert caught.value.field == "extent_m"


def test_a_map_none_of_whose_landmarks_is_inside_is_refused():
    data = copy.deepcopy(MAP)
    data["centre"] = {"lat": 41.51, "lon": -81.7}
    with pytest.raises(MapError, match="none of its 3 landmarks is inside") as caught:
        from_geojson(data)
    assert caught.value.field == "extent_m"
    data["features"] = []
    assert from_geojson(data).landmarks == ()
