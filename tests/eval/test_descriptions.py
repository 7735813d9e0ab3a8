"""Reading description files: what comes out, and the one message for all that is wrong."""

import json
from pathlib import Path

import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.eval import FrameAnnotation, bundled_examples, read_descriptions
from sloop_ppl.language import SpatialRelation
from sloop_ppl.language.targets import DEFAULT_TARGETS
from sloop_ppl.maps import load_map

SHARED = Path(__file__).parents[3] / "shared" / "data" / "descriptions"

PLACE = {
    "east_m": -37.5,
    "north_m": -72.5,
    "lonlat": [-81.6995143, 41.4998068],
    "col_from_west": 12,
    "row_from_north": 34,
}


def line(**changes):
    """Return a good line with some fields changed; a field set to None is left out."""
    whole = {
        "id": "a",
        "map": "cleveland",
        "configuration": "c",
        "text": "The green Toyota is behind Velvet Dog.",
        "targets": {"GreenToyota": PLACE},
        "relations": [{"figure": "GreenToyota", "relation": "behind", "ground": "VelvetDog"}],
    } | changes
    return json.dumps({k: v for k, v in whole.items() if v is not None})


def entry(relation, ground, **more):
    return {"figure": "GreenToyota", "relation": relation, "ground": ground} | more


@pytest.fixture
def read(tmp_path):
    def write_and_read(*lines, **options):
        path = tmp_path / "said.jsonl"
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return read_descriptions(path, **options)

    return write_and_read


def test_a_line_becomes_a_scene(read):
    (annotated,) = read(line(speaker="s1"))
    assert (annotated.id, annotated.map, annotated.configuration, annotated.speaker) == (
        "a",
        "cleveland",
        "c",
        "s1",
    )
    place = annotated.targets["GreenToyota"]
    assert (place.x_m, place.y_m, place.cell) == (-37.5, -72.5, (6, 12))
    assert annotated.relations == (SpatialRelation("GreenToyota", "behind", ("VelvetDog",)),)
    assert annotated.about("GreenToyota") == annotated.relations
    assert annotated.about("RedBike") == ()


def test_configuration_is_the_id_where_absent(read):
    (annotated,) = read(line(configuration=None))
    assert annotated.configuration == "a"
    assert annotated.speaker is None


def test_the_keys_of_targets_are_the_declared_objects(read):
    place = PLACE
    (annotated,) = read(line(targets={"GreenToyota": place, "MyDog": place, "RedBike": place}))
    toyota, dog, bike = annotated.objects
    assert (toyota.colour, toyota.kind) == ("green", "car")
    assert toyota.names[:2] == ("green toyota", "toyota")
    assert "car" not in toyota.names  # another car may be spoken of: colour decides
    assert (dog.colour, dog.kind, dog.names) == (None, "dog", ("my dog", "dog"))
    assert "red bicycle" in bike.names


def test_objects_of_the_published_data_are_the_default_ones(read):
    names = [t.id for t in DEFAULT_TARGETS]
    (annotated,) = read(line(targets=dict.fromkeys(names, PLACE)))
    assert annotated.objects == DEFAULT_TARGETS


def test_a_line_without_targets_declares_none(read):
    (annotated,) = read(line(targets=None))
    assert annotated.objects == ()
    assert len(annotated.relations) == 1


def test_entries_of_a_group_are_one_relation_where_the_first_stood(read):
    (annotated,) = read(
        line(
            relations=[
                entry("at", "West6thSt", group=0),
                entry("near", "HoytBlock"),
                entry("at", "WestSaintClairAvenue", group=0),
                entry("between", "HoytBlock", group="b", negated=True),
                entry("between", "BarleyHouse", group="b", negated=True),
            ]
        )
    )
    assert [(r.relation, r.grounds, r.negated) for r in annotated.relations] == [
        ("at", ("West6thSt", "WestSaintClairAvenue"), False),
        ("near", ("HoytBlock",), False),
        ("between", ("HoytBlock", "BarleyHouse"), True),
    ]


