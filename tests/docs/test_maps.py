"""The two lines of docs/maps.md for each source bring in a file as that source writes it."""

from __future__ import annotations

import json
import re
import shlex

import osmium
import pytest
from support.tree import ROOT

from sloop_ppl.cli import main
from sloop_ppl.maps import load_map

PAGE = (ROOT / "docs" / "maps.md").read_text(encoding="utf-8")
BLOCK = PAGE.split("the two lines that bring it in:")[1].split("```")[1]
SOURCES = {
    comment.split(",")[0].split(":")[0].removeprefix("# "): lines
    for comment, *lines in (part.splitlines() for part in BLOCK.strip().split("\n\n"))
}

TAGS = {
    "way/1": {"building": "church", "name": "St Agnes", "addr:street": "Mill Lane"},
    "way/2": {"highway": "residential", "name": "Mill Lane"},
    "node/9": {"amenity": "cafe", "name": "The Kettle"},
}
# Metres-like offsets in degrees from the place that the lines on the page are about.
NODES = {1: (0, 0), 2: (0, 2), 3: (2, 2), 4: (2, 0), 5: (-1, -5), 6: (-1, 5), 9: (1, 4)}
REFS = {1: [1, 2, 3, 4, 1], 2: [5, 6]}
TOWN, VALLETTA = (41.502, -81.695), (35.8989, 14.5146)


def place(number, town=TOWN):
    north, east = NODES[number]
    return round(town[0] + north * 1e-4, 7), round(town[1] + east * 1e-4, 7)


def xml_tags(source):
    return "".join(f'<tag k="{k}" v="{v}"/>' for k, v in TAGS.get(source, {}).items())


def from_openstreetmap_org(path):
    """Write what "Export" gives: bounds, who did it, and relations of which little is there."""
    who = 'visible="true" version="3" user="a" uid="1" timestamp="2024-01-01T00:00:00Z"'
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<osm version="0.6" generator="openstreetmap-cgimap 2.0.1" attribution="OpenStreetMap">',
        ' <bounds minlat="41.499" minlon="-81.7" maxlat="41.505" maxlon="-81.69"/>',
    ]
    for number in NODES:
        lat, lon = place(number)
        lines.append(f'<node id="{number}" {who} lat="{lat}" lon="{lon}">'
                     f'{xml_tags(f"node/{number}")}</node>')  # fmt: skip
    for number, refs in REFS.items():
        nds = "".join(f'<nd ref="{ref}"/>' for ref in refs)
        lines.append(f'<way id="{number}" {who}>{nds}{xml_tags(f"way/{number}")}</way>')
    lines += [
        f'<relation id="{number}" {who}><member type="way" ref="77" role="outer"/>'
        f'<member type="way" ref="2" role=""/><tag k="type" v="{kind}"/></relation>'
        for number, kind in enumerate(("boundary", "route"), 1)
    ]
    path.write_text("\n".join([*lines, "</osm>"]))


def from_overpass(path):
    """Write JSON of `(._;>;); out body;`: what has tags in the midst of what has none."""
    elements = [
        {"type": "way", "id": n, "nodes": refs, "tags": TAGS[f"way/{n}"]}
        for n, refs in REFS.items()
    ]
    for number in NODES:
        lat, lon = place(number)
        tags = {"tags": TAGS[f"node/{number}"]} if f"node/{number}" in TAGS else {}
        elements.append({"type": "node", "id": number, "lat": lat, "lon": lon, **tags})
    path.write_text(json.dumps({
        "version": 0.6, "generator": "Overpass API 0.7.62.4",
        "osm3s": {"timestamp_osm_base": "2024-01-01T00:00:00Z", "copyright": "ODbL"},
        "elements": elements,
    }, indent=2))  # fmt: skip


def features(properties):
    """Return GeoJSON features of the town, their properties made of a source and its tags."""
    found = []
    for source, tags in TAGS.items():
        sort, number = source.split("/")
        points = [place(ref)[::-1] for ref in (REFS[int(number)] if sort == "way" else [9])]
        shape = {"type": "Point", "coordinates": points[0]}
        if sort == "way":
            ring = points[0] == points[-1]
            shape = {"type": "Polygon" if ring else "LineString",
                     "coordinates": [points] if ring else points}  # fmt: skip
        found.append({"type": "Feature", "properties": properties(source, tags), "geometry": shape})
    return found


def from_overpass_turbo(path):
    """Write the GeoJSON of "Export"."""
    made = features(lambda source, tags: {"@id": source, **tags})
    for feature in made:
        feature["id"] = feature["properties"]["@id"]
    path.write_text(json.dumps({
        "type": "FeatureCollection", "generator": "overpass-turbo", "copyright": "ODbL",
        "timestamp": "2024-01-01T00:00:00Z", "features": made,
    }))  # fmt: skip


def from_geofabrik(path):
    """Write a country in pbf, sorted, with much that is far away."""
    with osmium.SimpleWriter(str(path)) as writer:
        for number in [*NODES, 100]:
            lat, lon = (36.05, 14.19) if number == 100 else place(number, VALLETTA)
            tags = TAGS.get(f"node/{number}", {"shop": "yes"} if number == 100 else {})
            writer.add_node(osmium.osm.mutable.Node(id=number, version=1, location=(lon, lat),
                                                    tags=tags))  # fmt: skip
        for number, refs in REFS.items():
            writer.add_way(osmium.osm.mutable.Way(id=number, version=1, nodes=refs,
                                                  tags=TAGS[f"way/{number}"]))  # fmt: skip


def from_qgis(path):
    """Write a layer of an .osm.pbf, as OGR lays its tags out in columns."""

    def columns(source, tags):
        _, number = source.split("/")
        area = "building" in tags
        rest = ",".join(f'"{k}"=>"{v}"' for k, v in tags.items() if k != "name")
        return {"fid": number, "osm_id": None if area else number,
                "osm_way_id": number if area else None, "name": tags["name"], "barrier": None,
                "z_order": 0, "other_tags": rest}  # fmt: skip

    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}
    path.write_text(json.dumps({
        "type": "FeatureCollection", "name": "layer", "crs": crs, "features": features(columns),
    }))  # fmt: skip


WRITTEN = {
    "openstreetmap.org": from_openstreetmap_org,
    "Overpass": from_overpass,
    "overpass-turbo.eu": from_overpass_turbo,
    "Geofabrik": from_geofabrik,
    "QGIS": from_qgis,
}


def test_every_common_source_has_its_two_lines():
    assert set(SOURCES) == set(WRITTEN)
    assert all(len(lines) == 2 for lines in SOURCES.values())


@pytest.mark.parametrize("source", WRITTEN)
def test_two_lines_bring_a_file_in(source, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    fetch, bring_in = SOURCES[source]
    command = shlex.split(bring_in)
    assert command[:3] == ["sloop", "map", "import"]
    assert re.search(rf"(^|[\s/]){re.escape(command[3])}(\s|$)", fetch) or command[3] in fetch
    WRITTEN[source](tmp_path / command[3])
    with pytest.raises(SystemExit) as stopped:
        main(command[1:])
    assert stopped.value.code == 0, capsys.readouterr().err
    city = load_map(tmp_path / command[command.index("--out") + 1])
    assert {m.id: m.kind for m in city.landmarks} == {
        "StAgnes": "building", "MillLane": "street", "TheKettle": "poi",
    }  # fmt: skip
    assert city.landmark("StAgnes").properties["osm"] == ["way/1"]
    assert city.landmark("TheKettle").properties["osm"] == ["node/9"]
    assert 250 < city.landmark("StAgnes").geometry.area < 450  # 22 m by 17 or 18 m
