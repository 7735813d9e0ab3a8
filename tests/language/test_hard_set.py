"""The figures to meet: on sentences of our own, and on the published ones if they are there."""

from pathlib import Path

import numpy as np
import pytest

from sloop_ppl.eval import read_descriptions, score_parser
from sloop_ppl.language import parse
from sloop_ppl.maps import bundled_maps, load_map

DATA = Path(__file__).parent / "data"
PUBLISHED = Path(__file__).parents[3] / "shared" / "data" / "descriptions"


def test_the_part_that_was_looked_at():
    assert score_parser(read_descriptions(DATA / "hard_dev.jsonl")).tuple_f1 >= 0.97


def test_the_part_that_is_only_scored():
    scenes = read_descriptions(DATA / "hard_scored.jsonl")
    assert len(scenes) >= 60
    assert score_parser(scenes).tuple_f1 >= 0.93


def test_negation_is_read_with_the_relation():
    scenes = [s for s in read_descriptions(DATA / "hard_dev.jsonl") if "negation" in s.id]
    assert scenes
    for scene in scenes:
        read = parse(scene.text, load_map(scene.map)).relations
        told = {(r.figure, r.relation, r.ground, r.negated) for r in read}
        assert told == {(r.figure, r.relation, r.ground, r.negated) for r in scene.relations}


@pytest.mark.skipif(not PUBLISHED.is_dir(), reason="the descriptions of ../shared are absent")
def test_the_published_descriptions():
    scenes = read_descriptions(sorted(PUBLISHED.glob("*.jsonl")))
    score = score_parser(scenes)
    assert (score.tuple_f1, score.class_f1, score.pair_f1) >= (0.97, 0.98, 0.99)
    assert score.class_f1 >= 0.98
    assert score.pair_f1 >= 0.99
    merged = score_parser(scenes, merged=[load_map(name) for name in bundled_maps()])
    assert merged.tuple_f1 >= 0.96
    misspelt = score_parser(scenes, misspelt=0.15, rng=np.random.default_rng(0))
    assert misspelt.tuple_f1 >= 0.93
