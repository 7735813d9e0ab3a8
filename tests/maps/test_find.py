"""A name, an alias, a kind or a misspelling leads to the landmarks it may mean."""

import pytest
import shapely

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap, Grid, Landmark, kind_words, load_map


def place(landmark_id, name=None, aliases=(), kind="poi", **tags):
    return Landmark(
        landmark_id, kind, shapely.Point(0, 0), name=name, aliases=aliases, properties=tags
    )


CITY = CityMap(
    "small",
    Grid.square(50.0),
    (
        place("Joes", "Joe's", amenity="cafe"),
        place("BlueBottle", "Blue Bottle", ("The Bottle", "Café Bleu"), amenity="cafe"),
        place("FourthSt", "4th Street", kind="street"),
        place("FifthSt", "5th Street", kind="street"),
        place("DresdenApartments", "Dresden Apartments", kind="building"),
        place("Parking1", kind="parking"),
        place("Sushi", "Sushi Go", amenity="restaurant", cuisine="japanese;sushi"),
        place("Bottle", "Bottle Bank", amenity="recycling"),
    ),
)


@pytest.mark.parametrize(
    ("asked", "found"),
    [
        ("Joe's", ["Joes"]),
        ("joes", ["Joes"]),
        ("the blue bottle", ["BlueBottle"]),
        ("BlueBottle", ["BlueBottle"]),
        ("bottle", ["Bottle"]),  # an id comes before an alias
        ("cafe bleu", ["BlueBottle"]),
        ("the cafe", ["Joes", "BlueBottle"]),
        ("a coffee shop", ["Joes", "BlueBottle"]),
        ("parking lot", ["Parking1"]),
        ("japanese", ["Sushi"]),
        ("Dresdn Apartmnts", ["DresdenApartments"]),
        ("dresden", ["DresdenApartments"]),
        ("5th street", ["FifthSt"]),
        ("5th stret", ["FifthSt"]),
        ("6th street", []),
        ("zebra", []),
        ("", []),
        ("...", []),
    ],
)
def test_find(asked, found):
    assert [m.id for m in CITY.find(asked)] == found


def test_at_most_as_many_as_asked_for():
    assert [m.id for m in CITY.find("cafe", limit=1)] == ["Joes"]
    with pytest.raises(InputError, match=r"^limit is 0; expected 1 or more$"):
        CITY.find("cafe", limit=0)


def test_every_landmark_of_a_bundled_map_is_found_by_its_name():
    city = load_map("cleveland")
    for landmark in city.landmarks:
        assert landmark in city.find(landmark.label, limit=20)


def test_kind_words_do_not_say_poi_nor_yes():
    assert kind_words(place("A", shop="yes", office="yes")) == ()
    assert kind_words(place("A", kind="building", amenity="fast_food", building="yes")) == (
        "building", "fast food", "restaurant", "takeaway",
    )  # fmt: skip
