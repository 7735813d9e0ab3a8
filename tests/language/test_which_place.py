"""Which place is meant: homonyms, parts of names, kinds, described places and addresses."""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path

import pytest
import shapely

from sloop_ppl.language import NOT_ON_MAP, parse
from sloop_ppl.maps import CityMap, Grid, Landmark, load_map

DATA = Path(__file__).parent / "data"
LINES = [json.loads(line) for line in (DATA / "which_place.jsonl").read_text("utf-8").splitlines()]


@lru_cache
def city_of(name: str) -> CityMap:
    """Return a bundled map, or a square with three places of one name."""
    if name != "homonyms":
        return load_map(name)
    places = (("Kiosk", -75, -75), ("Kiosk2", 75, 75), ("Kiosk3", 75, -75))
    kiosks = [Landmark(i, "poi", shapely.Point(x, y), "Sunny Kiosk") for i, x, y in places]
    mill = Landmark("OldMill", "building", shapely.box(60, 40, 80, 60), "Old Mill")
    return CityMap("homonyms", Grid.square(100), (*kiosks, mill))


@pytest.mark.parametrize("line", LINES, ids=lambda line: line["text"])
def test_the_place_that_is_meant_is_among_the_most_probable(line):
    found = parse(line["text"], city_of(line["map"]))
    if line["best"] == [None]:  # says nothing of where it is
        assert found.relations == ()
        assert [u.status for u in found.unresolved] == ["unknown"]
        return
    (relation,) = found.relations
    shares = {c.ground: c.probability for c in relation.slot(len(relation.grounds) - 1)}
    top = max(shares.values())
    assert any(shares.get(place, 0) == top for place in line["best"])
    assert set(line["among"]) <= shares.keys()
    low, high = line["none"]
    assert low - 1e-9 <= shares.get(None, 0.0) <= high + 1e-9
    assert sum(shares.values()) == pytest.approx(1.0)


def test_who_says_a_whole_name_is_certain_and_a_part_is_not():
    city = city_of("denver")
    (whole,) = parse("The red bike is at the Dresden Apartments.", city).relations
    (part,) = parse("The red bike is at the Dresden.", city).relations
    assert whole.is_certain
    assert not whole.candidates
    assert part.grounds == whole.grounds
    assert 0.8 < part.slot(0)[0].probability < 1


def test_the_place_that_was_spoken_of_is_meant_again():
    text = "The red bike is near the bank. The green car is behind the bank."
    near, behind = parse(text, city_of("honolulu")).relations
    assert near.mentions == behind.mentions
    assert near.candidates == behind.candidates
    apart = "The red bike is near a bank. The green car is behind a bank."
    near, behind = parse(apart, city_of("honolulu")).relations
    assert near.mentions != behind.mentions


def test_one_name_said_twice_is_one_place():
    text = "The red bike is near Sunny Kiosk. The green car is north of Sunny Kiosk."
    near, north = parse(text, city_of("homonyms")).relations
    assert near.mentions == north.mentions


def test_a_kind_that_the_map_lacks_is_nowhere_on_it():
    found = parse("The red bike is behind the windmill.", city_of("denver"))
    assert found.relations == ()
    assert [(u.text, u.status) for u in found.unresolved] == [("windmill", "unknown")]
    (mine,) = parse("I'm behind the windmill.", city_of("denver")).relations
    assert mine.grounds == (NOT_ON_MAP,)
    assert [(c.ground, c.probability) for c in mine.slot(0)] == [(None, 1.0)]


def test_what_holds_a_thing_that_the_map_lacks_is_known():
    (relation,) = parse("The red bike is by the bench in the park.", city_of("honolulu")).relations
    shares = {c.ground: round(c.probability, 2) for c in relation.slot(0)}
    assert max(shares, key=shares.get) == "Park1"
    assert shares[None] > 0.3


def test_nearer_places_are_more_probable_next_to_something():
    def row(*east):
        shops = [
            Landmark(f"Cafe{i}", "poi", shapely.Point(x, 0), properties={"amenity": "cafe"})
            for i, x in enumerate(east, 1)
        ]
        tower = Landmark("Spire", "building", shapely.box(-60, -5, -50, 5), "Zorba Spire")
        return CityMap("row", Grid.square(100), (*shops, tower))

    (relation,) = parse(
        "the red bike is at the cafe next to the Zorba Spire", row(-45, 0, 60)
    ).relations
    shares = {c.ground: c.probability for c in relation.slot(0)}
    assert shares["Cafe1"] > 0.8
    assert shares["Cafe1"] > shares["Cafe2"] > shares["Cafe3"]


def test_one_of_hundreds_is_anywhere():
    houses = [
        Landmark(f"Building{i}", "building", shapely.box(3 * i, 0, 3 * i + 2, 2)) for i in range(90)
    ]
    city = CityMap("row", Grid.square(300), tuple(houses))
    relations = parse("the red bike is behind the building", city).relations
    assert all(len(r.slot(0)) < 70 for r in relations)


@pytest.mark.parametrize(
    ("text", "ids"),
    [
        ("at 12 Quince Street", ["House12"]),
        ("at Quince Street 12", ["House12"]),
        ("at 12, Quince Street", ["House12"]),
        ("at 14 Quince St.", ["House14"]),
        ("at 16 Quince", ["House14"]),
        ("near no. 12", ["House12", "Other12"]),
        ("at 12 Walnut Street", ["Other12"]),
        ("on Quince Street, 12 metres north of Zorba", ["QuinceStreet", "Zorba"]),
        ("12 m from Zorba", ["Zorba"]),
    ],
)
def test_a_number_is_a_house_beside_its_street(text, ids):
    """House numbers by tag, "14-16" as both, and by the nearest street where none is said."""
    streets = [
        Landmark(
            "QuinceStreet", "street", shapely.LineString([(-90, 0), (90, 0)]), "Quince Street"
        ),
        Landmark(
            "WalnutStreet", "street", shapely.LineString([(-90, 80), (90, 80)]), "Walnut Street"
        ),
    ]
    said = {"house_number": "12", "addr:street": "Quince Street"}
    houses = [
        Landmark("House12", "building", shapely.box(0, 5, 8, 12), properties=said),
        Landmark(
            "House14", "building", shapely.box(20, 5, 28, 12), properties={"house_number": "14-16"}
        ),
        Landmark(
            "Other12", "building", shapely.box(0, 68, 8, 75), properties={"house_number": "12"}
        ),
        Landmark("Zorba", "poi", shapely.Point(-50, 40), "Zorba"),
    ]
    city = CityMap("street", Grid.square(100), (*streets, *houses))
    relations = parse(f"the red bike is {text}", city).relations
    found = [c.ground for r in relations for c in r.slot(0) if c.probability > 0.2 and c.ground]
    assert found == ids
