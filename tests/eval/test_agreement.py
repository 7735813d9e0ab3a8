"""Two annotations of the same texts: agreement counted by hand, and the gold they make."""

import json
import math

import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.eval._agreement import Agreement, agreement, merged
from sloop_ppl.eval._annotation_files import read_annotations, write_annotations
from sloop_ppl.eval._gold import GoldEntry
from sloop_ppl.language import Distance, StreetPart


def said(relation, ground="Ivy", **more):
    return GoldEntry("Me", relation, ground, **{"ground_class": "named"} | more)


def of_kind(relation, kind, **more):
    return said(relation, None, kind=kind, **{"ground_class": "other"} | more)


def test_agreement_is_counted_by_class_of_ground():
    first = {
        "a": [said("on"), of_kind("east", "schools"), said("near", "Rumor")],
        "b": [said("in")],
    }
    second = {"a": [of_kind("east", "old school"), said("at"), said("north", "Rumor")], "b": []}
    assert agreement(first, second) == {
        "named": Agreement(3, 2, 1),
        "other": Agreement(1, 1, 1),
        "all": Agreement(4, 3, 2),
    }
    found = agreement(first, second)["all"]
    assert (found.f1, found.of_first, found.of_second) == (4 / 7, 0.5, 2 / 3)
    assert Agreement(0, 0, 0).f1 == 1


def test_what_one_calls_optional_is_not_required_by_both():
    first, second = {"a": [said("on"), said("near", "Rumor", optional=True)]}, {"a": [said("on")]}
    second["a"].append(said("near", "Rumor"))
    assert agreement(first, second, required=True)["all"] == Agreement(1, 2, 1)


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        (said("near"), said("near", "Rumor", also=("Ivy",)), True),
        (said("near"), said("near", "Rumor"), False),
        (said("near"), said("near", negated=True), False),
        (of_kind("near", "pitches"), of_kind("near", "football pitch"), True),
        (of_kind("near", "school"), of_kind("near", "park"), False),
        (of_kind("near", "bar"), said("near", "Ivy", kind="bar"), True),
        (of_kind("near", "bar"), said("near", "Ivy"), False),
        (said("near", "Rumor", kind="bar"), said("near", "Ivy", kind="bar"), False),
    ],
)
def test_when_two_entries_are_the_same(one, other, same):
    assert agreement({"a": [one]}, {"a": [other]})["all"].both == same


def test_the_gold_requires_what_both_took():
    gold = merged(
        {"a": [said("on"), said("near", "Rumor"), said("in", "HoytBlock")], "only": [said("on")]},
        {"a": [said("near", "Rumor", optional=True), said("at", also=("Spirits",)), said("north")]},
    )
    assert gold == {
        "a": (
            said("on", also=("Spirits",)),
            said("near", "Rumor", optional=True),
            said("in", "HoytBlock", optional=True),
            said("north", optional=True),
        )
    }


def test_the_same_word_is_paired_before_another_of_its_class():
    (entry, other) = merged({"a": [said("on")]}, {"a": [said("at"), said("on")]})["a"]
    assert (entry.relation, entry.optional) == ("on", False)
    assert (other.relation, other.optional) == ("at", True)


def test_a_place_that_is_on_the_map_for_one_is_right_either_way():
    (entry,) = merged({"a": [said("near", "Ivy", kind="bar")]}, {"a": [of_kind("near", "bar")]})[
        "a"
    ]
    assert (entry.ground, entry.also, entry.kind) == (None, ("Ivy",), "bar")


def test_groups_are_numbered_anew():
    first = [said("between", group=7), said("between", "Rumor", group=7)]
    second = [said("between", "Spirits", group=7), said("between", "HoytBlock", group=7)]
    assert [e.group for e in merged({"a": first}, {"a": second})["a"]] == [0, 0, 1, 1]
    alone = merged({"a": first}, {"a": [*second[:1], said("between", group=7)]})["a"]
    assert [e.group for e in alone] == [0, 0, None]


def test_annotations_are_written_and_read_back(tmp_path):
    entries = (
        said("between", group=0, negated=True, status="denied"),
        of_kind(
            "east", "school", also=("Ivy",), optional=True, distance=Distance(20, float("inf"))
        ),
        said("at", status="alternative", either=(0, 1)),
        said("in", part=StreetPart("corner", math.pi / 4)),
    )
    path = tmp_path / "gold.jsonl"
    write_annotations(path, {"a": entries})
    assert read_annotations(path) == {"a": entries}
    assert json.loads(path.read_text())["relations"][1]["ground"] is None


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("[1]", ":1: field 'line' is a list; expected an object"),
        ("{", ":1: field 'line' is not JSON: "),
        ('{"id": "a", "relations": [{}]}', ":1: field 'relations[0].figure' is missing; expected"),
    ],
)
def test_a_fault_is_one_line(tmp_path, text, fault):
    path = tmp_path / "gold.jsonl"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_annotations(path)
    assert str(caught.value).startswith(f"{path}{fault}")
    with pytest.raises(InputError, match=r"^Annotations '.*none' cannot be read"):
        read_annotations(tmp_path / "none")
