"""Every form in which OpenStreetMap data come gives the same map, whatever the file is called."""

import gzip
import json
import random
import re
import xml.etree.ElementTree as ET

import pytest
from support.osm_block import CENTRE, block

from sloop_ppl.errors import InputError, MapError
from sloop_ppl.maps import load_map, to_geojson, write_map
from sloop_ppl.maps.osm import import_osm

TEXT = block().text()
HEAD, START, *BODY, END, _ = TEXT.split("\n")
NODES = [line for line in BODY if line.startswith("<node")]
WAYS = [line for line in BODY if line.startswith("<way")]
RELATIONS = [line for line in BODY if line.startswith("<relation")]
TAGGED = [line for line in NODES if "<tag" in line]
BARE = [line for line in NODES if "<tag" not in line]
TAGGED_WAYS = sum("<tag" in line for line in WAYS)
PLACES = {
    m[1]: (m[3], m[2]) for m in re.finditer(r'<node id="(\d+)" lat="(\S+)" lon="(\S+)"', TEXT)
}


def written(folder, lines, name="a.osm"):
    path = folder / name
    path.write_text("\n".join([HEAD, START, *lines, END]), encoding="utf-8")
    return path


def imported(path, **options):
    return import_osm(path, centre=CENTRE, side_m=200.0, name="block", **options)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return to_geojson(imported(block().write(tmp_path_factory.mktemp("a") / "a.osm"))[0])


def placed(way):
    """Write the coordinates of its nodes into a way, as `out geom` does."""

    def nd(found):
        lon, lat = PLACES[found[1]]
        return f'<nd ref="{found[1]}" lat="{lat}" lon="{lon}"/>'

    way = re.sub(r'<nd ref="(\d+)"/>', nd, way)
    bounds = '<bounds minlat="41.0" minlon="-81.8" maxlat="42.0" maxlon="-81.0"/>'
    return way.replace("<nd", f"{bounds}<nd", 1)


def overpass(geom):
    elements = []
    for element in ET.fromstring(TEXT):
        tags = {t.get("k"): t.get("v") for t in element.iter("tag")}
        made = {"type": element.tag, "id": int(element.get("id")), "tags": tags}
        if element.tag == "node":
            made |= {"lat": float(element.get("lat")), "lon": float(element.get("lon"))}
            if geom and not tags:
                continue
        elif element.tag == "way":
            refs = [nd.get("ref") for nd in element.iter("nd")]
            made["nodes"] = [int(ref) for ref in refs]
            if geom:
                made["geometry"] = [
                    {"lon": float(PLACES[r][0]), "lat": float(PLACES[r][1])} for r in refs
                ]
        else:
            made["members"] = [
                {"type": m.get("type"), "ref": int(m.get("ref")), "role": m.get("role")}
                for m in element.iter("member")
            ]
        elements.append(made)
    random.Random(0).shuffle(elements)
    return {"version": 0.6, "generator": "Overpass API", "elements": elements}


@pytest.mark.parametrize(
    "lines",
    [
        WAYS + NODES + RELATIONS,
        TAGGED + WAYS + RELATIONS + BARE,
        RELATIONS + WAYS + NODES,
        BARE[:5] + TAGGED + WAYS + BARE[5:] + RELATIONS,
        NODES + WAYS[::-1] + RELATIONS,
        TAGGED + [placed(way) for way in WAYS] + RELATIONS,
        [placed(way) for way in WAYS] + RELATIONS + TAGGED,
    ],
    ids=["ways", "overpass", "relations", "half", "reversed", "geom", "geom of ways first"],
)
def test_elements_in_any_order(tmp_path, whole, lines):
    assert to_geojson(imported(written(tmp_path, lines))[0]) == whole


@pytest.mark.parametrize("name", ["a.osm", "a.xml", "a.txt", "a", "a.osm.pbf", "a.json", "a.osc"])
def test_the_content_decides_and_not_the_suffix(tmp_path, whole, name):
    assert to_geojson(imported(written(tmp_path, BODY, name))[0]) == whole
    (tmp_path / name).write_bytes(gzip.compress(TEXT.encode()))
    assert to_geojson(imported(tmp_path / name)[0]) == whole
    (tmp_path / name).write_text(json.dumps(overpass(False)))
    assert to_geojson(imported(tmp_path / name)[0]) == whole


