"""Run folders that were moved, edited, or of which a part is missing: restored, or refused."""

from __future__ import annotations

import json
import shutil

import pytest
from support.small_sweeps import request, table_of

from sloop_ppl.errors import InputError, OutputError, SloopError
from sloop_ppl.eval._report import _examples
from sloop_ppl.eval._sweep_files import sweep_files
from sloop_ppl.eval.results import read_results, reward_summary

ASKED = {"models": "uniform,sloop", "ranges": "3"}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    return folder, table_of(sweep_files(request(folder, **ASKED)))


@pytest.fixture
def run(whole, tmp_path):
    """Return a copy of a finished run, in a folder with what it was made of."""
    shutil.copytree(whole[0], tmp_path, dirs_exist_ok=True)
    return tmp_path / "run"


def resumed(run):
    return table_of(sweep_files(request(run.parent, out=run, **ASKED)))


def test_a_moved_folder_is_reported_and_gone_on_with(whole, run, tmp_path):
    before = reward_summary(read_results(run))
    moved = tmp_path / "else where" / "ünïcode"
    moved.parent.mkdir()
    run.rename(moved)
    assert reward_summary(read_results(moved)) == before
    next((moved / "parts").glob("*.jsonl")).unlink()
    assert table_of(sweep_files(request(tmp_path, out=moved, **ASKED))) == whole[1]


def without(name):
    def damage(run):
        path = run / name
        shutil.rmtree(path) if path.is_dir() else path.unlink()

    return damage


def holding(name, text):
    return lambda run: (run / name).write_text(text)


@pytest.mark.parametrize(
    "damage",
    [
        without("targets.json"), without("parts"), without("examples"), without("trials.parquet"),
        holding("targets.json", "[]"), holding("targets.json", "[1"),
    ],
)  # fmt: skip
def test_what_is_missing_is_made_again(whole, run, damage):
    damage(run)
    assert resumed(run) == whole[1]
    assert read_results(run).trials


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (without("targets.json"), "targets.json' cannot be read"),
        (without("parts"), "has 0 of its 6 trials"),
        (holding("targets.json", "[]"), "is not what this sweep wrote; give the same"),
        (holding("manifest.json", "[1"), "is not JSON"),
    ],
)
def test_no_report_is_made_of_what_is_damaged(run, damage, message):
    damage(run)
    with pytest.raises(InputError, match=message):
        read_results(run)


@pytest.mark.parametrize(
    ("text", "message"),
    [("[1", "best.json"), ("{}", "best.json"), ('{"description": "x"}', "best.json")],
)
def test_a_damaged_example_is_named_in_one_line(run, text, message):
    (run / "examples" / "best.json").write_text(text)
    with pytest.raises(InputError, match=message):
        _examples(read_results(run), None)


def test_an_example_of_another_sweep_is_named(run):
    path = run / "examples" / "best.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"description": "elsewhere"}))
    with pytest.raises(InputError, match="is an episode of no target of this sweep; delete it"):
        _examples(read_results(run), None)


def test_trials_without_a_manifest_are_not_taken_for_this_sweep_s(run):
    for name in ("manifest.json", "trials.parquet", "examples"):
        without(name)(run)
    with pytest.raises(OutputError, match="holds trials and no manifest"):
        resumed(run)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"discounted_reward": float("nan")}, "holds the number NaN"),
        ({"steps": "3"}, "field 'steps' is '3'; expected a whole number of at least 0"),
        ({"steps": -3}, "field 'steps' is -3"),
        ({"found": "no"}, "field 'found' is 'no'; expected true or false"),
        ({"model": "bayes"}, "is a trial of another sweep"),
        ({"map": "denver"}, "is a trial of another sweep"),
        ({"start": 7}, "is a trial of another sweep"),
    ],
)
def test_edited_trials_are_named(run, change, message):
    (part,) = (run / "parts").glob("*.jsonl")
    first, *others = part.read_text().splitlines()
    part.write_text("\n".join([*others, json.dumps(json.loads(first) | change), ""]))
    for read in (read_results, resumed):
        with pytest.raises(SloopError, match=f"line 6: .*{message}.*delete the line"):
            read(run)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"n_trials": "x"}, "field 'n_trials' is 'x'; expected a whole number of at least 0"),
        ({"model_names": 3}, "field 'model_names' is a int; expected a list of names"),
        ({"ranges_cells": []}, "field 'ranges_cells'"),
        ({"primary": None}, "field 'primary'"),
    ],
)
def test_an_edited_manifest_is_named(run, change, message):
    manifest = run / "manifest.json"
    manifest.write_text(json.dumps(json.loads(manifest.read_text()) | change))
    with pytest.raises(InputError, match=f"was changed: {message}"):
        read_results(run)
    with pytest.raises(InputError, match="holds another sweep"):
        resumed(run)
