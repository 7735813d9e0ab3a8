"""The annotated meeting-point texts: the kept gold, joined with the texts if they are there."""

from pathlib import Path

import pytest

from sloop_ppl.eval._agreement import agreement, merged
from sloop_ppl.eval._annotation_files import read_annotations
from sloop_ppl.eval._inventory import map_finder
from sloop_ppl.eval.descriptions import read_descriptions

DATA = Path(__file__).parent / "data"
GOLD = DATA / "meeting_points_gold.jsonl"
TEXTS = Path(__file__).parents[3] / "shared" / "data" / "meeting_points"


def test_the_gold_is_what_both_annotators_make_of_it():
    first, second = (read_annotations(DATA / f"meeting_points_{one}.jsonl") for one in "ab")
    assert merged(first, second) == read_annotations(GOLD)


def test_the_annotators_agree():
    first, second = (read_annotations(DATA / f"meeting_points_{one}.jsonl") for one in "ab")
    assert first.keys() == second.keys()
    assert len(first) >= 60
    found = agreement(first, second)
    assert min(one.f1 for one in found.values()) >= 0.85
    assert list(found) == ["hearer", "named", "other", "own_kind", "all"]


def test_texts_are_not_kept():
    for path in DATA.glob("meeting_points*.jsonl"):
        assert '"text"' not in path.read_text(encoding="utf-8")


@pytest.mark.skipif(not TEXTS.is_dir(), reason="the meeting-point texts of ../shared are absent")
def test_the_gold_fits_the_texts_and_maps():
    files = sorted(TEXTS.glob("*.jsonl"))
    descriptions = read_descriptions(files, map_finder(TEXTS / "maps"), GOLD)
    told = [one for one in descriptions if one.has_gold]
    assert {one.id for one in told} == read_annotations(GOLD).keys()
    assert all(one.hearer is not None and one.area_m is not None for one in told)
    assert all(entry.figure == "Me" for one in told for entry in one.gold)
