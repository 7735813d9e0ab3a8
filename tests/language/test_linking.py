import pytest

from sloop_ppl.language.linking import link_landmarks
from sloop_ppl.language.name_index import name_index
from sloop_ppl.language.words import split_words
from sloop_ppl.maps import load_map


def linked(text, city):
    index = name_index(load_map(city))
    return [index.landmarks[m.candidates[0]].id for m in link_landmarks(split_words(text), index)]


@pytest.mark.parametrize(
    ("city", "said", "ids"),
    [
        ("cleveland", "the Hat Factory", ["TheHatFactory"]),
        ("cleveland", "hat factry", ["TheHatFactory"]),
        ("cleveland", "VelvetDog", ["VelvetDog"]),
        ("cleveland", "velvetdog", ["VelvetDog"]),
        ("cleveland", "Root Mc-Bride Bldg", ["RootMcBrideBuilding"]),
        ("cleveland", "W. Sixth St.", ["West6thSt"]),
        ("cleveland", "6th", ["West6thSt"]),
        ("cleveland", "West Sixth Place", ["WestSixthPlace"]),
        ("cleveland", "Saint Clair and W 4th", ["WestSaintClairAvenue", "West4thSt"]),
        ("denver", "Logan", ["LoganSt"]),
        ("denver", "Logan Street Apts", ["LoganStreetApartments"]),
        ("denver", "St Anne", ["StAnneApartments"]),
        ("denver", "Oblios tavern", ["Oblio'sCapHillTavern"]),
        ("austin", "Chase Tower", ["ChaseBankTower"]),
        ("austin", "Lavaca", ["LavacaSt"]),
        ("honolulu", "seven eleven", ["SevenEleven"]),
        ("honolulu", "7-Eleven", ["SevenEleven"]),
    ],
)
def test_names_as_people_write_them(city, said, ids):
    assert linked(said, city) == ids


@pytest.mark.parametrize(
    "said",
    ["West 7th Street", "East 6th Street", "South 6th St", "the street", "the building", "north"],
)
def test_digits_and_compass_words_are_never_matched_approximately(said):
    assert linked(said, "austin") == []


def test_the_streets_are_meant_rather_than_the_stop_named_after_them():
    assert linked("Grant Street & 12th Avenue", "denver") == ["GrantSt", "East12thAvenue"]


def test_a_direction_is_no_letter_of_a_name():
    """ "South of Sokos" means the Sokos there is, not the S Market Sokos."""
    from shapely import Point

    from sloop_ppl.language import parse
    from sloop_ppl.maps import CityMap, Grid, Landmark

    city = CityMap(
        "square",
        Grid.square(100),
        (
            Landmark("Sokos", "poi", Point(0, 0), "Sokos"),
            Landmark("SMarketSokos", "poi", Point(50, 0), "S Market Sokos"),
        ),
    )
    (relation,) = parse("the red car is south of Sokos", city).relations
    assert (relation.relation, relation.grounds) == ("south", ("Sokos",))
    (relation,) = parse("the red car is near S Market Sokos", city).relations
    assert relation.grounds == ("SMarketSokos",)