@pytest.mark.parametrize("geom", [False, True])
def test_overpass_json(tmp_path, whole, geom):
    path = tmp_path / "interpreter"
    path.write_text("\ufeff" + json.dumps(overpass(geom)), encoding="utf-8")
    assert to_geojson(imported(path)[0]) == whole


def test_ways_that_only_their_relation_tells_the_course_of(tmp_path):
    ring = [(41.5, -81.7), (41.5, -81.699), (41.5007, -81.699), (41.5, -81.7)]
    data = {"elements": [{
        "type": "relation", "id": 1, "tags": {"type": "multipolygon", "building": "yes"},
        "members": [{"type": "way", "ref": 5, "role": "outer",
                     "geometry": [{"lat": lat, "lon": lon} for lat, lon in ring]}],
    }]}  # fmt: skip
    path = tmp_path / "a.json"
    path.write_text(json.dumps(data))
    town, _ = import_osm(path, everything=True)
    assert town.landmarks[0].geometry.area == pytest.approx(83.5 * 77.8 / 2, rel=0.01)
    ends = "".join(f'<nd lat="{lat}" lon="{lon}"/>' for lat, lon in ring)
    (tmp_path / "a.osm").write_text(
        f'<osm version="0.6"><relation id="1"><member type="way" ref="5" role="outer">{ends}'
        '</member><tag k="type" v="multipolygon"/><tag k="building" v="yes"/></relation></osm>'
    )
    again, _ = import_osm(tmp_path / "a.osm", everything=True, name="a")
    assert to_geojson(again) == to_geojson(town)


def test_change_files(tmp_path, whole):
    gone = '<node id="77" version="2"/>'
    text = "\n".join([
        HEAD, '<osmChange version="0.6">', "<modify>", *WAYS, "</modify>", "<delete>", gone,
        "</delete>", "<create>", *RELATIONS, *NODES, "</create>", "</osmChange>",
    ])  # fmt: skip
    for name in ("a.osc", "a.osm", "a"):
        (tmp_path / name).write_text(text)
        assert to_geojson(imported(tmp_path / name)[0]) == whole


SHOP = '<tag k="shop" v="yes"/>'


def node(number, version, tags=SHOP, more="", lat=41.5):
    return (f'<node id="{number}" version="{version}" lat="{lat}" lon="-81.7" {more}>'
            f"{tags}</node>")  # fmt: skip


@pytest.mark.parametrize(
    ("lines", "numbers"),
    [
        ([node(1, 1), node(1, 2, "", 'visible="false"'), node(2, 1)], [2]),
        ([node(1, 1), node(1, 2, lat=41.6), node(2, 1)], [2]),
        ([node(1, 2, lat=41.6), node(1, 1), node(2, 1)], [2]),
        ([node(1, 1, more="action='delete' visible='true'"), node(2, 1)], [2]),
        ([node(1, 1), node(2, 1, more='action="modify"')], [1, 2]),
    ],
    ids=["history", "moved", "moved, newest first", "deleted in JOSM", "changed in JOSM"],
)
def test_what_is_there_no_more_is_left_out(tmp_path, lines, numbers):
    town, _ = imported(written(tmp_path, lines))
    assert [m.properties["osm"] for m in town.landmarks] == [[f"node/{i}"] for i in numbers]


def test_a_history_in_pbf(tmp_path):
    import osmium

    path = written(tmp_path, [node(1, 1), node(1, 2, "", 'visible="false"'), node(2, 1)])
    history = str(tmp_path / "a.osh.pbf")
    with osmium.SimpleWriter(history) as writer:
        for thing in osmium.FileProcessor(str(path)):
            writer.add(thing)
    assert [m.properties["osm"] for m in imported(history)[0].landmarks] == [["node/2"]]


