"""A hand-made block becomes the map one would draw of it."""

import math
import re

import numpy as np
import pytest
import shapely
from support.osm_block import CENTRE, OsmWriter, block

from sloop_ppl.errors import InputError, MapError
from sloop_ppl.maps import read_map, to_geojson, write_map
from sloop_ppl.maps.osm import import_osm


def imported(osm: OsmWriter, folder, side_m=200.0, **options):
    return import_osm(osm.write(folder / "block.osm"), centre=CENTRE, side_m=side_m, **options)


@pytest.fixture
def town(tmp_path):
    return imported(block(), tmp_path)[0]


def test_the_block_has_the_kinds_one_would_draw(town):
    assert town.name == "block"
    assert town.counts() == {
        "building": 4, "street": 2, "service": 1, "pedestrian": 1, "parking": 1, "park": 1,
        "poi": 4,
    }  # fmt: skip
    assert [m.id for m in town.landmarks] == [
        "FirstBank", "Building1", "Building2", "TheCourt", "MainSt", "OakAvenue", "Alley1",
        "Footway1", "ParkingLot1", "GreenPark", "Joes", "BusStop1", "Joes2", "Shop1",
    ]  # fmt: skip


def test_geometry_is_where_it_was_drawn(town):
    bank = town.landmark("FirstBank").geometry
    assert np.allclose(bank.bounds, (-60, -10, -30, 10), atol=0.01)
    court = town.landmark("TheCourt").geometry
    assert len(court.interiors) == 1
    assert court.area == pytest.approx(40 * 40 - 20 * 20, abs=0.5)


def test_pieces_of_a_street_are_one_landmark_as_wide_as_its_greater_piece(town):
    street = town.landmark("MainSt")
    assert street.geometry.length == pytest.approx(170, abs=0.02)
    assert street.geometry.geom_type == "LineString"
    assert street.width_m == 6.5  # two lanes of 3.25 m, those of the longer piece
    assert street.properties["osm"] == ["way/10", "way/11"]


def test_what_belongs_to_a_building_is_kept_on_it(town):
    bank = town.landmark("FirstBank")
    assert [door["entrance"] for door in bank.properties["entrances"]] == ["main", "yes"]
    assert bank.properties["height_m"] == pytest.approx(12.192)
    assert bank.properties["house_number"] == "12"
    assert bank.aliases == ("12 Main Street",)
    shop = town.landmark("Building1")
    assert shop.properties["height_m"] == 9.0
    assert shop.properties["addr:housenumber"] == "7"
    assert shop.properties["addresses"] == ["7 Oak Ave"]


def test_places_stand_within_their_building_and_take_its_cells(town):
    assert town.landmark("Joes").within == town.landmark("Joes2").within == "Building1"
    assert town.landmark("Shop1").within == "TheCourt"
    assert town.landmark("BusStop1").within is None
    assert (town.cells("Joes") == town.cells("Building1")).all()


def test_frontage_by_address_entrance_and_nearest_street(town):
    bank = town.frontage("FirstBank")
    assert bank.by_address.street.id == bank.by_entrance.street.id == "MainSt"
    assert bank.by_address.bearing_rad == pytest.approx(-math.pi / 2, abs=1e-3)
    assert bank.by_entrance.bearing_rad == pytest.approx(-math.pi / 2, abs=1e-3)
    shop = town.frontage("Building1")
    assert shop.by_address.street.id == "OakAvenue"  # by its other name
    assert shop.bearing_rad == pytest.approx(0, abs=1e-3)
    assert shop.by_entrance is None
    assert [m.id for m in town.streets_of("FirstBank")] == ["MainSt", "OakAvenue"]


def test_what_is_imported_is_what_is_read_back(town, tmp_path):
    write_map(town, tmp_path / "town.geojson")
    again = read_map(tmp_path / "town.geojson")
    assert again.digest == town.digest
    assert to_geojson(again) == to_geojson(town)


