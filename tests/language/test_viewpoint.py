"""Up, down, above, below, under and top are compass words to who looks at a map, only to them."""

import json
from dataclasses import replace

import pytest

import sloop_ppl as sloop
from sloop_ppl.bridge._timed_utterances import follow_up
from sloop_ppl.cli import main
from sloop_ppl.errors import UnknownName
from sloop_ppl.eval import read_descriptions
from sloop_ppl.eval.parsing import score_parser
from sloop_ppl.eval.quality import read_annotated
from sloop_ppl.inference import Posterior
from sloop_ppl.language import RELATIONS, Description, SpatialRelation, TargetObject
from sloop_ppl.models import preset

CITY = sloop.load_map("cleveland")
SEEN = {"above": "at", "below": "at", "under": "at", "top": "at", "up": "near", "down": "near"}
UNDER = "The red bike is under Ivy"


def run(*typed):
    with pytest.raises(SystemExit) as stopped:
        main(list(typed))
    return stopped.value.code


def relation_of(text, **options):
    (relation,) = sloop.parse(text, CITY, **options).relations
    return relation.relation


def test_vertical_words_have_no_compass_meaning_on_the_ground():
    assert {w: r.from_ground for w, r in RELATIONS.items() if r.from_ground} == SEEN
    for word, meant in SEEN.items():
        text = f"The red bike is {RELATIONS[word].phrase} Ivy"
        assert relation_of(text) == relation_of(text, viewpoint="map") == word
        assert relation_of(text, viewpoint="ground") == meant
        assert not RELATIONS[meant].is_compass
    assert relation_of("The red bike is north of Ivy", viewpoint="ground") == "north"


def test_the_map_has_a_top_from_everywhere():
    text = "The red bike is at the top of the map"
    assert relation_of(text, viewpoint="ground") == relation_of(text) == "north"


def test_a_description_by_hand_means_the_same():
    said = (
        SpatialRelation("RedBike", "under", ("Ivy",)),
        SpatialRelation("RedBike", "on", ("Ivy",)),
    )
    targets = (TargetObject("RedBike"),)
    description = Description("", "cleveland", targets, said, viewpoint="ground")
    assert [r.relation for r in description.relations] == ["at", "on"]
    assert Description("", "cleveland", targets, said).relations == said


def test_beliefs_follow_and_the_viewpoint_is_kept(tmp_path):
    one_reading = replace(preset("bayes"), sum_readings=False)  # words are not equally sure
    under = sloop.parse(UNDER, CITY, viewpoint="ground")
    posterior = sloop.infer(under, CITY, model=one_reading)
    at = sloop.infer("The red bike is at Ivy", CITY, model=one_reading).belief("RedBike")
    assert (posterior.belief("RedBike") == at).all()
    posterior.save(tmp_path / "a.nc")
    loaded = Posterior.load(tmp_path / "a.nc")
    assert loaded.descriptions == posterior.descriptions
    assert follow_up(loaded, "It is above Rumor").relations[0].relation == "at"


def test_an_unknown_viewpoint_is_refused(capsys):
    message = "Viewpoint 'sky' is unknown; expected one of map, ground"
    with pytest.raises(UnknownName, match=message):
        sloop.parse(UNDER, CITY, viewpoint="sky")
    for command in ("parse", "infer"):
        assert run(command, UNDER, "--map", "cleveland", "--viewpoint", "sky") == 2
        assert capsys.readouterr().err == f"sloop: {message}\n"


def test_commands_take_the_viewpoint(capsys):
    typed = [UNDER, "--map", "cleveland", "--json"]
    assert run("parse", *typed, "--viewpoint", "ground") == 0
    assert json.loads(capsys.readouterr().out)["relations"][0]["relation"] == "at"
    beliefs = []
    for viewpoint in ("map", "ground"):
        assert run("infer", *typed, "--viewpoint", viewpoint) == 0
        beliefs.append(json.loads(capsys.readouterr().out)["targets"]["RedBike"]["mode_m"])
    assert beliefs[0][1] < beliefs[1][1]  # south of it, and at it


def test_lines_of_a_description_file_have_one(tmp_path):
    line = {
        "id": "one", "map": "cleveland", "text": UNDER, "viewpoint": "ground",
        "targets": {"RedBike": {"east_m": 0, "north_m": 0}},
        "relations": [{"figure": "RedBike", "relation": "under", "ground": "Ivy"}],
    }  # fmt: skip
    file = tmp_path / "a.jsonl"
    file.write_text(json.dumps(line))
    (annotated,) = read_descriptions(file)
    assert annotated.viewpoint == "ground"
    assert [r.relation for r in annotated.relations] == ["at"]
    assert score_parser([annotated]).tuple_f1 == 1
    for relations in ("gold", "parsed"):
        _, description = read_annotated(annotated, CITY, relations)
        assert [r.relation for r in description.relations] == ["at"]
        assert description.viewpoint == "ground"
    file.write_text(json.dumps({**line, "viewpoint": "sky"}))
    with pytest.raises(sloop.errors.InputError, match="field 'viewpoint' is none: Viewpoint 'sky'"):
        read_descriptions(file)
