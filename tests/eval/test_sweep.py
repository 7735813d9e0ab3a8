"""The sweep: which trials, what they share, where they go, and what is refused."""

import errno
import json
import os
from dataclasses import replace

import pyarrow.parquet
import pytest
from support.small_sweeps import LINES, SHORT, request, table_of, write_lines

from sloop_ppl.errors import InputError, OutputError, UnknownName
from sloop_ppl.eval._run_folder import writing
from sloop_ppl.eval._sweep_files import sweep_files
from sloop_ppl.eval.results import read_results, reward_summary
from sloop_ppl.eval.trials import Searching, compile_ahead


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    return sweep_files(request(tmp_path_factory.mktemp("sweep")))


def test_every_target_meets_every_model_and_range(done):
    trials = table_of(done)
    assert len(trials) == 3 * 2 * 2 == done.manifest["n_trials"]
    assert {t["target"] for t in trials if t["description"] == "one"} == {"RedBike", "GreenToyota"}
    assert all(t["steps"] <= 6 for t in trials)


def test_models_and_ranges_share_starts_and_starts_differ(done):
    starts = {}
    for t in table_of(done):
        key = t["description"], t["target"]
        starts.setdefault(key, set()).add((t["start_x_m"], t["start_y_m"]))
    assert all(len(places) == 1 for places in starts.values())
    assert len(set.union(*starts.values())) == 3


def test_a_trial_is_the_same_alone_and_among_others(done, tmp_path):
    write_lines(tmp_path / "said.jsonl", LINES[1])
    alone = sweep_files(request(tmp_path, models="sloop", ranges="4"))
    wanted = [t for t in table_of(done) if t["description"] == "two" and t["range_cells"] == 4]
    assert table_of(alone) == [t for t in wanted if t["model"] == "sloop"]


def test_a_stopped_sweep_goes_on_with_what_is_missing(done, tmp_path):
    folder = sweep_files(request(tmp_path))
    (part,) = folder.parts.glob("*.jsonl")
    lines = part.read_bytes().splitlines(keepends=True)
    part.unlink()
    torn = folder.parts / "part-of-a-killed-worker.jsonl"
    torn.write_bytes(b"".join(lines[:4]) + lines[4][:37])
    assert len(folder.trials()) == 4
    told = []
    again = sweep_files(request(tmp_path), progress=told.append)
    assert table_of(again) == table_of(done)
    assert (told[0].done, told[-1].done, told[-1].total) == (4, 12, 12)
    assert pyarrow.parquet.read_table(again.parquet).num_rows == 12
    doubled = folder.parts / "part-other.jsonl"  # as of a worker that outlived its driver
    doubled.write_bytes(b"".join(lines))
    assert table_of(sweep_files(request(tmp_path))) == table_of(done)


def test_a_damaged_line_is_named(tmp_path):
    folder = sweep_files(request(tmp_path, models="uniform", ranges="3"))
    (part,) = folder.parts.glob("*.jsonl")
    part.write_bytes(b'{"description": 1}\n' + part.read_bytes())
    with pytest.raises(InputError, match=r"', line 1: is no trial .*; delete the line or the file"):
        folder.trials()


def test_another_sweep_is_refused_with_what_differs(tmp_path):
    sweep_files(request(tmp_path, models="uniform"))
    with pytest.raises(InputError, match=r"holds another sweep: starts was 1 and is 2; n_trials"):
        sweep_files(request(tmp_path, models="uniform", starts=2))
    write_lines(tmp_path / "said.jsonl", LINES[0] | {"text": "Now it is near Rumor."}, LINES[1])
    with pytest.raises(InputError, match=r"descriptions.said.jsonl was \w{12}… and is \w{12}…"):
        sweep_files(request(tmp_path, models="uniform"))


def test_a_folder_of_something_else_is_refused(tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "thesis.tex").write_text("my only copy")
    with pytest.raises(OutputError, match=r"holds thesis.tex and no manifest of a sweep; expected"):
        sweep_files(request(tmp_path))
    assert [p.name for p in (tmp_path / "run").iterdir()] == ["thesis.tex"]