def test_the_same_file_gives_the_same_map(tmp_path):
    first, second = (to_geojson(imported(block(), tmp_path)[0]) for _ in range(2))
    assert first == second


def test_ids_do_not_depend_on_the_order_in_the_file(tmp_path):
    turned = block()
    turned.ways.reverse()
    turned.nodes.reverse()
    turned.nodes, turned.ways = turned.ways, turned.nodes  # ways first
    assert to_geojson(imported(turned, tmp_path)[0]) == to_geojson(imported(block(), tmp_path)[0])


def test_the_report_tells_what_was_left_out(tmp_path):
    _, report = imported(block(), tmp_path)
    assert (report.entrances, report.addresses, report.underground) == (2, 1, 1)
    assert report.merged == 1
    assert report.kept["building"] == 4
    assert "left out, below ground: 1" in report.lines()


def test_lines_and_areas_are_cut_at_the_border(tmp_path):
    town, _ = imported(block(), tmp_path, side_m=100.0)
    assert town.grid.extent_m == (-50, -50, 50, 50)
    assert np.allclose(town.landmark("MainSt").geometry.bounds, (-50, -20, 50, -20), atol=0.01)
    assert np.allclose(town.landmark("FirstBank").geometry.bounds, (-50, -10, -30, 10), atol=0.01)


def test_a_box_need_not_be_square(tmp_path):
    path = block().write(tmp_path / "block.osm")
    lat, lon = CENTRE
    town, _ = import_osm(path, bbox=(lon - 0.001, lat - 0.0003, lon + 0.001, lat + 0.0003))
    west, south, east, north = town.grid.extent_m
    assert east - west == pytest.approx(167.0, abs=0.5)
    assert north - south == pytest.approx(66.6, abs=0.5)
    assert town.grid.shape == (14, 34)
    assert town.cells("OakAvenue").shape == (14, 34)


def test_everything_takes_the_bounds_of_what_is_there(tmp_path):
    town, _ = import_osm(block().write(tmp_path / "block.osm"), everything=True)
    assert town.grid.extent_m == pytest.approx((-85, -90, 85, 90), abs=0.1)


def test_a_self_crossing_outline_is_repaired_and_reported(tmp_path):
    osm = block()
    osm.way(40, (60, 60), (80, 80), (80, 60), (60, 80), (60, 60), building="yes", name="Bow Tie")
    town, report = imported(osm, tmp_path)
    assert report.repaired == ["way/40"]
    tie = town.landmark("BowTie").geometry
    assert tie.is_valid
    assert tie.area == pytest.approx(200, abs=0.5)
    assert "outlines that cross themselves, repaired: 1 (way/40)" in report.lines()


def test_a_relation_whose_ring_crosses_itself_is_repaired_and_reported(tmp_path):
    osm = block()
    osm.way(40, (60, 60), (90, 90), (90, 60))
    osm.way(41, (90, 60), (60, 90), (60, 60))
    osm.box(42, 62, 70, 64, 80)
    osm.relation(
        50, ("way", 40, "outer"), ("way", 41, "outer"), ("way", 42, "inner"), type="multipolygon",
        building="yes", name="Bow Tie",
    )  # fmt: skip
    town, report = imported(osm, tmp_path)
    assert (report.repaired, report.incomplete) == (["relation/50"], 0)
    assert town.landmark("BowTie").geometry.area == pytest.approx(2 * 225 - 20, abs=0.5)


def test_a_relation_that_encloses_nothing_is_reported(tmp_path):
    osm = block()
    osm.way(40, (60, 60), (90, 90), (90, 60))
    osm.relation(50, ("way", 40, "outer"), type="multipolygon", building="yes", name="Open")
    town, report = imported(osm, tmp_path)
    assert report.broken == ["relation/50"]
    assert "Open" not in town


def test_an_outline_without_area_is_left_out_and_reported(tmp_path):
    osm = block()
    osm.way(40, (60, 60), (80, 60), (60, 60), (80, 60), (60, 60), building="yes", name="Flat")
    town, report = imported(osm, tmp_path)
    assert report.broken == ["way/40"]
    assert "Flat" not in town