def test_between_without_a_group_is_one_relation_for_each_figure(read):
    (annotated,) = read(
        line(
            targets={"GreenToyota": PLACE, "RedBike": PLACE},
            relations=[
                entry("between", "HoytBlock"),
                entry("between", "BarleyHouse"),
                entry("on", "West6thSt"),
                entry("on", "WestSaintClairAvenue"),
                {"figure": "RedBike", "relation": "between", "ground": "Rumor"},
                {"figure": "RedBike", "relation": "between", "ground": "Spirits"},
            ],
        )
    )
    assert [r.grounds for r in annotated.relations] == [
        ("HoytBlock", "BarleyHouse"),
        ("West6thSt",),
        ("WestSaintClairAvenue",),
        ("Rumor", "Spirits"),
    ]


def test_frames_are_kept(read):
    frame = {"ground": "VelvetDog", "relation": "front", "front_deg": 33.5, "annotator": "x"}
    (annotated,) = read(line(frames=[frame]))
    assert annotated.frames == (FrameAnnotation("VelvetDog", "front", 33.5, "x"),)


def test_several_files_keep_their_order_and_blank_lines_are_passed_over(tmp_path):
    for name in ("b", "a"):
        (tmp_path / f"{name}.jsonl").write_text(f"\n{line(id=name)}\n\n", encoding="utf-8")
    descriptions = read_descriptions([tmp_path / "b.jsonl", tmp_path / "a.jsonl"])
    assert [s.id for s in descriptions] == ["b", "a"]


