"""Cross-validation leaves out cities: maps whose centres lie near each other go together."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from sloop_ppl.errors import UnknownName
from sloop_ppl.eval import bundled_examples, read_descriptions
from sloop_ppl.eval._inventory import map_finder
from sloop_ppl.eval.crossval import examples_of, refits
from sloop_ppl.eval.descriptions import read_to_score
from sloop_ppl.inference import infer_description
from sloop_ppl.inference.learning import log_scores
from sloop_ppl.maps import load_map, write_map
from sloop_ppl.models import UNFITTED_BAYES


def line(name, **more):
    place = {"east_m": 0.0, "north_m": 20.0}
    relation = {"figure": "Me", "relation": "near", "ground": "Ivy"}
    return {"id": name, "map": name, "text": "Near Ivy.", "targets": {"Me": place},
            "relations": [relation], **more}  # fmt: skip


@pytest.fixture
def cut(tmp_path):
    """Two files of lines whose maps are copies of one map under names of their own."""
    maps = tmp_path / "maps"
    maps.mkdir()
    files = []
    for city, south in (("here", 0.0), ("there", 1.0)):  # a degree apart: 111 km
        names = [f"{city}{n}" for n in range(3)]
        for n, name in enumerate(names):
            bundled = load_map("cleveland")
            latitude, longitude = bundled.grid.centre
            centre = (latitude - south - n / 50, longitude)
            grid = replace(bundled.grid, centre=centre)
            write_map(replace(bundled, grid=grid, _cache={}), maps / f"{name}.geojson")
        files.append(tmp_path / f"{city}.jsonl")
        files[-1].write_text("".join(json.dumps(line(name)) + "\n" for name in names))
    return files, maps


def test_a_file_of_cut_maps_is_one_city(cut):
    files, maps = cut
    read = read_descriptions(files, map_finder(maps))
    assert [one.city for one in read] == ["here"] * 3 + ["there"] * 3
    assert {one.city for one in bundled_examples()} == {one.map for one in bundled_examples()}


def test_all_maps_of_a_city_have_the_fit_without_it(cut):
    files, maps = cut
    find = map_finder(maps)
    found = refits(read_descriptions(files, find), UNFITTED_BAYES, find, iterations=1)
    assert set(found) == {"here0", "here1", "here2", "there0", "there1", "there2"}
    assert found["here0"] is found["here2"]
    assert found["here0"].provenance["examples"] == 3


def test_a_folder_of_maps_does_not_hide_the_bundled_ones(cut):
    find = map_finder(cut[1])
    assert find("denver").name == "denver"
    with pytest.raises(UnknownName):
        find("nowhere")


def test_learning_scores_the_belief_within_the_area(cut, tmp_path):
    files, maps = cut
    find = map_finder(maps)
    whole = read_descriptions(files[0], find)[0]
    narrow = tmp_path / "narrow.jsonl"
    narrow.write_text(json.dumps(line("here0", area_m=[-50, -50, 50, 50])))
    part = read_descriptions(narrow, find)[0]
    scores = [
        float(log_scores(examples_of([one], find), UNFITTED_BAYES)[0]) for one in (whole, part)
    ]
    city = find("here0")
    posterior, _ = infer_description(whole.description(city), city, UNFITTED_BAYES)
    belief = posterior.belief("Me")
    inside = part.search_area(city.grid).cells
    assert scores[1] - scores[0] == pytest.approx(-np.log(belief[inside].sum()), abs=1e-6)


def test_gold_that_accepts_several_places_teaches_all_of_them(cut, tmp_path):
    find = map_finder(cut[1])
    both = tmp_path / "both.jsonl"
    relation = {"figure": "Me", "relation": "near", "ground": "Ivy", "also": ["VelvetDog"]}
    both.write_text(json.dumps(line("here0", relations=[relation])))
    annotated = read_descriptions(both, find)[0]
    slot = annotated.relations[0].candidates[0]
    assert [(c.ground, c.probability) for c in slot] == [("Ivy", 0.5), ("VelvetDog", 0.5)]
    score = float(log_scores(examples_of([annotated], find), UNFITTED_BAYES)[0])
    city = find("here0")
    posterior, _ = infer_description(annotated.description(city), city, UNFITTED_BAYES)
    belief = posterior.belief("Me")
    assert score == pytest.approx(float(np.log(belief[annotated.targets["Me"].cell])), abs=1e-6)


def test_several_files_of_annotations(cut, tmp_path):
    files, maps = cut
    notes = []
    for name in ("here0", "there1"):
        notes.append(tmp_path / f"{name}.notes.jsonl")
        relation = {"figure": "Me", "relation": "at", "ground": "VelvetDog"}
        notes[-1].write_text(json.dumps({"id": name, "relations": [relation]}))
    read = {one.id: one for one in read_descriptions(files, map_finder(maps), notes)}
    assert read["here0"].relations[0].ground == read["there1"].relations[0].ground == "VelvetDog"
    assert read["here1"].relations[0].ground == "Ivy"


def test_what_is_learnt_from_beside_is_not_scored(cut, tmp_path):
    files, maps = cut
    notes = tmp_path / "notes.jsonl"
    relation = {"figure": "Me", "relation": "at", "ground": "VelvetDog"}
    notes.write_text(json.dumps({"id": "there1", "relations": [relation]}))
    scored, others, faults = read_to_score(files[:1], files, map_finder(maps), notes)
    assert [one.id for one in scored] == ["here0", "here1", "here2"]
    assert [one.relations[0].ground for one in others] == ["Ivy", "VelvetDog", "Ivy"]
    assert not faults