def test_the_newest_of_two_versions_counts(tmp_path):
    osm = block()
    osm.box(24, 30, -60, 50, -40, version=3, building="yes", name="New")
    osm.box(24, 30, -60, 50, -40, version=2, building="yes", name="Old")
    town, report = imported(osm, tmp_path)
    assert "New" in town
    assert "Old" not in town
    assert report.duplicates == 2
    assert "twice in the file, newest version kept: 2" in report.lines()


def test_what_has_not_been_uploaded_has_ids_below_zero(tmp_path):
    path = tmp_path / "drawn.osm"
    text = block().text()
    path.write_text(re.sub(r'\b(id|ref)="(\d+)"', r'\1="-\2"', text))
    town, _ = import_osm(path, centre=CENTRE, side_m=200.0)
    assert town.landmark("MainSt").properties["osm"] == ["way/-11", "way/-10"]
    assert town.counts() == imported(block(), tmp_path)[0].counts()
    path.write_text(re.sub(r'(<node id|<nd ref)="(\d+)"', r'\1="-\2"', text))
    town, _ = import_osm(path, centre=CENTRE, side_m=200.0)
    assert town.landmark("MainSt").properties["osm"] == ["way/10", "way/11"]


def test_a_relation_without_its_members_and_a_way_without_a_node_are_told(tmp_path):
    osm = block()
    osm.relation(31, ("way", 999, "outer"), type="multipolygon", building="yes")
    osm.ways.append('<way id="41"><nd ref="77"/><nd ref="1000"/><nd ref="1001"/>'
                    '<tag k="highway" v="path"/></way>')  # fmt: skip
    _, report = imported(osm, tmp_path, allow_incomplete=True)
    assert (report.incomplete, report.cut_short) == (1, 1)


def test_a_square_takes_in_the_lines_that_cross_it(tmp_path):
    osm = block()
    osm.box(40, 30, 60, 80, 90, place="square", name="Old Market")
    osm.way(41, (32, 75), (78, 75), highway="pedestrian", name="Old Market")
    town, _ = imported(osm, tmp_path)
    market = town.landmark("OldMarket")
    assert market.kind == "square"
    assert market.properties["osm"] == ["way/40", "way/41"]
    assert market.geometry.area == pytest.approx(50 * 30, abs=0.5)


def test_a_place_of_its_buildings_name_is_the_building(tmp_path):
    osm = block()
    osm.node(-45, 0, 110, tourism="museum", name="first bank")
    town, _ = imported(osm, tmp_path)
    assert len(town.of_kind("poi")) == 4
    assert town.landmark("FirstBank").properties["tourism"] == "museum"


def test_streets_come_from_associated_street_relations(tmp_path):
    osm = block()
    osm.relation(
        32, ("way", 24, "house"), ("way", 12, "street"), type="associatedStreet", name="Oak Avenue"
    )
    town, _ = imported(osm, tmp_path)
    assert town.frontage("Building2").by_address.street.id == "OakAvenue"


