"""One meaning in many wordings: corners, clocks, crossings, shorthand, small words gone wrong."""

from __future__ import annotations

import pytest
from reading_cases import cases, city, faults

from sloop_ppl.language import parse


@pytest.mark.parametrize(
    "case", cases("constructions"), ids=lambda case: f"{case.kind}: {case.text}"
)
def test_a_construction_is_read_in_every_wording(case):
    assert faults(case) == []


def read(text: str) -> list[tuple[str, str, tuple[str, ...]]]:
    relations = parse(text, city("cleveland")).relations
    return [(r.figure, r.relation, r.grounds) for r in relations]


@pytest.mark.parametrize(
    "text",
    [
        "The red bike is at my ten o'clock.",
        "From Rumor with twelve o'clock pointing east the red bike is at three o'clock.",
    ],
)
def test_an_hour_without_a_place_or_a_north_is_no_direction(text):
    assert read(text) == []


def test_two_streets_that_never_meet_are_no_corner():
    assert read("The red bike is on West 4th Street and West 6th Street.") == [
        ("RedBike", "on", ("West4thSt",)),
        ("RedBike", "on", ("West6thSt",)),
    ]


def test_a_street_and_a_building_are_no_corner():
    assert read("The red bike is near Ivy and West 6th Street.") == [
        ("RedBike", "near", ("Ivy",)),
        ("RedBike", "near", ("West6thSt",)),
    ]


def test_which_way_something_faces_says_nothing_of_where_it_is():
    assert read("The red bike is facing away from Rumor, next to Ivy.") == [
        ("RedBike", "next", ("Ivy",))
    ]


def test_the_other_side_of_a_building_is_no_street_to_cross():
    assert read("The red bike is on the far side of Hoyt Block.") == [
        ("RedBike", "beyond", ("HoytBlock",))
    ]
