"""Whatever is done to an OpenStreetMap file, it imports or is refused in one line."""

import json
import random
import re

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support.osm_block import CENTRE, OsmWriter, block

from sloop_ppl.errors import MapError
from sloop_ppl.maps import from_geojson, to_geojson
from sloop_ppl.maps.osm import import_osm

WHOLE = block().text()


def refused(path, content, **patch):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(MapError) as caught:
        import_osm(path, **(patch or {"everything": True}))
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)
    return caught.value


@pytest.fixture(scope="module")
def pbf(tmp_path_factory):
    """Return the block as the bytes of a .osm.pbf file."""
    import osmium

    folder = tmp_path_factory.mktemp("block")
    with osmium.SimpleWriter(str(folder / "block.osm.pbf")) as writer:
        for thing in osmium.FileProcessor(str(block().write(folder / "block.osm"))):
            writer.add(thing)
    return (folder / "block.osm.pbf").read_bytes()


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(MapError) as caught:
        import_osm(tmp_path / "none.osm", everything=True)
    assert str(caught.value) == (
        f"File '{tmp_path / 'none.osm'}' cannot be read: no such file; expected .osm or .osm.pbf"
    )


@pytest.mark.parametrize("name", ["a.osm", "a.osm.pbf", "a.osm.gz", "a.osm.bz2", "a.geojson", "a"])
def test_ten_megabytes_of_noise(tmp_path, name):
    error = refused(tmp_path / name, random.Random(0).randbytes(10_000_000))
    assert str(error).endswith("; expected .osm XML or .osm.pbf, whole")


def test_an_empty_file_and_an_empty_map(tmp_path):
    refused(tmp_path / "a.osm", b"")
    refused(tmp_path / "a.osm.pbf", b"")
    error = refused(tmp_path / "a.osm", '<osm version="0.6"></osm>')
    assert str(error).endswith("holds no tagged feature; expected a piece of a city")
    refused(tmp_path / "a.osm", '<osm version="0.6"></osm>', centre=CENTRE, side_m=100.0)


