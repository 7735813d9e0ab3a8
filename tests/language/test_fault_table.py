"""Sentences of each kind that used to mislead at full confidence, each with its reading."""

import pytest

from sloop_ppl.language import NOT_ON_MAP, Distance, TargetObject, parse
from sloop_ppl.maps import load_map

ME = (TargetObject("Me"),)


def read(text, name="cleveland", targets=None):
    """Return (figure, relation, grounds) of a text, "not" before the denied ones."""
    return {
        (r.figure, ("not " if r.negated else "") + r.relation, r.grounds)
        for r in parse(text, load_map(name), targets).relations
    }


TABLE = [
    ("There was no sign of the green Toyota at Ivy.", {("GreenToyota", "not at", ("Ivy",))}),
    ("Did anybody leave the red Honda near Rumor?", set()),
    (
        "The red Honda is near Ivy, no wait, near Hanabi.",
        {("RedHonda", "near", ("Hanabi",))},
    ),
    (
        "Last month the red Honda stood at Rumor, now it is in front of Ivy.",
        {("RedHonda", "front", ("Ivy",))},
    ),
    ("The red Honda is catty-corner to Rumor.", {("RedHonda", "across", ("Rumor",))}),
    ("The red bike is down the street from Hanabi.", {("RedBike", "near", ("Hanabi",))}),
    ("Let's meet at Hanabi.", {("Me", "at", ("Hanabi",))}),
    ("A kite crashed near Hoyt Block", {("Kite", "near", ("HoytBlock",))}),
    (
        "The tram is where Johnson Court crosses West 6th Street",
        {("Tram", "at", ("JohnsonCourt", "West6thSt"))},
    ),
    (
        "The red Honda is on the far side of West 6th Street from Rumor",
        {("RedHonda", "across", ("Rumor",))},
    ),
]


@pytest.mark.parametrize(("text", "expected"), TABLE)
def test_readings(text, expected):
    assert read(text) == expected


def test_verbs_are_no_objects():
    assert "Moped" not in {f for f, _, _ in read("My uncle moved it behind Rumor.")}


def test_bounds_are_no_rings():
    for text, bounds in [
        ("The red bike is within 30 m of Ivy", (0, 30)),
        ("The red bike is 10 to 20 metres north of Ivy", (10, 20)),
        ("The red bike is at least 40 m from Ivy", (40, float("inf"))),
    ]:
        (relation,) = parse(text, load_map("cleveland")).relations
        assert isinstance(relation.distance, Distance)
        assert (relation.distance.low_m, relation.distance.high_m) == bounds
        assert relation.distance_m is None


def test_a_kind_is_each_of_its_places():
    (relation,) = parse("The green car is near the alley.", load_map("denver")).relations
    shares = {c.ground: c.probability for c in relation.slot(0)}
    assert len(shares) == 3
    assert None in shares
    assert sum(shares.values()) == pytest.approx(1)


def test_what_is_said_of_a_place_is_turned_round():
    found = read("I am on West 6th Street. A school is west of it.", targets=ME)
    assert ("Me", "on", ("West6thSt",)) in found
    assert ("Me", "east", (NOT_ON_MAP,)) in found
    assert not any(relation == "west" for _, relation, _ in found)


def test_north_of_you_needs_the_hearer():
    city = load_map("cleveland")
    text = "I'm at Rumor, north of you."
    without = parse(text, city)
    assert [r.ground for r in without.relations] == ["Rumor"]
    assert [u.status for u in without.unresolved] == ["other"]
    placed = parse(text, city, hearer=(0.0, -150.0))
    assert ("north", "Hearer") in {(r.relation, r.ground) for r in placed.relations}
