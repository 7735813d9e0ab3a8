"""Every shared extract imports, and what is imported can be used."""

from pathlib import Path

import pytest

from sloop_ppl.maps import read_map, to_geojson, write_map
from sloop_ppl.maps.osm import import_osm

FOLDER = Path(__file__).parents[4] / "shared" / "data" / "osm"
FILES = sorted(path.name for path in FOLDER.glob("*.osm*")) or ["helsinki.osm.pbf"]

# Landmarks by kind, as recorded; a change of the importer that moves them shall be meant.
KINDS = ("building", "street", "service", "pedestrian", "parking", "park", "water", "square", "poi")
RECORDED = {
    "austin_campus.osm": (342, 34, 97, 746, 20, 41, 2, 1, 46),
    "baltimore.osm.pbf": (1730, 624, 1402, 404, 140, 136, 19, 0, 667),
    "citysim.osm": (540, 42, 151, 32, 13, 0, 1, 0, 63),
    "harrisburg.osm.pbf": (583, 1551, 288, 18, 99, 20, 21, 0, 234),
    "helsinki.osm.pbf": (443, 70, 174, 1158, 26, 103, 14, 12, 1790),
    "new_york_block.osm.pbf": (1516, 34, 2, 21, 1, 12, 1, 0, 179),
    "paris.osm": (737, 33, 7, 53, 0, 7, 0, 2, 451),
}

pytestmark = pytest.mark.skipif(not FOLDER.exists(), reason="shared/data/osm is not here")


@pytest.mark.parametrize("name", FILES)
def test_all_of_an_extract_imports_and_reads_back(name, tmp_path):
    city, report = import_osm(FOLDER / name, everything=True)
    assert len(city.landmarks) > 500
    assert city.counts() == report.kept
    assert tuple(report.kept.get(kind, 0) for kind in KINDS) == RECORDED[name]
    assert all(m.geometry.is_valid for m in city.landmarks)
    write_map(city, tmp_path / "city.geojson")
    again = read_map(tmp_path / "city.geojson")
    assert again.digest == city.digest
    assert to_geojson(again) == to_geojson(city)


def test_a_patch_of_helsinki():
    city, _ = import_osm(FOLDER / "helsinki.osm.pbf", centre=(60.1699, 24.9384), side_m=200.0)
    assert city.grid.shape == (41, 41)
    assert len([m for m in city.of_kind("street") if m.name == "Mannerheimintie"]) == 1
    assert "MannerheimintieStreet" not in city
    assert any(len(m.geometry.interiors) for m in city.of_kind("building")
               if m.geometry.geom_type == "Polygon")  # fmt: skip
    for landmark in city.landmarks:
        assert city.cells(landmark.id).any()


def test_main_entrances_mostly_face_the_street_of_the_address():
    city, _ = import_osm(FOLDER / "helsinki.osm.pbf", everything=True)
    both = [f for f in map(city.frontage, (b.id for b in city.of_kind("building")))
            if f.by_address and f.by_entrance]  # fmt: skip
    agree = [f for f in both if abs(f.by_address.bearing_rad - f.by_entrance.bearing_rad) < 0.5]
    assert len(both) >= 25
    assert len(agree) / len(both) > 0.6