def test_overpass_json_of_another_encoding_and_what_is_gone_in_it(tmp_path, whole):
    path = tmp_path / "a.json"
    path.write_text(json.dumps(overpass(False)), encoding="utf-16")
    assert to_geojson(imported(path)[0]) == whole
    gone = {"type": "node", "id": 1, "lat": 41.5, "lon": -81.7, "tags": {"shop": "yes"}}
    path.write_text(json.dumps({"elements": [gone | {"visible": False}, gone | {"id": 2}]}))
    assert [m.properties["osm"] for m in imported(path)[0].landmarks] == [["node/2"]]


def test_pieces_of_one_element_in_geojson_are_all_kept(tmp_path):
    def feature(kind, coordinates, **tags):
        return {"type": "Feature", "properties": {"osm_id": "7", "name": "A", **tags},
                "geometry": {"type": kind, "coordinates": coordinates}}  # fmt: skip

    def box(west):
        east = west + 0.0005
        return [[[west, 41.5], [east, 41.5], [east, 41.5005], [west, 41.5005], [west, 41.5]]]

    path = tmp_path / "cut.geojson"
    for features, length, twice in (
        ([feature("Polygon", box(-81.7), building="yes"),
          feature("MultiPolygon", [box(-81.698)], building="yes")], 4 * (55.6 + 41.7), 0),
        ([feature("LineString", [[-81.7, 41.5], [-81.699, 41.5]], highway="residential"),
          feature("LineString", [[-81.699, 41.5], [-81.698, 41.5]], highway="residential")],
         2 * 83.5, 0),
        ([feature("Polygon", box(-81.7), building="yes"),
          feature("Polygon", box(-81.6999), building="yes")], 2 * (55.6 + 41.7), 1),
    ):  # fmt: skip
        crs = {"type": "name", "properties": None}
        path.write_text(json.dumps({"type": "F", "crs": crs, "features": features}))
        town, report = import_osm(path, everything=True)
        (landmark,) = town.landmarks
        assert landmark.geometry.length == pytest.approx(length, rel=0.01)
        assert report.duplicates == twice


def test_geojson_of_overpass_turbo_and_qgis(tmp_path):
    box = [[-81.7, 41.5], [-81.6995, 41.5], [-81.6995, 41.5003], [-81.7, 41.5003], [-81.7, 41.5]]
    line = [[-81.701, 41.4999], [-81.699, 41.4999]]
    shapes = [{"type": "Polygon", "coordinates": [box]},
              {"type": "LineString", "coordinates": line},
              {"type": "Point", "coordinates": [-81.7003, 41.5001]}]  # fmt: skip
    tags = [{"building": "yes", "name": "Mill House", "addr:street": "Long Lane"},
            {"highway": "residential", "name": "Long Lane"},
            {"amenity": "cafe", "name": "Cafe Blue"}]  # fmt: skip
    names = [("way", 101), ("way", 103), ("node", 900)]
    columns = {key: None for t in tags for key in t}
    hstore = [",".join(f'"{k}"=>"{v}"' for k, v in t.items() if k != "name") for t in tags]
    forms = {
        "turbo": [{"@id": f"{s}/{n}", **t} for (s, n), t in zip(names, tags, strict=True)],
        "old turbo": [{"type": s, "id": n, "tags": t, "relations": [], "meta": {}}
                      for (s, n), t in zip(names, tags, strict=True)],
        "quick": [{"full_id": f"{s[0]}{n}", "osm_id": str(n), "osm_type": s, **columns, **t}
                  for (s, n), t in zip(names, tags, strict=True)],
        "ogr": [{"osm_id": None if i == 0 else str(n), "osm_way_id": str(n) if i == 0 else None,
                 "name": t["name"], "other_tags": h}
                for i, ((_, n), t, h) in enumerate(zip(names, tags, hstore, strict=True))],
    }  # fmt: skip
    made = {}
    for form, properties in forms.items():
        features = [{"type": "Feature", "properties": p, "geometry": g}
                    for p, g in zip(properties, shapes, strict=True)]  # fmt: skip
        path = tmp_path / "export.geojson"
        crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}
        path.write_text(json.dumps({"type": "FeatureCollection", "crs": crs, "features": features}))
        town, _ = import_osm(path, everything=True)
        made[form] = to_geojson(town)
        assert [m.id for m in town.landmarks] == ["MillHouse", "LongLane", "CafeBlue"]
        assert town.landmark("MillHouse").properties["addr:street"] == "Long Lane"
        assert town.landmark("CafeBlue").properties["osm"] == ["node/900"]
    assert all(data == made["turbo"] for data in made.values())
    with pytest.raises(MapError, match="sloop map import"):
        load_map(path)


