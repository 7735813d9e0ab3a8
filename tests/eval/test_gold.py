"""Gold with alternatives: what a line may hold, and what of it reaches a model."""

import json
import math

import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.eval import read_descriptions
from sloop_ppl.language import Distance, StreetPart, TargetObject

PLACE = {"east_m": 2.5, "north_m": 2.5}


def entry(relation, ground="Ivy", **more):
    return {"figure": "RedBike", "relation": relation, "ground": ground} | more


@pytest.fixture
def read(tmp_path):
    def write_and_read(*entries, **line):
        path = tmp_path / "said.jsonl"
        whole = {"id": "a", "map": "cleveland", "text": "some text"} | line
        if entries:
            whole["relations"] = list(entries)
        path.write_text(json.dumps(whole), encoding="utf-8")
        return read_descriptions(path)[0]

    return write_and_read


def test_a_line_without_relations_has_no_gold(read):
    assert not read().has_gold
    assert not read(relations=None).has_gold
    assert read(relations=[]).has_gold
    assert read(entry("near")).has_gold


def test_what_is_asserted_or_denied_reaches_a_model(read):
    annotated = read(
        entry("near", also=["Rumor"], optional=True),
        entry("at", "Rumor", status="asked"),
        entry("behind", "Rumor", status="past"),
        entry("in", "HoytBlock", status="denied"),
        entry("north", None, kind="school", also=["Spirits"]),
    )
    assert [(r.relation, r.grounds, r.negated) for r in annotated.relations] == [
        ("near", ("Ivy",), False),
        ("in", ("HoytBlock",), True),
    ]
    accepted = [{c.ground for c in slot} for r in annotated.relations for slot in r.candidates]
    assert accepted == [{"Ivy", "Rumor"}]
    near, asked, _, denied, school = annotated.gold
    assert near.accepted == {"Ivy", "Rumor"}
    assert near.optional
    assert not asked.is_read
    assert (denied.status, denied.negated) == ("denied", True)
    assert school.accepted == {"Spirits"}


def test_a_relation_with_a_ground_that_has_no_id_reaches_no_model(read):
    annotated = read(
        entry("between", "Ivy", group=0), entry("between", None, kind="kiosk", group=0)
    )
    assert annotated.relations == ()
    assert len(annotated.gold) == 2


def test_alternatives_are_branches_of_one_group(read):
    said = read(
        entry("at", status="alternative"),
        entry("near", "Rumor", status="alternative"),
        {"figure": "GreenToyota", "relation": "at", "ground": "Ivy", "status": "alternative"},
        entry("behind", either=[3, 1]),
        entry("on", "West6thSt"),
    ).relations
    assert [relation.either for relation in said] == [(-1, 0), (-1, 1), (-2, 0), (3, 1), None]


def test_said_distances_are_kept(read):
    said = read(
        entry("north", distance_m=50),
        entry("near", distance_m=[0, 30]),
        entry("south", distance_m=[20, None]),
    ).relations
    assert [relation.distance for relation in said] == [
        Distance(50, 50),
        Distance(0, 30),
        Distance(20, math.inf),
    ]


def test_objects_of_a_line_are_declared_with_or_without_places(read):
    van = {"id": "Van", "names": ["white van", "delivery van"], "colour": "white", "kind": "van"}
    annotated = read(targets={"RedBike": PLACE, "Van": PLACE}, objects=[van, {"id": "MyDog"}])
    assert [target.id for target in annotated.objects] == ["RedBike", "Van", "MyDog"]
    assert annotated.objects[1] == TargetObject(
        "Van", ("white van", "delivery van"), "white", "van"
    )
    assert "red bicycle" in annotated.objects[0].names
    assert annotated.objects[2].names == ("my dog", "dog")
    said = read(
        {"figure": "Van", "relation": "near", "ground": "MyDog"}, objects=[van, {"id": "MyDog"}]
    )
    assert said.relations[0].grounds == ("MyDog",)


def test_speaker_and_hearer_are_known_without_declaration(read):
    said = read(
        {"figure": "Me", "relation": "north", "ground": "Hearer"},
        targets={"RedBike": PLACE},
        hearer={"east_m": 1200, "north_m": -300},
        area_m=[-50, -50, 50, 60],
        phenomena=["meeting"],
    )
    assert said.relations[0].grounds == ("Hearer",)
    assert said.hearer == (1200, -300)
    assert said.area_m == (-50, -50, 50, 60)
    assert said.phenomena == ("meeting",)


def test_words_are_meant_from_the_viewpoint_in_all_of_the_gold(read):
    annotated = read(entry("up", "West6thSt"), viewpoint="ground")
    assert annotated.gold[0].relation == annotated.relations[0].relation != "up"


