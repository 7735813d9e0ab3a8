import json
import shutil
from importlib.resources import files

import pytest

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.eval._inventory import all_maps, map_finder
from sloop_ppl.eval._parse_files import parse_score_lines, score_files

LINES = [
    {
        "id": "a",
        "map": "cleveland",
        "text": "The red bike is near Ivy",
        "relations": [{"figure": "RedBike", "relation": "near", "ground": "Ivy"}],
    },
    {
        "id": "b",
        "map": "cleveland",
        "text": "The red bike is close to Rumor",
        "relations": [{"figure": "RedBike", "relation": "near", "ground": "Rumor"}],
    },
]


@pytest.fixture
def path(tmp_path):
    file = tmp_path / "said.jsonl"
    file.write_text("\n".join(json.dumps(line) for line in LINES))
    return file


def test_files_are_scored(path):
    score = score_files([path])
    assert (score.n, score.tuple_f1, score.class_f1) == (2, 0.5, 1.0)
    table, *figures = parse_score_lines(score)
    assert table.row_count == 2
    assert figures == [
        (
            "2 descriptions: tuple F1 0.5000 (precision 0.5000, recall 0.5000), class F1 1.0000, "
            "pair F1 1.0000"
        ),
        (
            "class and polarity F1 1.0000, 2 of 2 wholly right, 0 false positives, linking recall "
            "1.0000"
        ),
    ]


def test_misses_are_told_when_asked_for(tmp_path):
    lines = [LINES[0], {**LINES[1], "text": "The red bike is not near Rumor", "phenomena": ["no"]}]
    file = tmp_path / "said.jsonl"
    file.write_text("\n".join(json.dumps(line) for line in lines))
    score = score_files([file])
    *missed, relations, status, phenomena, _, _ = parse_score_lines(score, misses=True)
    assert missed == [
        "b: The red bike is not near Rumor",
        "  missed  RedBike near Rumor",
        "  wrong   RedBike not near Rumor",
    ]
    assert [table.columns[0].header for table in (relations, status, phenomena)] == [
        "relation", "status", "phenomenon",
    ]  # fmt: skip
    assert parse_score_lines(score)[0].columns[0].header == "relation"


def test_annotations_are_the_gold_of_lines_without(path, tmp_path):
    texts, gold = tmp_path / "texts.jsonl", tmp_path / "gold.jsonl"
    bare = [{k: v for k, v in line.items() if k != "relations"} for line in LINES]
    texts.write_text("\n".join(json.dumps(line) for line in bare))
    gold.write_text(json.dumps({"id": "a", "relations": LINES[0]["relations"]}))
    score = score_files([texts], annotations=gold)
    assert (score.n, score.not_scored, score.tuple_f1) == (1, 1, 1)
    assert "1 lines without relations: not scored" in parse_score_lines(score)
    assert score_files([texts, tmp_path / "said.jsonl"][1:], annotations=gold) == score_files(
        [path]
    )


@pytest.mark.parametrize(
    ("line", "fault"),
    [
        ({"id": "a"}, ":1: field 'relations' is missing; expected a list"),
        ({"id": "z", "relations": []}, " holds the ids of none of these lines, but such as 'z'"),
        (
            {"id": "a", "relations": [{"figure": "RedBike", "relation": "near"}]},
            "said.jsonl:1: field 'relations[0].ground' is missing; expected an id",
        ),
    ],
)
def test_annotations_with_a_fault(path, tmp_path, line, fault):
    gold = tmp_path / "gold.jsonl"
    gold.write_text(json.dumps(line))
    with pytest.raises(InputError) as caught:
        score_files([path], annotations=gold)
    assert fault in str(caught.value)


def test_the_same_seed_misspells_the_same(path):
    one, other = (score_files([path], misspelt=1.0, seed=4) for _ in range(2))
    assert one == other


def test_merged_maps(path):
    assert score_files([path], merged=True).tuple_f1 == 0.5


def test_maps_of_a_folder(path, tmp_path):
    bundled = files("sloop_ppl") / "data" / "maps" / "cleveland.geojson"
    shutil.copy(str(bundled), tmp_path / "cleveland.geojson")
    assert [m.name for m in all_maps(tmp_path)] == ["cleveland"]
    assert score_files([path], maps=tmp_path).n == 2
    assert map_finder(tmp_path)("denver").name == "denver"
    with pytest.raises(UnknownName, match=r"Map 'atlantis' is unknown; expected one of cleveland"):
        map_finder(tmp_path)("atlantis")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"maps": "nowhere"}, "The maps folder 'nowhere' is no folder; expected one of .geojson"),
        ({"seed": -1}, "The seed is -1; expected 0 or more"),
        ({"parser": "magic"}, "Parser 'magic' is unknown; expected one of rules"),
        ({"misspelt": 2.0}, "The share of misspelt words is 2; expected 0 to 1"),
    ],
)
def test_bad_arguments(path, given, message):
    with pytest.raises(InputError) as caught:
        score_files([path], **given)
    assert str(caught.value).startswith(message)


def test_a_folder_without_maps(tmp_path):
    with pytest.raises(InputError, match=r"holds no \.geojson file; expected at least one"):
        map_finder(tmp_path)