def test_geojson_that_cannot_be_used(tmp_path):
    path = tmp_path / "a.geojson"
    point = {"type": "Feature", "properties": {"shop": "yes"},
             "geometry": {"type": "Point", "coordinates": [420000.0, 5.0]}}  # fmt: skip
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::3857"}}
    for data, words in (
        ({"features": [point]}, "is not on earth"),
        ({"features": [point], "crs": crs}, "export it in EPSG:4326"),
        ({"features": [7]}, "feature number 0 is no GeoJSON"),
        ({"features": [{"properties": {"shop": "yes"}, "geometry": {"type": "?"}}]}, "no GeoJSON"),
        ([1, 2], "another kind"),
        ({"elements": [{"type": "node"}]}, "element 0 is not as Overpass"),
        ({"elements": [{"type": "node", "id": 1, "lat": 95, "lon": 1}]}, "node/1: field 'lat'"),
    ):
        path.write_text(json.dumps(data))
        with pytest.raises(MapError, match=words) as caught:
            import_osm(path, everything=True)
        assert str(path) in str(caught.value)
    write_map(load_map("cleveland"), path)
    with pytest.raises(MapError, match="is a map already"):
        import_osm(path, everything=True)
    path.write_text('{"features":' * 100_000)
    with pytest.raises(MapError, match="cannot be read as JSON"):
        import_osm(path, everything=True)


@pytest.mark.parametrize(
    ("text", "words"),
    [("<!DOCTYPE html><html><body>429 Too Many Requests</body></html>", "a web page"),
     ("<?xml version='1.0'?><gpx></gpx>", "is GPX"), ("PK\x03\x04xx", "zip archive")],
)  # fmt: skip
def test_what_is_plainly_something_else_is_called_by_name(tmp_path, text, words):
    (tmp_path / "a.osm").write_text(text)
    with pytest.raises(MapError, match=words):
        import_osm(tmp_path / "a.osm", everything=True)


def test_an_import_stops_when_a_tenth_lacks_its_nodes(tmp_path, whole):
    path = written(tmp_path, TAGGED + WAYS)
    with pytest.raises(MapError) as caught:
        imported(path)
    assert f"lacks nodes of {TAGGED_WAYS} of its {TAGGED_WAYS} ways" in str(caught.value)
    assert "--allow-incomplete" in str(caught.value)
    town, report = imported(path, allow_incomplete=True)
    assert not town.of_kind("building")
    assert report.no_coordinates == TAGGED_WAYS
    assert report.outside == 0
    assert f"left out, without coordinates in the file: {TAGGED_WAYS}" in report.lines()
    # One way in more than ten is no reason to stop.
    many = [
        f'<way id="{i}"><nd ref="{ref}"/><nd ref="1000"/><tag k="highway" v="path"/></way>'
        for i, ref in zip(range(500, 512), [*list(PLACES)[1:12], "9999999"], strict=True)
    ]
    assert imported(written(tmp_path, NODES + many))[1].lost_ways == 1


def test_a_relation_alone_is_refused(tmp_path):
    relation = (
        '<relation id="1"><member type="way" ref="7" role="outer"/>'
        '<tag k="type" v="multipolygon"/><tag k="building" v="yes"/></relation>'
    )
    with pytest.raises(MapError, match="lacks ways or their nodes of 1 of its 1 relations"):
        imported(written(tmp_path, [*TAGGED, relation]))


def test_an_answer_that_the_server_cut_off_is_refused(tmp_path):
    remark = 'runtime error: Query timed out in "query" at line 3 after 26 seconds.'
    path = written(tmp_path, [*BODY, f"<remark> {remark} </remark>"])
    with pytest.raises(MapError, match="ends early, the server says: runtime error"):
        imported(path)
    assert imported(path, allow_incomplete=True)[0].landmarks
    path.write_text(json.dumps(overpass(False) | {"remark": remark}))
    with pytest.raises(MapError, match="ends early"):
        imported(path)