@pytest.mark.parametrize(
    ("entry_", "line", "fault"),
    [
        (
            entry("near", None),
            {},
            "relations[0].ground' is missing; expected an id, or a 'kind' of place that has none",
        ),
        (
            entry("near", status="maybe"),
            {},
            (
                "relations[0].status' is 'maybe'; expected asserted, denied, alternative, asked, "
                "retracted, past, route, other or unknown"
            ),
        ),
        (
            entry("near", status="asserted", negated=True),
            {},
            "relations[0].status' is 'asserted' of what is negated; expected 'denied'",
        ),
        (
            entry("near", status="past", either=[0, 0]),
            {},
            "relations[0].status' is 'past' of one of several; expected 'alternative'",
        ),
        (
            entry("near", either=[0]),
            {},
            "relations[0].either' is [0]; expected two numbers: the group and its branch",
        ),
        (entry("near", also="Rumor"), {}, "relations[0].also' is a str; expected a list of texts"),
        (entry("near", also=["Rumor", 3]), {}, "relations[0].also[1]' is 3; expected a text"),
        (
            entry("near", distance_m="far"),
            {},
            (
                "relations[0].distance_m' is 'far'; expected a number of metres, or the lower and "
                "the upper bound"
            ),
        ),
        (
            entry("near", **{"class": "school"}),
            {},
            "relations[0].class' is 'school'; expected named, own_kind, hearer or other",
        ),
        (entry("near"), {"phenomena": "x"}, "phenomena' is a str; expected a list of texts"),
        (entry("near"), {"objects": [{}]}, "objects[0].id' is missing; expected a text"),
        (
            entry("near"),
            {"objects": [{"id": "RedBike"}, {"id": "RedBike"}]},
            "objects[1].id' repeats 'RedBike'; expected each object once",
        ),
        (entry("near"), {"hearer": [1, 2]}, "hearer' is a list; expected an object"),
        (
            entry("near"),
            {"hearer": {"east_m": 1}},
            "hearer.north_m' is missing; expected a finite number, or 'lonlat' alone",
        ),
        (
            entry("near"),
            {"area_m": [5, 0, -5, 9]},
            "area_m' is [5.0, 0.0, -5.0, 9.0]; expected west < east and south < north, metres",
        ),
        (
            entry("near"),
            {"area_m": [5, 0, "x", 9]},
            "area_m' is [5, 0, 'x', 9]; expected four numbers: west, south, east, north",
        ),
    ],
)
def test_a_fault_says_what_was_found_and_expected(read, tmp_path, entry_, line, fault):
    with pytest.raises(InputError) as caught:
        read(entry_, **line)
    assert str(caught.value) == f"{tmp_path / 'said.jsonl'}:1: field '{fault}"


def test_an_entry_may_name_a_part_of_its_ground(read):
    side = {"kind": "side", "bearing_deg": 90}
    corner = {"kind": "corner", "bearing_deg": -135}
    annotated = read(
        entry("on", "JohnsonCourt", part=side),
        entry("at", "JohnsonCourt", group=1, part=corner),
        entry("at", "West6thSt", group=1),
        entry("near", "WestLakesideAvenue", part={"kind": "number", "number": 12}),
        entry("near"),
    )
    south_west = StreetPart("corner", math.radians(-135))
    assert [(r.grounds, r.part) for r in annotated.relations] == [
        (("JohnsonCourt",), StreetPart("side", math.pi / 2)),
        (("JohnsonCourt", "West6thSt"), south_west),
        (("WestLakesideAvenue",), StreetPart("number", number=12)),
        (("Ivy",), None),
    ]
    assert annotated.gold[1].part == south_west


@pytest.mark.parametrize(
    ("part", "message"),
    [
        ({"kind": "middle"}, r"relations\[0\]\.part' cannot be: Part 'middle' of a street is none"),
        (
            {"kind": "number"},
            r"relations\[0\]\.part' cannot be: The number of part 'number' is None",
        ),
        ({"bearing_deg": 90}, r"relations\[0\]\.part"),
        ({"kind": "side", "bearing_deg": "north"}, r"relations\[0\]\.part\.bearing_deg"),
        ("side", r"relations\[0\]\.part"),
    ],
)
def test_a_part_that_cannot_be_is_refused(read, part, message):
    with pytest.raises(InputError, match=message):
        read(entry("on", "JohnsonCourt", part=part))


def test_a_group_has_one_part(read):
    corner, end = {"kind": "corner"}, {"kind": "end"}
    with pytest.raises(InputError, match=r"relations\[1\]\.part' is not that of 'RedBike at'"):
        read(
            entry("at", "JohnsonCourt", group=1, part=corner),
            entry("at", "West6thSt", group=1, part=end),
        )
