"""Bounds, ranges and idioms of distance are read as metres, however they are put."""

from __future__ import annotations

import math

import pytest
from reading_cases import cases, city, faults

from sloop_ppl.language import Distance, parse
from sloop_ppl.language.distances import JUST_PAST


@pytest.mark.parametrize("case", cases("distance_words"), ids=lambda case: case.text)
def test_a_distance_is_read_with_its_bounds(case):
    assert faults(case) == []


def distance(text: str) -> Distance | None:
    (relation,) = parse(text, city("cleveland")).relations
    return relation.distance


def test_one_number_stays_one_number():
    (relation,) = parse("The red bike is 20 m north of Ivy.", city("cleveland")).relations
    assert relation.distance_m == 20
    assert relation.distance == Distance(20, 20)


def test_exactly_is_less_vague_than_nothing_and_about_more():
    exactly, plain, about = (
        distance(f"The red bike is {lead} 20 m from Ivy.").vagueness
        for lead in ("exactly", "", "about")
    )
    assert exactly < plain < about


def test_just_past_bounds_past():
    assert distance("The red bike is just past Ivy.") == JUST_PAST
    assert distance("The red bike is past Ivy.") is None


def test_what_is_not_less_than_a_bound_has_no_upper_one():
    assert distance("The red bike is not less than 40 m from Ivy.").high_m == math.inf
    assert distance("The red bike is not more than 40 m from Ivy.").high_m == 40


@pytest.mark.parametrize(
    "text",
    [
        "The red bike was at Ivy five minutes ago.",
        "The red bike is in a block of flats next to Rumor.",
        "The red bike is over by Rumor.",
        "The red bike is at Rumor, under a tree.",
        "The red bike is 2 doors down at Rumor.",
    ],
)
def test_no_distance_is_read_where_none_is_said(text):
    assert all(r.distance is None for r in parse(text, city("cleveland")).relations)


def test_a_denied_bound_is_still_a_bound():
    (relation,) = parse("The red bike is not within 50 m of Ivy.", city("cleveland")).relations
    assert relation.negated
    assert relation.distance == Distance(0, 50)


def test_how_far_over_from_nowhere_says_nothing():
    assert not parse("It's one block over.", city("cleveland")).relations
