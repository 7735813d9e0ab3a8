"""What is asked, denied, taken back, held before or an alternative is not taken for asserted."""

import pytest

from sloop_ppl.language import parse
from sloop_ppl.maps import load_map

CITY = load_map("cleveland")


def said(text):
    """Return (figure, relation, ground) of what is asserted, "not" before the denied ones."""
    return {
        (("not " if r.negated else "") + r.relation, r.figure, ground)
        for r in parse(text, CITY).relations
        for ground in r.grounds
    }


def statuses(text):
    return [u.status for u in parse(text, CITY).unresolved]


QUESTIONS = [
    "Is the red bike at Ivy?",
    "Was the red bike near Rumor?",
    "Did you see the red bike behind Hoyt Block?",
    "has anyone seen the red bike near rumor",
    "Hey, is the red bike still behind Ivy?",
    "Do you know if the red bike is at Rumor?",
    "I was wondering whether the red bike is at Ivy.",
    "Which bike is at Ivy, the red bike?",
    "Behind Hoyt Block?",
    "Could the red bike be inside Rumor?",
]


@pytest.mark.parametrize("text", QUESTIONS)
def test_questions_assert_nothing(text):
    assert said(text) == set()
    assert set(statuses(text)) <= {"asked", "unknown"}


REQUESTS = [
    ("Can you check behind Rumor for the red bike?", {("behind", "RedBike", "Rumor")}),
    ("Could you meet me at Ivy?", {("at", "Me", "Ivy")}),
    ("Let's meet outside Rumor?", {("outside", "Me", "Rumor")}),
    ("The red bike is behind Ivy, isn't it?", {("behind", "RedBike", "Ivy")}),
    ("I think the red bike is near Ivy, right?", {("near", "RedBike", "Ivy")}),
]


@pytest.mark.parametrize(("text", "expected"), REQUESTS)
def test_requests_and_tags_assert(text, expected):
    assert said(text) == expected


DENIED = [
    ("No sign of the red bike at Rumor.", "at", "Rumor"),
    ("There's no trace of the red bike near Ivy.", "near", "Ivy"),
    ("Nobody has seen the red bike behind Hoyt Block.", "behind", "HoytBlock"),
    ("We couldn't find the red bike inside Rumor.", "inside", "Rumor"),
    ("I haven't seen the red bike near Ivy", "near", "Ivy"),
    ("I looked near Rumor but no luck, no red bike.", "near", "Rumor"),
    ("There is no red bike behind Ivy.", "behind", "Ivy"),
    ("Don't bother to look for the red bike behind Rumor.", "behind", "Rumor"),
    ("The red bike isn't anywhere near Ivy.", "near", "Ivy"),
    ("The red bike is never at Rumor.", "at", "Rumor"),
]


@pytest.mark.parametrize(("text", "relation", "ground"), DENIED)
def test_absence_is_denied(text, relation, ground):
    assert ("not " + relation, "RedBike", ground) in said(text)
    assert not any(word == relation for word, _, _ in said(text))


CORRECTED = [
    "The red bike is at Ivy, no wait, at Rumor.",
    "The red bike is at Ivy, I mean at Rumor.",
    "The red bike is at Ivy, sorry, Rumor.",
    "the red bike is at Ivy scratch that it's at Rumor",
    "The red bike is at Ivy. Correction: at Rumor.",
    "The red bike is at Ivy - no, wait - Rumor.",
    "The red bike is at Ivy, er, at Rumor",
    "The red bike is at Ivy. Oops, my mistake, it is at Rumor.",
    "The red bike is at Ivy, or rather at Rumor.",
    "The red bike is at Ivy, make that Rumor.",
]


@pytest.mark.parametrize("text", CORRECTED)
def test_what_was_taken_back_is_not_asserted(text):
    assert said(text) == {("at", "RedBike", "Rumor")}
    assert "retracted" in statuses(text)


def test_only_what_is_replaced_is_taken_back():
    text = "The red bike is near Hoyt Block and behind Ivy, no wait, behind Rumor."
    assert said(text) == {("near", "RedBike", "HoytBlock"), ("behind", "RedBike", "Rumor")}


PAST = [
    "Last week the red bike was at Ivy, now it is behind Rumor.",
    "The red bike used to be at Ivy. It is behind Rumor now.",
    "Yesterday the red bike was at Ivy but today it is behind Rumor.",
    "The red bike was at Ivy earlier, it's now behind Rumor",
    "This morning the red bike was at Ivy; now it's behind Rumor.",
    "Until noon the red bike was at Ivy, since then it is behind Rumor.",
    "Formerly the red bike stood at Ivy. These days it stands behind Rumor.",
    "The red bike had been at Ivy, and now it's behind Rumor.",
]


@pytest.mark.parametrize("text", PAST)
def test_where_it_was_before_is_set_aside(text):
    assert said(text) == {("behind", "RedBike", "Rumor")}
    assert "past" in statuses(text)


PRESENT = [
    ("I parked the red bike behind Rumor yesterday.", ("behind", "RedBike", "Rumor")),
    ("The red bike was near Ivy when I left.", ("near", "RedBike", "Ivy")),
    ("This morning I locked the red bike outside Rumor.", ("outside", "RedBike", "Rumor")),
]


@pytest.mark.parametrize(("text", "expected"), PRESENT)
def test_the_past_tense_alone_is_no_past(text, expected):
    assert expected in said(text)


ALTERNATIVES = [
    "The red bike is at Ivy or behind Rumor.",
    "The red bike is either at Ivy or behind Rumor.",
    "Maybe the red bike is at Ivy, maybe it's behind Rumor.",
    "Either at Ivy or behind Rumor you will find the red bike.",
    "The red bike could be at Ivy, or it could be behind Rumor.",
    "The red bike might be at Ivy, it might be behind Rumor",
]


@pytest.mark.parametrize("text", ALTERNATIVES)
def test_alternatives_are_branches_of_one_group(text):
    found = parse(text, CITY).relations
    assert {(r.relation, r.ground) for r in found} == {("at", "Ivy"), ("behind", "Rumor")}
    assert [r.either for r in found] == [(0, 0), (0, 1)]


def test_one_cue_with_alternative_grounds():
    found = parse("The red bike is near Ivy or Rumor.", CITY).relations
    assert {(r.ground, r.either) for r in found} == {("Ivy", (0, 0)), ("Rumor", (0, 1))}


def test_neither_of_two_is_no_alternative():
    found = parse("The red bike is not near Ivy or Rumor.", CITY).relations
    assert all(r.negated and r.either is None for r in found)
    assert {r.ground for r in found} == {"Ivy", "Rumor"}


def test_where_someone_has_looked_is_not_where_it_is():
    assert said("The red bike is gone. We have only searched near Ivy so far.") == set()
