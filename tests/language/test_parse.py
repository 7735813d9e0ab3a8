import sys

import pytest

from sloop_ppl.errors import DescriptionError, InputError, UnknownName
from sloop_ppl.language import (
    Description,
    SpatialRelation,
    TargetObject,
    list_parsers,
    no_relation_found,
    parse,
    recognised,
)
from sloop_ppl.language.parsers import PARSERS
from sloop_ppl.maps import load_map

CLEVELAND = load_map("cleveland")


def read(text, city=CLEVELAND, targets=None):
    said = parse(text, city, targets)
    return [
        (r.figure, ("not " if r.negated else "") + r.relation, *r.grounds) for r in said.relations
    ]


@pytest.mark.parametrize(
    ("text", "relations"),
    [
        ("the green toyota is behind velvet dog", [("GreenToyota", "behind", "VelvetDog")]),
        (
            "The red bike and the green car are both near Rumor.",
            [("RedBike", "near", "Rumor"), ("GreenToyota", "near", "Rumor")],
        ),
        (
            "Behind Ivy is the red bike, next to Rumor.",
            [("RedBike", "behind", "Ivy"), ("RedBike", "next", "Rumor")],
        ),
        (
            "The red bike is at the corner of W 6th St and St Clair Ave",
            [("RedBike", "at", "West6thSt", "WestSaintClairAvenue")],
        ),
        (
            "The red bike is between Ivy and Rumor, not on Johnson Court but on West 6th.",
            [
                ("RedBike", "between", "Ivy", "Rumor"),
                ("RedBike", "not on", "JohnsonCourt"),
                ("RedBike", "on", "West6thSt"),
            ],
        ),
        ("Hoyt Block is west of the red bike.", [("RedBike", "east", "HoytBlock")]),
        (
            "The red bike is in Stone Block. The green car is north of it.",
            [("RedBike", "in", "StoneBlock"), ("GreenToyota", "north", "StoneBlock")],
        ),
        ("My dog is under the Bradley", [("MyDog", "under", "TheBradley")]),
        ("Go past Ivy. The red bike is near Rumor.", [("RedBike", "near", "Rumor")]),
    ],
)
def test_relations_of_small_texts(text, relations):
    assert read(text) == relations


def test_a_distance_is_read_in_metres():
    (relation,) = parse("The red car is about 50 feet west of Hoyt Block", CLEVELAND).relations
    assert (relation.relation, relation.distance_m) == ("west", 15.24)


def test_spans_point_at_the_words():
    text = "Look: the green toyota is right  behind Velvet Dog."
    (relation,) = parse(text, CLEVELAND).relations
    assert relation.spans is not None
    spans = relation.spans.figure, relation.spans.relation, *relation.spans.grounds
    assert [text[a:b] for a, b in spans] == ["green toyota", "behind", "Velvet Dog"]


def test_only_declared_objects_are_figures_when_some_are_declared():
    cat = TargetObject("Tom", ("tom", "the fat cat"), None, "cat")
    text = "The red bike is near Ivy and Tom is near Rumor"
    assert read(text, targets=[cat]) == [("Tom", "near", "Rumor")]


def test_a_name_that_is_not_on_the_map_is_reported_with_the_nearest():
    said = parse("The red bike is behind the Hoyt Hotle", load_map("denver"))
    assert said.relations == ()
    assert [u.text for u in said.unresolved] == ["Hoyt Hotle"]


def test_what_is_to_the_hearer_is_reported_not_guessed():
    said = parse("The red bike is on your left", CLEVELAND)
    assert said.relations == ()
    assert [u.text for u in said.unresolved] == ["on your left"]


def test_no_relation_is_explained_in_one_line():
    text = "The red bike is behind the Hotel\nSplendid"
    message = str(no_relation_found(parse(text, CLEVELAND), CLEVELAND))
    assert "\n" not in message
    assert message.startswith(
        "No relation found in 'The red bike is behind the Hotel Splendid'; recognised target "
        "RedBike, no landmark, relation word behind; 'Hotel Splendid' was not found on map "
        "'cleveland'"
    )
    assert recognised(text, CLEVELAND).targets == ("RedBike",)


def test_a_parser_of_ones_own_can_be_given_or_registered():
    def mine(text, city, targets):
        return Description(text, city.name, (), (SpatialRelation("A", "near", ("Ivy",)),))

    assert parse("x", CLEVELAND, parser=mine).relations[0].figure == "A"
    assert "rules" in list_parsers()
    assert set(PARSERS) == set(list_parsers())


def test_a_parser_can_be_named_by_where_it_is_defined(tmp_path, monkeypatch):
    (tmp_path / "grammar_of_mine.py").write_text(
        "from sloop_ppl.language import Description\n"
        "notes = 3\n"
        "def read(text, city, targets):\n"
        "    return Description(text.upper(), city.name, (), ())\n"
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    assert parse("x", CLEVELAND, parser="grammar_of_mine:read").text == "X"
    with pytest.raises(InputError, match="is a int; expected a callable"):
        parse("x", CLEVELAND, parser="grammar_of_mine:notes")
    with pytest.raises(InputError, match="'no_such_module:read' cannot be imported: No module"):
        parse("x", CLEVELAND, parser="no_such_module:read")


@pytest.mark.parametrize(
    ("given", "error", "message"),
    [
        (
            {"text": "x", "parser": "ruls"},
            UnknownName,
            "Parser 'ruls' is unknown; expected one of",
        ),
        ({"text": 3}, InputError, "The text is a int; expected a string"),
        (
            {"text": "x", "targets": [TargetObject("A"), TargetObject("A")]},
            DescriptionError,
            "The targets: id 'A' is given twice; ids are unique",
        ),
    ],
)
def test_bad_arguments_are_said_in_one_line(given, error, message):
    with pytest.raises(error) as caught:
        parse(city=CLEVELAND, **given)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


STRANGE = (
    "", " ", "\0", "🚗 is 🚲", "\ud800", "السيارة خلف المبنى", "<b>red bike</b>", "." * 1000,
    "the red bike is " * 500, "near " * 1000, "and " * 1000, "between Ivy and " * 300,
)  # fmt: skip


@pytest.mark.parametrize("text", STRANGE)
def test_any_text_gives_a_description(text):
    said = parse(text, CLEVELAND)
    assert said.text == text
    said.to_json()