def test_all_of_a_file_without_bounds_holds_its_outermost_points(tmp_path):
    places = [(41.50000001, -81.70000003), (41.50123457, -81.69876543), (41.5, -81.69)]
    lines = [f'<node id="{i + 1}" lat="{lat}" lon="{lon}"><tag k="shop" v="yes"/></node>'
             for i, (lat, lon) in enumerate(places)]  # fmt: skip
    town, _ = import_osm(written(tmp_path, lines), everything=True)
    assert len(town.landmarks) == 3


def test_a_file_of_one_point(tmp_path):
    line = '<node id="1" lat="41.5" lon="-81.7"><tag k="shop" v="yes"/></node>'
    town, _ = import_osm(written(tmp_path, [line]), everything=True)
    assert [m.id for m in town.landmarks] == ["Shop1"]
    assert town.grid.extent_m == pytest.approx((-50, -50, 50, 50), abs=0.02)
    with_bounds = '<bounds minlat="41.5" minlon="-81.7" maxlat="41.5" maxlon="-81.7"/>'
    again, _ = import_osm(written(tmp_path, [with_bounds, line]), everything=True)
    assert to_geojson(again) == to_geojson(town)


def test_a_window_that_reaches_beyond_the_extract_is_said(tmp_path):
    bounds = '<bounds minlat="41.499" minlon="-81.701" maxlat="41.501" maxlon="-81.6999"/>'
    town, report = imported(written(tmp_path, [bounds, *BODY]))
    assert report.beyond_m == pytest.approx({"west": 16.5, "east": 91.7}, abs=0.2)
    assert report.lines()[-1] == (
        "the patch reaches beyond the file, where nothing is known: 17 m west, 92 m east"
    )
    assert town.grid.extent_m == (-100, -100, 100, 100)
    # Without bounds the outermost feature is the border, and a bare strip is none.
    assert not imported(written(tmp_path, BODY))[1].beyond_m
    _, far = import_osm(written(tmp_path, BODY), centre=CENTRE, side_m=400.0)
    assert set(far.beyond_m) == {"west", "south", "east", "north"}


FIJI = [
    '<node id="1" lat="-16.8" lon="179.9995"/>', '<node id="2" lat="-16.8" lon="-179.9995"/>',
    '<node id="3" lat="-16.8005" lon="-179.9998"><tag k="shop" v="yes"/></node>',
    '<node id="4" lat="-16.8005" lon="179.9998"><tag k="amenity" v="cafe"/></node>',
    '<node id="5" lat="-16.8005" lon="0.0"><tag k="amenity" v="bank"/></node>',
    '<way id="1"><nd ref="1"/><nd ref="2"/><tag k="highway" v="residential"/></way>',
]  # fmt: skip


def test_windows_and_boxes_across_longitude_180(tmp_path):
    path = written(tmp_path, FIJI)
    made = [
        import_osm(path, centre=(-16.8003, 180.0), side_m=200.0)[0],
        import_osm(path, centre=(-16.8003, -179.9999), side_m=200.0)[0],
        import_osm(path, bbox=(179.999, -16.801, -179.999, -16.7995))[0],
    ]
    near = [line for line in FIJI if 'id="5"' not in line]
    made.append(import_osm(written(tmp_path, near), everything=True)[0])
    bounds = '<bounds minlat="-16.801" minlon="179.999" maxlat="-16.7995" maxlon="-179.999"/>'
    made.append(import_osm(written(tmp_path, [bounds, *FIJI]), everything=True)[0])
    for town in made:
        assert [m.id for m in town.landmarks] == ["Street1", "Shop1", "Cafe1"]
        assert town.landmark("Street1").geometry.length == pytest.approx(106.6, abs=0.5)
        assert max(town.grid.extent_m) < 200
    with pytest.raises(InputError, match="are they swapped"):
        import_osm(path, bbox=(-76.6, 39.28, -76.61, 39.29))
