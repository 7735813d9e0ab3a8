"""What tags say: kinds, measures, names, addresses."""

import pytest

from sloop_ppl.maps._symbols import camel_case, folded, unique
from sloop_ppl.maps.osm._classify import classify, is_underground
from sloop_ppl.maps.osm._feature_names import address, aliases, local_languages, name_of
from sloop_ppl.maps.osm._lengths import length_m, levels
from sloop_ppl.maps.osm._measures import ROAD_WIDTH_M, height_m, road_width_m, unread


@pytest.mark.parametrize(
    ("tags", "shape", "kind", "word"),
    [
        ({"building": "yes"}, "area", "building", "Building"),
        ({"building": "yes", "amenity": "parking"}, "area", "building", "ParkingGarage"),
        ({"amenity": "parking"}, "area", "parking", "ParkingLot"),
        ({"amenity": "parking"}, "point", "poi", "Parking"),
        ({"highway": "motorway_link"}, "line", "street", "Ramp"),
        ({"highway": "service", "service": "alley"}, "line", "service", "Alley"),
        ({"highway": "steps"}, "line", "pedestrian", "Steps"),
        ({"highway": "footway", "area": "yes"}, "area", "pedestrian", "PedestrianArea"),
        ({"highway": "pedestrian", "area": "yes", "name": "A"}, "area", "square", "Square"),
        ({"place": "square"}, "area", "square", "Square"),
        ({"leisure": "playground"}, "area", "park", "Playground"),
        ({"natural": "water"}, "area", "water", "Water"),
        ({"waterway": "river"}, "line", "water", "River"),
        ({"amenity": "university", "name": "A"}, "area", "poi", "University"),
        ({"shop": "yes"}, "point", "poi", "Shop"),
        ({"amenity": "cafe;bar"}, "point", "poi", "Cafe"),
        ({"highway": "bus_stop"}, "point", "poi", "BusStop"),
        ({"amenity": "bench", "name": "Rest"}, "point", "poi", "Bench"),
    ],
)
def test_kinds(tags, shape, kind, word):
    assert classify(tags, shape) == (kind, word)


@pytest.mark.parametrize(
    ("tags", "shape"),
    [
        ({}, "area"), ({"building": "no"}, "area"), ({"building": "entrance"}, "point"),
        ({"building:part": "yes"}, "area"), ({"highway": "proposed"}, "line"),
        ({"highway": "residential"}, "area"), ({"amenity": "bench"}, "point"),
        ({"barrier": "fence"}, "line"), ({"landuse": "residential"}, "area"),
        ({"railway": "rail"}, "line"), ({"highway": "crossing"}, "point"),
        ({"shop": "no"}, "point"),
        ({"shop": "vacant"}, "point"), ({"place": "suburb", "name": "A"}, "area"),
    ],
)  # fmt: skip
def test_what_nobody_refers_to(tags, shape):
    assert classify(tags, shape) is None


@pytest.mark.parametrize(
    ("tags", "below"),
    [
        ({"highway": "footway", "tunnel": "yes"}, True),
        ({"highway": "footway", "tunnel": "building_passage"}, False),
        ({"highway": "footway", "indoor": "yes"}, True),
        ({"highway": "service", "layer": "-1"}, True),
        ({"highway": "service", "layer": "1"}, False),
        ({"amenity": "parking", "parking": "underground"}, True),
        ({"building": "yes", "layer": "-2"}, True),
        ({"shop": "kiosk", "level": "-1"}, False),
        ({"highway": "footway", "level": "0;-1"}, False),
        ({"highway": "footway", "layer": "x"}, False),
    ],
)
def test_underground(tags, below):
    assert is_underground(tags) is below


@pytest.mark.parametrize(
    ("text", "metres"),
    [
        ("12", 12.0), ("3.5 m", 3.5), ("3,5m", 3.5), ("10 ft", 3.048), ("10'", 3.048),
        ("5'6\"", 1.676), ("250 cm", 2.5), ("", None), (None, None), ("wide", None), ("-3", None),
        ("1e9", None), ("12 parsec", None), ("٣", 3.0),
        ("12.5;15", 15.0), ("12 m;14 m", 14.0), ("3-4", 4.0), ("3 – 4 m", 4.0),
        ("10 - 20 ft", 6.096),
        ("~12", 12.0), ("ca. 12", 12.0), ("about 12 m", 12.0), ("13 yd", 11.887), ("40’", 12.192),
        ("40′", 12.192), ("40′ 6″", 12.344), ("40' 6", 12.344), ("12 M", 12.0), ("12½", 12.5),
        ("12 mètres", 12.0), ("１２", 12.0), ("12.", 12.0), (".5", 0.5), ("0.04 km", 40.0),
        ("1,234", None), ("1.200,5", None), ("1O", None), ("3 storeys", None), ("12;tall", None),
        ("-", None), (";", None), ("9" * 500, None), ("camel", None), ("to", None),
    ],
)  # fmt: skip
def test_lengths(text, metres):
    assert length_m(text) == metres


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("3", 3.0), ("3.5", 3.5), ("3,5", 3.5), ("3;4", 4.0), ("3-4", 4.0), ("G+3", 4.0),
        ("~5", 5.0),
        ("٣", 3.0), ("0", 0.0), ("3+1", None), ("4 + attic", None), ("-1", None), ("three", None),
        ("", None), ("nan", None), ("1e3", None),
    ],
)  # fmt: skip
def test_levels(text, number):
    assert levels(text) == number