def test_cells_are_those_of_the_map_that_is_found(read):
    (annotated,) = read(line(), find_map=lambda name: load_map(name, cell_m=2.5))
    # The file counts on 5 m cells whatever the map's own are.
    assert annotated.targets["GreenToyota"].cell == load_map("cleveland", 2.5).grid.cell_at(
        -37.5, -72.5
    )


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"id": None}, "field 'id' is missing; expected a text"),
        ({"id": 7}, "field 'id' is 7; expected a text"),
        ({"text": "  "}, "field 'text' is '  '; expected a text"),
        ({"map": None}, "field 'map' is missing; expected a text"),
        ({"relations": {}}, "field 'relations' is a dict; expected a list"),
        ({"relations": ["on"]}, "field 'relations[0]' is a str; expected an object"),
        ({"targets": []}, "field 'targets' is a list; expected an object"),
        (
            {"targets": {"RedBike": {"east_m": 1.0}}, "relations": []},
            (
                "field 'targets.RedBike.north_m' is missing; expected a finite number, or 'lonlat' "
                "alone"
            ),
        ),
        (
            {"targets": {"RedBike": {"east_m": float("nan"), "north_m": 0}}, "relations": []},
            "field 'targets.RedBike.east_m' is nan; expected a finite number",
        ),
        (
            {"targets": {"RedBike": {"east_m": True, "north_m": 0}}, "relations": []},
            "field 'targets.RedBike.east_m' is True; expected a finite number",
        ),
        (
            {"targets": {"RedBike": {"east_m": 101, "north_m": 0}}, "relations": []},
            (
                "field 'targets.RedBike' is not on the map: Place (101, 0) is outside the map; "
                "expected x in [-100, 100] and y in [-100, 100] metres from the map's centre"
            ),
        ),
        (
            {"targets": {"RedBike": PLACE | {"col_from_west": 13}}, "relations": []},
            (
                "field 'targets.RedBike.col_from_west' is 13; expected 12, the 5 m cell at "
                "(-37.5, -72.5)"
            ),
        ),
        (
            {
                "targets": {"RedBike": PLACE | {"lonlat": [-81.6990647, 41.5004581]}},
                "relations": [],
            },
            (
                "field 'targets.RedBike.lonlat' is (0.0, 0.0) m on this map; expected the place "
                "that 'east_m' and 'north_m' give, (-37.5, -72.5)"
            ),
        ),
        (
            {"targets": {"RedBike": PLACE | {"lonlat": [-81.6990647]}}, "relations": []},
            "field 'targets.RedBike.lonlat' is [-81.6990647]; expected two numbers",
        ),
        (
            {"relations": [entry("at", "HoytBlock") | {"figure": "RedBike"}]},
            "field 'relations[0].figure' is 'RedBike'; expected one of GreenToyota",
        ),
        (
            {"relations": [entry("at", "HoytBlock", negated="no")]},
            "field 'relations[0].negated' is 'no'; expected true or false",
        ),
        (
            {"relations": [entry("at", "HoytBlock", group=1.5)]},
            "field 'relations[0].group' is 1.5; expected a number or a text",
        ),
        (
            {
                "relations": [
                    entry("at", "HoytBlock", group=1),
                    entry("on", "West6thSt", group=1),
                ]
            },
            (
                "field 'relations[1].group' is 1, which holds 'GreenToyota at'; expected the same "
                "figure, relation and negation throughout a group"
            ),
        ),
    ],
)
def test_a_fault_names_file_line_field_and_what_was_expected(read, tmp_path, changes, fault):
    with pytest.raises(InputError) as caught:
        read(line(**changes))
    assert str(caught.value) == f"{tmp_path / 'said.jsonl'}:1: {fault}"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"map": "clevland"}, ["field 'map'", "'clevland'", "did you mean 'cleveland'?"]),
        (
            {"relations": [entry("at", "HoytBlok")]},
            ["field 'relations[0].ground'", "'HoytBlok'", "did you mean 'HoytBlock'?"],
        ),
        (
            {"relations": [entry("behnd", "HoytBlock")]},
            ["field 'relations[0].relation'", "'behnd'", "did you mean 'behind'?"],
        ),
        (
            {"frames": [{"ground": "x", "relation": "front", "front_deg": 0}]},
            ["field 'frames[0].ground'", "'x'"],
        ),
    ],
)
def test_a_fault_passes_on_what_the_registry_would_have_accepted(read, changes, words):
    with pytest.raises(InputError) as caught:
        read(line(**changes))
    for word in words:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_faults_of_all_lines_are_listed_at_once(read, tmp_path):
    path = tmp_path / "said.jsonl"
    with pytest.raises(InputError) as caught:
        read(line(), "{nonsense", line(id="b", text=None), line(), "[1]", line(id="c"))
    assert str(caught.value).split("; ") == [
        (
            f"{path}:2: field 'line' is not JSON: Expecting property name enclosed in double "
            "quotes: line 1 column 2 (char 1)"
        ),
        f"{path}:3: field 'text' is missing",
        "expected a text",
        f"{path}:4: field 'id' repeats 'a'",
        "expected one line for each id",
        f"{path}:5: field 'line' is a list",
        "expected a JSON object",
    ]


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    missing = tmp_path / "none.jsonl"
    with pytest.raises(InputError, match=r"Description file '.*none\.jsonl' cannot be read"):
        read_descriptions(missing)
    (tmp_path / "raw.jsonl").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"raw\.jsonl' cannot be read"):
        read_descriptions(tmp_path / "raw.jsonl")


def test_an_empty_file_holds_no_description(read, tmp_path):
    with pytest.raises(InputError) as caught:
        read("")
    assert str(caught.value) == (
        f"{tmp_path / 'said.jsonl'} holds no description; expected one JSON object a line"
    )


@pytest.mark.skipif(not SHARED.is_dir(), reason="the published descriptions are not here")
def test_the_published_descriptions_are_read_whole():
    descriptions = read_descriptions(sorted(SHARED.glob("*.jsonl")))
    assert len(descriptions) == 64
    assert sum(len(s.targets) for s in descriptions) == 128
    assert len({s.configuration for s in descriptions}) == 47
    # 207 entries; 19 of them between, in 9 relations.
    assert sum(len(s.relations) for s in descriptions) == 207 - 19 + 9


def test_the_examples_are_read():
    assert len(bundled_examples()) >= 28