def test_a_truncated_file(tmp_path, pbf):
    assert "XML parsing error" in str(refused(tmp_path / "a.osm", WHOLE[:3000]))
    assert "PBF error" in str(refused(tmp_path / "a.osm.pbf", pbf[: len(pbf) // 2]))


def test_entities_are_not_expanded(tmp_path):
    bomb = (
        '<!DOCTYPE b [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;"><!ENTITY f SYSTEM "/etc/passwd">]>'
    )
    text = WHOLE.replace('<osm version="0.6">', f'{bomb}\n<osm version="0.6">')
    text = text.replace("First Bank", "&b;&f;")
    assert "XML entities are not supported" in str(refused(tmp_path / "a.osm", text))


def test_a_coordinate_that_is_no_number_is_named(tmp_path):
    osm = block()
    osm.nodes.append('<node id="5" lat="nan" lon="1"><tag k="shop" v="yes"/></node>')
    error = refused(tmp_path / "a.osm", osm.text())
    assert (error.feature, error.field) == ("node/5", "lat")
    assert "node/5: field 'lat' is 'nan'" in str(error)


@pytest.mark.parametrize(
    ("lat", "lon", "field"), [(200, 24, "lat"), (-97.7, 30.2, "lat"), (30, 190, "lon")]
)
def test_a_coordinate_off_the_earth_is_named(tmp_path, lat, lon, field):
    osm = block()
    osm.nodes.append(f'<node id="5" lat="{lat}" lon="{lon}"><tag k="shop" v="yes"/></node>')
    error = refused(tmp_path / "a.osm", osm.text())
    assert (error.feature, error.field) == ("node/5", field)
    assert str(error).endswith("expected lat in [-90, 90] and lon in [-180, 180]")


def test_a_way_through_such_a_place_is_refused_too(tmp_path):
    osm = block()
    osm.nodes.append('<node id="5" lat="91" lon="1"/>')
    osm.ways.append('<way id="99"><nd ref="5"/><nd ref="1000"/><tag k="highway" v="path"/></way>')
    assert refused(tmp_path / "a.osm", osm.text()).feature == "node/5"


def test_a_coordinate_that_is_empty_names_its_node(tmp_path):
    osm = block()
    osm.nodes.append('<node id="5" lat="" lon="1"/>')
    osm.ways.append('<way id="99"><nd ref="5"/><nd ref="1000"/><tag k="highway" v="path"/></way>')
    error = refused(tmp_path / "a.osm", osm.text())
    assert (error.feature, error.field) == ("node/5", "lat")


@pytest.mark.parametrize("tags", [{"shop": "a\0"}, {"shop\0": "a"}, {"shop": "\ud800"}])
def test_texts_that_libosmium_cannot_hold_are_named(tmp_path, tags):
    nodes = [{"type": "node", "id": i, "lat": 41.5, "lon": -81.7, "tags": tags} for i in (1, 2)]
    error = refused(tmp_path / "a.json", json.dumps({"elements": nodes}))
    assert "element 0 is not as Overpass writes it" in str(error)
    member = {"type": "node", "ref": 1, "role": next(iter(tags.values())) + next(iter(tags))}
    relation = {"type": "relation", "id": 1, "members": [member]}
    error = refused(tmp_path / "a.json", json.dumps({"elements": [relation]}))
    assert "element 0 is not as Overpass writes it" in str(error)


def test_ways_without_any_of_their_nodes_are_left_out(tmp_path):
    osm = OsmWriter()
    osm.node(0, 0, 1, shop="yes")
    osm.ways.append('<way id="9"><nd ref="70"/><nd ref="71"/><tag k="highway" v="path"/></way>')
    path = osm.write(tmp_path / "a.osm")
    town, report = import_osm(path, centre=CENTRE, side_m=50.0, allow_incomplete=True)
    assert [m.id for m in town.landmarks] == ["Shop1"]
    assert (report.no_coordinates, report.outside) == (1, 0)


@settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    at=st.integers(0, len(WHOLE) - 1),
    length=st.integers(0, 40),
    put=st.one_of(
        st.text(max_size=12),
        st.sampled_from(
            ['"', "<", ">", "&", "nan", "-1e400", "999999999999999999999", "<nd/>", ";"]
        ),
    ),
)
def test_mutated_xml_imports_or_is_refused_in_one_line(tmp_path, at, length, put):
    text = WHOLE[:at] + put + WHOLE[at + length :]
    _import_or_refuse(tmp_path / "a.osm", text.encode("utf-8", "surrogatepass"))


@settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_mutated_pbf_imports_or_is_refused_in_one_line(tmp_path, pbf, data):
    at = data.draw(st.integers(0, len(pbf) - 1))
    length = data.draw(st.integers(0, 8))
    put = data.draw(st.binary(max_size=8))
    _import_or_refuse(tmp_path / "a.osm.pbf", pbf[:at] + put + pbf[at + length :])


@settings(
    max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    tags=st.dictionaries(
        st.sampled_from(
            ["highway", "building", "amenity", "name", "alt_name", "width", "height", "lanes",
             "building:levels", "area", "layer", "level", "place", "leisure", "natural", "shop",
             "addr:street", "addr:housenumber", "entrance", "ref", "tunnel", "brand"]
        ),
        st.one_of(
            st.sampled_from(["yes", "no", "residential", "park", "square", "water", "-1", "1e999",
                             "nan", "١", "²", "0", "a;b", ";", " ", "'", "main", "pedestrian"]),
            st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), max_size=8),
        ),
        max_size=6,
    ),
    shape=st.sampled_from(["node", "way", "ring"]),
)  # fmt: skip
def test_any_tags_import(tmp_path, tags, shape):
    osm = block()
    if shape == "node":
        osm.node(3.0, 4.0, 500, **tags)
    elif shape == "way":
        osm.way(500, (-50, 0), (3, 4), **tags)
    else:
        osm.box(500, -40, 5, 44, 66, **tags)
    town, _ = import_osm(osm.write(tmp_path / "a.osm"), centre=CENTRE, side_m=200.0)
    for landmark in town.landmarks:
        assert town.cells(landmark.id).any()
        town.frontage(landmark.id)


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(rng=st.randoms(use_true_random=False), drawn=st.booleans(), coast=st.booleans())
def test_shuffled_and_rewired_files_import(tmp_path, rng, drawn, coast):
    head, start, *body, end, _ = WHOLE.split("\n")
    rng.shuffle(body)
    text = "\n".join([head, start, *body[rng.randrange(6) :], end])
    refs = re.findall(r'ref="(\d+)"', text)
    for _ in range(rng.randrange(8)):
        text = text.replace(f'ref="{rng.choice(refs)}"', f'ref="{rng.choice(refs)}"', 1)
    if drawn:
        text = re.sub(r'(<node id|<nd ref)="(\d+)"', r'\1="-\2"', text)
    if coast:
        for tag in ('k="building" v="yes"', 'k="highway" v="residential"'):
            text = text.replace(tag, 'k="natural" v="coastline"')
    path = tmp_path / "a.osm"
    path.write_text(text)
    town, _ = import_osm(path, centre=CENTRE, side_m=200.0, allow_incomplete=True)
    assert from_geojson(to_geojson(town)).digest == town.digest
    for landmark in town.landmarks:
        assert landmark.geometry.is_valid
        assert town.cells(landmark.id).any()


def _import_or_refuse(path, content):
    path.write_bytes(content)
    told = "imported"
    try:
        import_osm(path, centre=CENTRE, side_m=200.0)
    except MapError as error:
        told = str(error)
    assert "\n" not in told