@pytest.mark.parametrize(
    ("tags", "told"),
    [
        ({"height": "12;15", "building:levels": "0", "width": "?"}, []),
        ({"height": "0", "building:levels": "three"}, ["height=0", "building:levels=three"]),
        ({"height": "5000", "building:levels": "301"}, ["height=5000", "building:levels=301"]),
    ],
)
def test_what_cannot_be_read_is_told(tags, told):
    assert unread(tags, is_building=True) == told
    assert unread({"width": "70", "est_width": "narrow"}, is_building=False) == [
        "width=70", "est_width=narrow",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("tags", "metres"),
    [
        ({"highway": "residential"}, 7.0),
        ({"highway": "residential", "width": "9.5"}, 9.5),
        ({"highway": "residential", "width": "9000"}, 7.0),
        ({"highway": "primary", "lanes": "4"}, 13.0),
        ({"highway": "footway", "lanes": "2"}, 2.0),
        ({"highway": "primary", "lanes": "²"}, 12.0),
        ({"highway": "primary", "est_width": "40 ft"}, 12.192),
        ({"waterway": "river"}, 20.0),
        ({}, 4.0),
    ],
)
def test_road_widths(tags, metres):
    assert road_width_m(tags) == metres


def test_greater_roads_are_wider():
    order = ["motorway", "trunk", "primary", "secondary", "tertiary", "residential", "service",
             "footway", "path"]  # fmt: skip
    widths = [ROAD_WIDTH_M[name] for name in order]
    assert widths == sorted(widths, reverse=True)


@pytest.mark.parametrize(
    ("tags", "metres"),
    [
        ({"height": "40 ft", "building:levels": "9"}, 12.192),
        ({"building:levels": "3"}, 9.0),
        ({"building:levels": "2.5"}, 7.5),
        ({"building:levels": "nan"}, None),
        ({"height": "0"}, None),
        ({}, None),
    ],
)
def test_heights(tags, metres):
    assert height_m(tags) == metres


def test_names_and_other_names():
    tags = {
        "name": "Root  Building", "alt_name": "The Root; Rooty", "old_name": "root building",
        "brand": "Roots", "operator": "Root Inc", "name:en": "Root", "name:fi": "Juuri",
        "addr:street": "Main Street", "addr:housenumber": "12", "addr:housename": "Root House",
    }  # fmt: skip
    assert name_of(tags) == "Root Building"
    assert aliases(tags, "Root Building") == (
        "The Root", "Rooty", "Roots", "Root Inc", "Root House", "Root", "12 Main Street",
    )  # fmt: skip
    assert "Juuri" in aliases(tags, "Root Building", languages=("fi",))


def test_a_road_without_a_name_has_its_number():
    assert name_of({"highway": "motorway", "ref": "I 83"}) == "I 83"
    assert name_of({"shop": "yes", "brand": "Spar"}) == "Spar"
    assert name_of({"shop": "yes", "ref": "7"}) is None
    assert aliases({"highway": "primary", "ref": "US 40", "operator": "State"}, "Oak") == ("US 40",)


@pytest.mark.parametrize(
    ("street", "told"),
    [("Main Street", "7 Main Street"), ("Rue Lamartine", "7 Rue Lamartine"),
     ("Simonkatu", "Simonkatu 7"), ("N. Howard St.", "7 N. Howard St.")],
)  # fmt: skip
def test_addresses(street, told):
    assert address({"addr:street": street, "addr:housenumber": "7"}) == told
    assert address({"addr:street": street}) is None


def test_a_language_is_local_when_a_tenth_of_the_names_are_in_it():
    named = [{"name:fi": "x", "name:zh-Hant": "x"}] * 2 + [{}] * 8 + [{"name:ru": "x"}]
    assert local_languages(named) == ("fi",)
    assert local_languages([]) == ()


@pytest.mark.parametrize(
    ("name", "symbol", "words"),
    [
        ("Root-McBride Building", "RootMcBrideBuilding", "root mcbride building"),
        ("Joe's Café", "JoesCafe", "joes cafe"),
        ("AT&T", "ATAndT", "at and t"),
        ("Straße 9", "Strasse9", "strasse 9"),
        ("東京駅", "東京駅", "東京駅"),
        ("...", "", ""),
        ("U.S. Bank", "USBank", "u s bank"),
        ("Ильинка", "Ильинка", "ильинка"),
    ],
)
def test_symbols(name, symbol, words):
    assert camel_case(name) == symbol
    assert folded(name) == words


def test_symbols_are_numbered_when_taken():
    assert unique("Kiosk", set()) == "Kiosk"
    assert unique("Kiosk", {"Kiosk", "Kiosk2"}) == "Kiosk3"
    assert unique("Pier6", {"Pier6"}) == "Pier6_2"