def test_a_kill_at_the_very_end_is_made_good(tmp_path):
    folder = sweep_files(request(tmp_path, models="uniform", ranges="3"))
    before = {path.name: path.read_bytes() for path in folder.examples.iterdir()}
    assert sorted(before) == ["best.json", "median.json", "worst.json"]
    (folder.examples / "worst.json").unlink()
    folder.parquet.unlink()
    (folder.path / ".torn.json").write_text("{")
    sweep_files(request(tmp_path, models="uniform", ranges="3"))
    assert before == {path.name: path.read_bytes() for path in folder.examples.iterdir()}
    assert folder.parquet.is_file()


def test_two_sweeps_do_not_write_one_folder(tmp_path):
    with (
        writing(tmp_path, {"seed": 0}, []),
        pytest.raises(OutputError, match="is being written by another sweep; wait until"),
        writing(tmp_path, {"seed": 0}, []),
    ):
        pass


def test_a_full_disk_leaves_what_is_done(done, tmp_path, monkeypatch):
    wrote, room = os.write, [1500]

    def write(handle, data):
        if room[0] == 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        data = bytes(data)[: room[0]]
        room[0] -= len(data)
        return wrote(handle, data)

    monkeypatch.setattr("sloop_ppl.eval._trial_files.os.write", write)
    with pytest.raises(OutputError, match=r"No space left on device; what is done stays valid"):
        sweep_files(request(tmp_path))
    (part,) = (tmp_path / "run" / "parts").glob("*.jsonl")
    assert part.read_bytes().endswith(b"}\n")
    lines = part.read_text().splitlines()
    assert 1 <= len(lines) < 12
    assert all(json.loads(line) for line in lines)
    monkeypatch.undo()
    assert table_of(sweep_files(request(tmp_path))) == table_of(done)


def test_every_faulty_line_is_listed_or_passed_over(tmp_path):
    elsewhere = LINES[0] | {"id": "x", "map": "atlantis"}
    unknown = LINES[1] | {"id": "y", "relations": [{**LINES[1]["relations"][0], "ground": "Nil"}]}
    outside = LINES[1] | {"id": "z", "targets": {"RedBike": {"east_m": 500, "north_m": 0}}}
    write_lines(tmp_path / "said.jsonl", elsewhere, unknown, LINES[1], outside)
    with pytest.raises(InputError) as refused:
        sweep_files(request(tmp_path))
    told = str(refused.value)
    assert "said.jsonl:1: field 'map' names no map that can be used: Map 'atlantis'" in told
    assert "said.jsonl:2: field 'relations[0].ground' is not on the map" in told
    assert "said.jsonl:4: field 'targets.RedBike' is not on the map" in told
    assert told.endswith("Correct these lines, or pass over them with --skip-bad")
    assert not (tmp_path / "run").exists()
    passed = []
    folder = sweep_files(request(tmp_path, models="uniform", skip_bad=True), notify=passed.append)
    assert {t["description"] for t in table_of(folder)} == {"two"}
    assert len(passed) == 3
    assert passed[0].startswith("passed over ")


BAD = {
    "ranges": ({"ranges": "3,x"}, "Ranges '3,x' are no different positive numbers"),
    "range twice": ({"ranges": "3,3.0"}, "are no different positive numbers"),
    "range beyond the map": ({"ranges": "99"}, "more than the map, which is 41 x 41 cells"),
    "starts": ({"starts": 0}, "The number of starts is 0; expected at least 1"),
    "workers": ({"workers": 0}, "The number of workers is 0; expected at least 1"),
    "backend": ({"backend": "spark"}, "Backend 'spark' is unknown; expected one of joblib, ray"),
    "cv": ({"cv": "country"}, "Cross-validation 'country' is unknown; expected one of city"),
    "model": ({"models": "slop"}, "Model 'slop' is unknown"),
    "primary": ({"primary": "bayes,sloop"}, "is not of two of the models that are run"),
}


@pytest.mark.parametrize(("changes", "said"), BAD.values(), ids=BAD)
def test_bad_requests_are_refused_before_any_work(tmp_path, changes, said):
    with pytest.raises(InputError, match=said):
        sweep_files(request(tmp_path, **changes))
    assert not (tmp_path / "run").exists()