def test_a_door_at_a_corner_faces_between_both_walls(tmp_path):
    osm = block()
    osm.node(50, -40, 111, entrance="main")
    town, _ = imported(osm, tmp_path)
    assert town.frontage("Building2").by_entrance.bearing_rad == pytest.approx(
        math.pi / 4, abs=0.01
    )


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "The patch is given in no way or in several"),
        ({"centre": CENTRE}, "centre and side_m go together; one of them is missing"),
        ({"side_m": 200.0, "everything": True}, "The patch is given in no way or in several"),
        ({"centre": (-81.7, 141.5), "side_m": 200.0}, "has nothing to map round lat -81.7"),
        ({"centre": (241.5, 41.5), "side_m": 200.0}, "centre is 241.5,41.5; expected latitude"),
        ({"centre": CENTRE, "side_m": math.nan}, "side_m is nan; expected metres"),
        ({"centre": CENTRE, "side_m": -1.0}, "side_m is -1; expected metres"),
        ({"centre": (math.inf, 1.0), "side_m": 1.0}, "expected latitude,longitude in degrees"),
        ({"bbox": (1.0, 2.0, 3.0)}, "expected west,south,east,north in degrees"),
        ({"bbox": (3.0, 2.0, 1.0, 4.0)}, "expected west,south,east,north in degrees"),
        ({"everything": True, "cell_m": 0.0}, "cell_m is 0.0; expected a positive number"),
        ({"everything": True, "cell_m": 1e-5}, "expected 50,000,000 at most"),
    ],
)
def test_a_patch_that_cannot_be_is_refused(tmp_path, given, message):
    path = block().write(tmp_path / "block.osm")
    with pytest.raises(InputError) as caught:
        import_osm(path, **given)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_swapped_coordinates_are_recognised(tmp_path):
    path = block().write(tmp_path / "block.osm")
    path.write_text(path.read_text().replace(
        '<osm version="0.6">',
        '<osm version="0.6">'
        '<bounds minlat="41.49" minlon="-81.71" maxlat="41.51" maxlon="-81.69"/>',
    ))  # fmt: skip
    with pytest.raises(MapError, match="latitude and longitude are swapped"):
        import_osm(path, centre=(-81.7, 41.5), side_m=200.0)


def test_progress_is_told(tmp_path):
    told = []
    imported(block(), tmp_path, progress=told.append)
    assert told[0] == "reading block.osm"
    assert len(told) == 3


def test_areas_survive_projection_whole(town):
    assert all(shapely.is_valid(m.geometry) for m in town.landmarks)


def test_a_building_on_a_way_and_on_its_relation_is_one(tmp_path):
    osm = block()
    osm.box(50, 30, 60, 60, 90, building="yes", name="Twin Hall", height="12")
    osm.box(51, 40, 70, 50, 80)
    osm.relation(
        32, ("way", 50, "outer"), ("way", 51, "inner"),
        type="multipolygon", building="civic", name="Twin hall",
    )  # fmt: skip
    osm.box(52, 65, 60, 75, 90, building="yes")
    osm.box(53, 78, 60, 88, 90, building="yes", name="East Wing")
    osm.relation(
        33, ("way", 52, "outer"), ("way", 53, "outer"),
        type="multipolygon", building="yes", name="Both Wings",
    )  # fmt: skip
    town, report = imported(osm, tmp_path)
    before, _ = imported(block(), tmp_path)
    names = [m.name for m in town.of_kind("building")]
    # A wing with a name of its own stays.
    assert sorted(n for n in names if n) == [
        "Both Wings", "East Wing", "First Bank", "The Court", "Twin hall",
    ]  # fmt: skip
    assert len(names) == len(before.of_kind("building")) + 3
    hall = town.landmark("TwinHall")
    assert hall.properties["osm"] == ["way/50", "relation/32"]
    assert hall.geometry.area == pytest.approx(30 * 30 - 10 * 10, abs=0.5)
    assert (hall.properties["height_m"], hall.properties["building"]) == (12.0, "civic")
    assert report.merged == 3


def test_heights_that_cannot_be_read_are_in_the_report(tmp_path):
    osm = block()
    osm.box(50, 30, 60, 60, 90, building="yes", height="very tall", **{"building:levels": "2-3"})
    osm.way(51, (-80, 40), (-70, 40), highway="path", width="wide")
    town, report = imported(osm, tmp_path)
    assert report.unread == ["way/50 height=very tall", "way/51 width=wide"]
    assert report.lines()[-1] == (
        "heights, levels and widths that cannot be read: 2 "
        "(way/50 height=very tall, way/51 width=wide)"
    )
    (tall,) = [m for m in town.landmarks if m.properties["osm"] == ["way/50"]]
    assert tall.properties["height_m"] == 9.0
