"""Whatever is done to a map file, it loads or is refused in one line that says where."""

import copy
import json
import logging
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sloop_ppl.errors import MapError
from sloop_ppl.maps import KINDS, CityMap, from_geojson, load_map, map_schema, read_map, to_geojson

WHOLE = to_geojson(load_map("cleveland").window((5, 0), 60))
PLACES = [
    (*where, key)
    for where in [(), ("centre",), ("features",), *(("features", i) for i in range(3))]
    for key in ["type", "centre", "lat", "lon", "extent_m", "features", "geometry", "properties", 0]
] + [
    ("features", 0, "properties", key)
    for key in ("id", "kind", "name", "aliases", "within", "width_m", "height_m", "entrances")
] + [
    ("features", 0, "geometry", *rest)
    for rest in (("type",), ("coordinates",), ("coordinates", 0), ("coordinates", 0, 0),
                 ("coordinates", 0, 0, 0), ("coordinates", 0, 1, 1))
]  # fmt: skip
VALUES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=5),
    st.sampled_from([10**400, -0.0, 1e308, "NaN", "Point", "Polygon", "GeometryCollection"]),
    st.recursive(
        st.floats(-200, 200),
        lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner),
        max_leaves=8,
    ),
)


def put(data, path, value):
    """Put a value at a path, if the path leads anywhere."""
    place = data
    for step in path[:-1]:
        try:
            place = place[step]
        except (KeyError, IndexError, TypeError):
            return
    try:
        place[path[-1]] = value
    except (IndexError, TypeError):
        return


@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(PLACES), VALUES), min_size=1, max_size=3))
def test_a_mutated_map_loads_or_is_refused_in_one_line(changes):
    logging.disable(logging.WARNING)
    data = copy.deepcopy(WHOLE)
    for path, value in changes:
        put(data, path, value)
    told = ""
    try:
        city = from_geojson(data, source="mutated")
    except MapError as error:
        told = str(error)
        assert told.startswith(("mutated: ", "Map '", "Feature '"))
        assert "\n" not in told
    else:
        assert from_geojson(to_geojson(city)).counts() == city.counts()


@settings(max_examples=200, deadline=None)
@given(at=st.integers(0, 5000), length=st.integers(0, 30), text=st.text(max_size=10))
def test_a_mutated_file_loads_or_is_refused_in_one_line(tmp_path_factory, at, length, text):
    logging.disable(logging.WARNING)
    path = tmp_path_factory.mktemp("map") / "m.geojson"
    whole = json.dumps(WHOLE)
    content = whole[:at] + text + whole[at + length :]
    path.write_bytes(content.encode("utf-8", "surrogatepass"))
    told = ""
    try:
        read_map(path)
    except MapError as error:
        told = str(error)
    assert "\n" not in told


@pytest.fixture(autouse=True)
def _warnings_back():
    yield
    logging.disable(logging.NOTSET)


def refusal(path, value):
    data = copy.deepcopy(WHOLE)
    put(data, path, value)
    with pytest.raises(MapError) as caught:
        from_geojson(data, source="m")
    return caught.value


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("type",), "Feature", "m: field 'type' is 'Feature'; expected 'FeatureCollection'"),
        (("features",), {}, "m: field 'features' is an object; expected a list"),
        (
            ("centre", "lat"), 141.5,
            (
                "m: field 'centre.lat' is 141.5; expected a latitude in [-90, 90] degrees; "
                "are lat and lon swapped?"
            ),
        ),
        (
            ("features", 1), 3,
            "m: feature 'number 1': field 'properties' is 3; expected a GeoJSON Feature",
        ),
        (
            ("features", 1, "properties", "id"), "",
            "m: feature 'number 1': field 'id' is ''; expected a name",
        ),
        (
            ("extent_m", 2), math.nan,
            "m: field 'extent_m' is nan; expected a finite number of metres",
        ),
    ],
)  # fmt: skip
def test_the_whole_message(path, value, message):
    assert str(refusal(path, value)) == message


def test_a_fault_names_its_feature_and_field():
    first = WHOLE["features"][0]["properties"]["id"]
    for field, value in [
        ("kind", "castle"), ("aliases", [1]), ("width_m", math.inf), ("width_m", -1),
        ("within", "Nowhere"), ("entrances", [{}]), ("height_m", "tall"), ("name", 3),
    ]:  # fmt: skip
        error = refusal(("features", 0, "properties", field), value)
        assert (error.feature, error.field) == (first, field)
    for value in [None, {}, {"type": "Point", "coordinates": [1, math.nan]},
                  {"type": "Point", "coordinates": [-81.7, 99]},
                  {"type": "Polygon", "coordinates": [[[0, 0], [1, 1], [0, 0]]]},
                  {"type": "LineString", "coordinates": []}]:  # fmt: skip
        error = refusal(("features", 0, "geometry"), value)
        assert (error.feature, error.field) == (first, "geometry")


def test_swapped_coordinates_are_recognised():
    data = copy.deepcopy(WHOLE)
    lon, lat = data["centre"]["lon"], data["centre"]["lat"]
    first = data["features"][0]["properties"]["id"]
    data["features"][0]["geometry"] = {"type": "Point", "coordinates": [lat, lon]}
    with pytest.raises(MapError) as caught:
        from_geojson(data, source="m")
    assert str(caught.value) == (
        f"m: feature '{first}': field 'geometry' lies 15060 km outside the map; "
        "are longitude and latitude swapped?"
    )
    data["centre"] = {"lat": lon, "lon": lat}
    with pytest.raises(MapError, match="are longitude and latitude swapped"):
        from_geojson(data, source="m")


def test_a_grid_too_large_to_lay_is_refused():
    with pytest.raises(MapError, match="expected 50,000,000 at most: give a larger cell_m"):
        from_geojson(WHOLE, cell_m=0.001)


def test_a_self_crossing_outline_is_repaired_and_told(caplog):
    data = copy.deepcopy(WHOLE)
    lon, lat = data["centre"]["lon"], data["centre"]["lat"]
    d = 1e-4
    bow = [(lon, lat), (lon + d, lat + d), (lon + d, lat), (lon, lat + d), (lon, lat)]
    put(data, ("features", 0, "geometry"), {"type": "Polygon", "coordinates": [bow]})
    city = from_geojson(data, source="m")
    assert all(m.geometry.is_valid for m in city.landmarks)
    assert caplog.messages == [
        f"m: outlines that cross themselves, repaired: 1 ({city.landmarks[0].id})"
    ]


def test_what_the_format_does_not_know_is_kept():
    data = copy.deepcopy(WHOLE)
    data["mood"] = {"fine": True}
    data["features"][0]["id"] = 17
    data["features"][0]["bbox"] = [0, 0, 1, 1]
    data["features"][0]["properties"]["note"] = ["a", None]
    city = from_geojson(data)
    assert isinstance(city, CityMap)
    assert to_geojson(city) == data


def test_altitudes_are_kept():
    data = copy.deepcopy(WHOLE)
    centre = data["centre"]
    place = {"type": "Point", "coordinates": [centre["lon"], centre["lat"], 12.5]}
    data["features"][0]["geometry"] = place
    assert to_geojson(from_geojson(data))["features"][0]["geometry"]["coordinates"][2] == 12.5


def test_the_schema_knows_the_kinds():
    assert tuple(map_schema()["definitions"]["properties"]["properties"]["kind"]["enum"]) == KINDS