def test_bad_searching():
    with pytest.raises(UnknownName, match="Planner 'fats' is unknown"):
        replace(SHORT, planner="fats")
    with pytest.raises(InputError, match="The seed is -1; expected 0 or more"):
        replace(SHORT, seed=-1)


def test_joblib_takes_no_address(tmp_path):
    with pytest.raises(InputError, match=r"takes no address \('auto' was given\); leave"):
        sweep_files(request(tmp_path, address="auto"))
    assert not (tmp_path / "run").exists()


def test_parsed_relations_and_what_was_not_read(tmp_path):
    write_lines(tmp_path / "said.jsonl", LINES[1] | {"text": "hello there"})
    folder = sweep_files(request(tmp_path, gold=False))
    told = {(t["model"], t["range_cells"]): t for t in table_of(folder)}
    for range_cells in (3.0, 4.0):  # nothing was read, so the belief is the uniform one
        sloop, uniform = told["sloop", range_cells], told["uniform", range_cells]
        assert sloop["discounted_reward"] == uniform["discounted_reward"]
    assert folder.manifest["relations"] == "parsed"


def test_the_summary_has_the_agreed_keys(done):
    told = reward_summary(read_results(done.path))
    assert list(told) == ["relations", "planner", "models"]
    assert list(told["models"]) == ["uniform", "sloop"]
    assert list(told["models"]["sloop"]) == ["3", "4"]
    one = told["models"]["sloop"]["3"]
    assert list(one) == ["n", "discounted_reward", "ci95", "success", "steps"]
    assert one["n"] == 3
    trials = [t for t in table_of(done) if (t["model"], t["range_cells"]) == ("sloop", 3.0)]
    assert one["discounted_reward"] == pytest.approx(
        sum(t["discounted_reward"] for t in trials) / 3
    )
    assert one["steps"] == pytest.approx(sum(t["steps"] for t in trials) / 3)


def test_an_unfinished_sweep_is_not_reported(done, tmp_path):
    folder = sweep_files(request(tmp_path, models="uniform"))
    (part,) = folder.parts.glob("*.jsonl")
    part.write_bytes(part.read_bytes().splitlines(keepends=True)[0])
    with pytest.raises(InputError, match=r"has 1 of its 6 trials; give the same"):
        read_results(folder.path)


USERS = """
def flat(term, frame_angle_rad):
    even = term.distance_m * 0.0 - 0.5
    return even if frame_angle_rad is None else even + 0.0 * frame_angle_rad[:, None]
"""


@pytest.mark.slow
def test_two_workers_do_a_model_of_the_user_s(done, tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(USERS)
    mine = f"{file}:flat"
    folder = sweep_files(request(tmp_path, models=f"sloop,{mine}", workers=2))
    assert [t for t in table_of(folder) if t["model"] == "sloop"] == [
        t for t in table_of(done) if t["model"] == "sloop"
    ]
    assert sum(t["model"] == mine for t in table_of(folder)) == 6


@pytest.mark.slow
def test_a_worker_s_fault_is_told_in_its_own_words(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("def flat(term, frame_angle_rad):\n    return term.nothing\n")
    with pytest.raises(OutputError, match=r"^log_g of 'mine.py:flat' fails for relation"):
        sweep_files(request(tmp_path, models=f"{file}:flat,sloop", workers=2))


@pytest.mark.parametrize("planner", ["fast", "greedy"])
def test_machine_code_is_made_before_the_workers_ask_for_it(monkeypatch, planner):
    called = []
    monkeypatch.setattr("sloop_ppl.planning.run_search", lambda *_, **given: called.append(given))
    compile_ahead(Searching(planner=planner, rollout="published", fov_deg=60.0))
    config = called[0]["config"]
    assert called[0]["planner"] == planner
    assert (config.rollout, config.fov_deg, config.max_steps) == ("published", 60.0, 1)


def test_only_several_workers_have_it_made_before(monkeypatch, tmp_path):
    made = []
    monkeypatch.setattr("sloop_ppl.eval._sweep.compile_ahead", made.append)
    sweep_files(request(tmp_path, out=tmp_path / "one", workers=1))
    assert made == []
    sweep = request(tmp_path, out=tmp_path / "two", workers=2)
    sweep_files(sweep)
    sweep_files(sweep)  # nothing is left to do
    assert made == [sweep.searching]