def test_a_line_may_say_where_who_listens_was_and_which_area_is_searched(read):
    (annotated,) = read(
        line(
            hearer={"east_m": -300, "north_m": 12.5},
            area_m=[-50, -100, 60.5, 40],
            relations=[entry("north", "Hearer")],
        )
    )
    assert annotated.hearer == (-300.0, 12.5)  # outside the map
    assert annotated.area_m == (-50.0, -100.0, 60.5, 40.0)
    city = load_map("cleveland")
    assert annotated.description(city).hearer == (-300.0, 12.5)
    (relation,) = annotated.relations
    assert relation.ground == "Hearer"
    (plain,) = read(line(relations=[entry("north", "Hearer")]))  # gold may hold it
    assert plain.hearer is None
    assert plain.area_m is None


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"hearer": [1, 2]}, "field 'hearer' is a list; expected an object"),
        (
            {"hearer": {"east_m": 1}},
            "field 'hearer.north_m' is missing; expected a finite number, or 'lonlat' alone",
        ),
        (
            {"hearer": {"east_m": -81.6995, "north_m": 41.4998}},
            (
                "field 'hearer' has east_m -81.6995 and north_m 41.4998, which are degrees of this "
                "map; expected metres from its centre, or 'lonlat': [longitude, latitude]"
            ),
        ),
        (
            {"targets": {"GreenToyota": {"lonlat": [41.4998, -81.6995]}}},
            (
                "field 'targets.GreenToyota.lonlat' is [41.4998, -81.6995]; expected longitude, "
                "then latitude"
            ),
        ),
        (
            {"hearer": {"east_m": 1, "north_m": float("inf")}},
            "field 'hearer.north_m' is inf; expected a finite number",
        ),
        (
            {"area_m": [0, 0, 1]},
            "field 'area_m' is [0, 0, 1]; expected four numbers: west, south, east, north",
        ),
        (
            {"area_m": [0, 0, "1", 2]},
            "field 'area_m' is [0, 0, '1', 2]; expected four numbers: west, south, east, north",
        ),
        (
            {"area_m": [10, 0, 5, 2]},
            (
                "field 'area_m' is [10.0, 0.0, 5.0, 2.0]; expected west < east and south < north, "
                "metres"
            ),
        ),
        (
            {"area_m": [500, 0, 600, 50]},
            "field 'area_m' is [500.0, 0.0, 600.0, 50.0], none of which is on the map",
        ),
    ],
)
def test_a_hearer_or_an_area_that_is_none_is_a_fault(read, changes, fault):
    with pytest.raises(InputError) as caught:
        read(line(**changes))
    assert str(caught.value).endswith(fault)


def test_degrees_alone_are_a_place(read):
    alone = {"lonlat": PLACE["lonlat"]}
    (annotated,) = read(line(targets={"GreenToyota": alone}, hearer=alone))
    (metres,) = read(line())
    place, known = annotated.targets["GreenToyota"], metres.targets["GreenToyota"]
    assert place.cell == known.cell
    assert (place.x_m, place.y_m) == pytest.approx((known.x_m, known.y_m), abs=0.3)
    assert annotated.hearer == (place.x_m, place.y_m)
    (far,) = read(line(hearer={"lonlat": [-81.71, 41.4998]}))  # outside the map
    assert far.hearer[0] == pytest.approx(-913, abs=2)


def test_another_target_is_a_ground(read):
    targets = {"GreenToyota": PLACE, "RedBike": PLACE}
    relation = {"figure": "RedBike", "relation": "near", "ground": "GreenToyota"}
    (annotated,) = read(line(targets=targets, relations=[relation]))
    assert annotated.relations == (SpatialRelation("RedBike", "near", ("GreenToyota",)),)
    (default,) = read(line(targets=None, relations=[relation]))  # the default objects
    assert default.relations == annotated.relations
    with pytest.raises(InputError, match=r"field 'relations\[0\].ground' is not on the map"):
        read(line(relations=[entry("near", "RedBike")]))  # not declared by this line


def test_facts_of_relations_to_targets_and_to_who_listens(read):
    from sloop_ppl.eval._facts import facts_of

    targets = {"GreenToyota": PLACE, "RedBike": PLACE}
    grounds = [entry("left", "RedBike"), entry("left", "Hearer"), entry("left", "VelvetDog")]
    (annotated,) = read(line(targets=targets, relations=grounds))
    facts, _ = facts_of(annotated, load_map("cleveland"))
    assert [fact.good is None for fact in facts.relations] == [True, True, False]
    assert {fact.relation_class for fact in facts.relations} == {"left"}
