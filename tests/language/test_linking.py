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


def named(*names):
    """A map of landmarks with these names, in this order."""
    from shapely import Point

    from sloop_ppl.maps import CityMap, Grid, Landmark

    landmarks = (
        Landmark(name.replace(" ", ""), "poi", Point(10 * i - 90, 0), name)
        for i, name in enumerate(names)
    )
    return CityMap("named", Grid.square(100), tuple(landmarks))


def mentions(text, city):
    index = name_index(city)
    return [
        (
            [index.landmarks[n].name for n in mention.candidates],
            [index.landmarks[n].name for n in mention.rivals],
        )
        for mention in link_landmarks(split_words(text), index)
    ]


def test_the_name_that_was_said_in_full_is_meant_and_the_longer_one_is_its_rival():
    city = named("Zorba Kebab Palace", "Zorba Kebab", "Quiet Corner")
    assert mentions("zorba kebab", city) == [(["Zorba Kebab"], ["Zorba Kebab Palace"])]
    assert mentions("zorba kebab palace", city) == [(["Zorba Kebab Palace"], ["Zorba Kebab"])]


def test_landmarks_that_fit_equally_well_keep_the_order_of_the_map():
    city = named("Zorba Quince", "Zorba Walnut", "Quiet Corner")
    assert mentions("zorba", city) == [(["Zorba Quince", "Zorba Walnut"], [])]
    # A word of the second one, said before, does not put it first.
    assert mentions("walnut , then zorba", city)[-1] == (["Zorba Quince", "Zorba Walnut"], [])


def test_the_score_is_the_share_of_the_name_that_was_said():
    index = name_index(named("Zorba Quince", "Fig Walnut", "Quiet Corner"))
    scores = {}
    for text in ("zorba quince", "zorba", "zorbo quince"):
        (mention,) = link_landmarks(split_words(text), index)
        scores[text] = mention.score
    assert scores["zorba quince"] == 1.0
    assert scores["zorba"] == pytest.approx(0.5)  # both words are as rare
    assert 0.5 < scores["zorbo quince"] < 1.0


def test_what_may_stand_within_a_name():
    city = named("Zorba Quince", "Quiet Corner")

    def ranges(text):
        found = link_landmarks(split_words(text), name_index(city))
        return [(mention.first, mention.last) for mention in found]

    for whole in ("zorba - quince", "zorba . quince", "zorba the quince", "zorba old quince"):
        assert ranges(whole) == [(0, 3)], whole
    for torn in ("zorba , quince", "zorba ; quince", "zorba 7 quince", "zorba behind quince"):
        assert ranges(torn) == [(0, 1), (2, 3)], torn
    # Each word that is left out costs, and far apart they are two.
    assert ranges("zorba fine old brick quince") == [(0, 1), (4, 5)]


def test_a_word_that_was_torn_in_two_is_all_named():
    index = name_index(named("Zorbaquince", "Quiet Corner"))
    for text, end in (("zorba quince", 2), ("zorba - quince", 3)):
        (mention,) = link_landmarks(split_words(text), index)
        assert (mention.first, mention.last, mention.score) == (0, end, 1.0)


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("Church Street", "church"),
        ("Hotel Building", "building"),
        ("Zorba Quince Dog", "dog"),
        ("Zorba Quince House", "house"),
    ],
)
def test_words_that_many_places_share_name_none_of_them_alone(name, part):
    city = named(name, "Quiet Corner")
    assert mentions(name.lower(), city) == [([name], [])]
    assert mentions(part, city) == []


def test_two_common_words_are_not_enough_of_a_long_name():
    city = named("Dog Water Zorba Quince Fig Walnut", "Quiet Corner")
    assert mentions("dog water", city) == []
    assert mentions("dog water zorba quince", city) == [([city.landmarks[0].name], [])]


def test_a_word_that_was_torn_in_two_is_part_of_a_longer_name():
    index = name_index(named("Zorbaquince Parlour", "Quiet Corner"))
    (mention,) = link_landmarks(split_words("zorba - quince parlour"), index)
    assert (mention.first, mention.last, mention.score) == (0, 4, 1.0)


def test_a_direction_at_the_end_is_no_name():
    city = named("South", "Quiet Corner")
    assert mentions("south", city) == [(["South"], [])]
    assert mentions("south of", city) == []


def test_a_rival_is_listed_once():
    city = named("Zorba Quince", "Quince Zorba Parlour", "Quiet Corner")
    assert mentions("zorba quince", city) == [(["Zorba Quince"], ["Quince Zorba Parlour"])]


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
