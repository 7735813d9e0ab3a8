""" "Not near a bank" denies every bank; what is asserted of a bank is left open as before."""

from __future__ import annotations

import pytest

import sloop_ppl as sloop

CITY = sloop.load_map("cleveland")
RESTAURANTS = {"Hanabi", "KarlsInnoftheBarristers", "BluePointe"}


def denied(text):
    return [
        (r.relation, set(r.grounds))
        for r in sloop.parse(text, CITY).relations
        if r.negated and r.each
    ]


@pytest.mark.parametrize(
    "text",
    [
        "The red bike is not near a restaurant.",
        "The red bike isn't near any restaurant.",
        "The red bike is near Ivy and not near a restaurant.",
        "The red bike is on West 6th Street, but not near any restaurants.",
    ],
)
def test_every_landmark_of_the_kind_is_denied(text):
    assert denied(text) == [("near", RESTAURANTS)]
    assert not sloop.parse(text, CITY).unresolved


def test_kinds_are_denied_one_by_one():
    text = "The red bike is not in a parking lot or near a restaurant."
    (lots, _), restaurants = denied(text)[0], denied(text)[1]
    assert lots == "in"
    assert restaurants == ("near", RESTAURANTS)


@pytest.mark.parametrize(
    "text",
    [
        "The red bike is near a restaurant.",
        "The red bike is not near the restaurant.",
        "The red bike is not near Ivy.",
        "The red bike is not near a restaurant on West 6th Street.",
        "The red bike is not near a restaurant that has a patio.",
        "The red bike is not near another restaurant.",
        "The red bike is not near some restaurant.",
        "The red bike is not near a restaurant, Hanabi.",
        "The red bike is not between Ivy and a restaurant.",
    ],
)
def test_what_is_said_of_one_is_not_said_of_all(text):
    assert denied(text) == []


def test_it_is_one_relation_in_the_file_and_in_words():
    from sloop_ppl.bridge.relation_text import relations_in_words

    description = sloop.parse("The red bike is not near a restaurant.", CITY)
    entries = description.to_json()["relations"]
    assert {entry["ground"] for entry in entries} == RESTAURANTS
    assert {entry["group"] for entry in entries} == {0}
    (words,) = relations_in_words(sloop.infer(description, CITY), "RedBike")
    assert words.startswith("not near ")
    assert " or " in words
