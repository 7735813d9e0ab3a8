"""Whom and what a text speaks of, when nobody declared it."""

import pytest

from sloop_ppl.language import TargetObject, parse
from sloop_ppl.maps import load_map

CITY = load_map("cleveland")


def figures(text):
    return {r.figure for r in parse(text, CITY).relations}


OBJECTS = [
    ("The food truck is behind Rumor.", "FoodTruck"),
    ("A white delivery van is parked near Ivy.", "WhiteDeliveryVan"),
    ("Sarah is at Rumor.", "Sarah"),
    ("grandma is behind Ivy", "Grandma"),
    ("My friend Anna is waiting at Rumor.", "Anna"),
    ("We lost our puppy near Hoyt Block.", "Puppy"),
    ("I left my umbrella at Rumor.", "MyUmbrella"),
    ("There's a big blue tent behind Ivy.", "BlueTent"),
    ("The suspect's motorbike is near Rumor.", "Motorbike"),
    ("The drone crashed near Hoyt Block.", "Drone"),
    ("Ice cream van: behind Rumor", "IceCreamVan"),
    ("my cousin Pete's at ivy", "Pete"),
    ("I saw a stray dog with a collar behind Rumor.", "StrayDog"),
    ("A pizza courier got stuck near Ivy.", "PizzaCourier"),
    ("Somebody spotted the missing girl behind Rumor.", "Girl"),
    ("The cat of my neighbour is behind Ivy.", "Cat"),
    ("Mr. Brown is at Rumor.", "MrBrown"),
    ("The school bus is behind Rumor.", "SchoolBus"),
]


@pytest.mark.parametrize(("text", "expected"), OBJECTS)
def test_undeclared_objects(text, expected):
    assert figures(text) == {expected}


SPEAKERS = [
    "I'm at Rumor.",
    "We are standing behind Ivy.",
    "meet me at rumor",
    "Let's meet at Ivy.",
    "im waiting outside Rumor",
    "Come and pick me up at Ivy.",
    "I will be near Hoyt Block.",
    "We parked behind Rumor.",
    "My location is behind Ivy.",
    "You can find us inside Rumor.",
    "we're stuck right in front of Rumor",
    "I am currently sitting next to Ivy.",
    "Come to Rumor.",
    "See you by Rumor.",
    "Meet at Ivy.",
    "Let's eat at Ivy.",
    "Meet up with me at Rumor.",
    "I have pulled over near Rumor.",
    "Let's all get together at Ivy.",
]


@pytest.mark.parametrize("text", SPEAKERS)
@pytest.mark.parametrize("declared", [None, (TargetObject("Me"),)])
def test_first_person_is_me(text, declared):
    found = parse(text, CITY, declared)
    assert {r.figure for r in found.relations} == {"Me"}
    assert [t.id for t in found.targets] == ["Me"]


NOT_THE_SPEAKER = [
    ("I think the red bike is at Rumor.", "RedBike"),
    ("I saw the red bike behind Ivy.", "RedBike"),
    ("We left the red bike near Rumor.", "RedBike"),
    ("I'm looking for the red bike, it is behind Ivy.", "RedBike"),
    ("I am an old woman and my dog is at Rumor.", "MyDog"),
]


@pytest.mark.parametrize(("text", "expected"), NOT_THE_SPEAKER)
def test_who_tells_is_not_what_is_told(text, expected):
    assert figures(text) == {expected}


NO_OBJECTS = [
    "My cousin moved it behind Hoyt Block.",
    "The weather near Rumor is nice.",
    "Please hurry to Rumor.",
    "The morning was cold near Ivy.",
]


@pytest.mark.parametrize("text", NO_OBJECTS)
def test_verbs_and_abstract_nouns_are_no_objects(text):
    named = {t.id for t in parse(text, CITY).targets}
    assert not named & {"Moped", "Moved", "Weather", "Hurry", "Morning", "Crashed"}


def test_a_red_car_alone_is_any_red_car():
    assert figures("The red car is behind Rumor.") == {"RedCar"}
    assert figures("The red car is behind Rumor, the green Toyota near Ivy.") == {
        "RedHonda",
        "GreenToyota",
    }
    declared = (TargetObject("RedHonda", ("red honda", "red car"), "red", "car"),)
    found = parse("The red car is behind Rumor.", CITY, declared)
    assert {r.figure for r in found.relations} == {"RedHonda"}


def test_a_target_is_a_ground():
    found = parse("The red bike is next to the green Toyota. The Toyota is behind Ivy.", CITY)
    assert [(r.figure, r.relation, r.ground) for r in found.relations] == [
        ("RedBike", "next", "GreenToyota"),
        ("GreenToyota", "behind", "Ivy"),
    ]


def test_the_converse_is_turned():
    for text, relation in [
        ("I'm on West 6th Street. Rumor is north of me.", "south"),
        ("I am on West 6th Street. To my east is Rumor.", "west"),
        ("I'm on West 6th Street. Rumor is north of where I am.", "south"),
        ("We are on West 6th Street; you'll see Rumor to the south.", "north"),
    ]:
        found = {(r.relation, r.ground) for r in parse(text, CITY).relations}
        assert (relation, "Rumor") in found, text
