"""The report: tables from trials made by hand, and the files it writes."""

import json
from pathlib import Path

import numpy as np
import pytest
from support.small_sweeps import request

from sloop_ppl.cli import main
from sloop_ppl.errors import InputError
from sloop_ppl.eval._facts import RelationFacts, TargetFacts
from sloop_ppl.eval._paper_tables import frame_table, table_one, table_two
from sloop_ppl.eval._report import make_report, write_docs, write_report
from sloop_ppl.eval._reward_tables import (
    comparison_table,
    completed_table,
    reward_table,
    sweeps_table,
)
from sloop_ppl.eval._run_folder import RunFolder
from sloop_ppl.eval._summary import in_short
from sloop_ppl.eval._sweep_files import sweep_files
from sloop_ppl.eval._tables import Estimate
from sloop_ppl.eval.results import Results, read_results
from sloop_ppl.eval.trials import Searching, Trial, TrialKey

MANIFEST = {
    "relations": "gold",
    "cv": None,
    "model_names": ["sloop", "bayes"],
    "ranges_cells": [3.0],
    "starts": 1,
    "searching": vars(Searching()),
    "primary": {"models": ["bayes", "sloop"], "range_cells": 3.0},
    "descriptions": {"a": "1"},
    "maps": {"m": "2"},
}


def near(good=None):
    return RelationFacts("near", "proximity", ("A",), False, good)


def front(good):
    return RelationFacts("front", "front", ("A",), False, good)


def results(said, rewards, steps=10, **changes):
    """Return a sweep of one target per list of relations; rewards are by model and target."""
    facts = tuple(
        TargetFacts(f"d{i}", "T", "m", f"c{i}", tuple(told)) for i, told in enumerate(said)
    )
    trials = tuple(
        Trial(
            TrialKey(f"d{i}", "T", model, 3.0, 0), "m", f"c{i}", reward > 0, steps + i, reward,
            reward, (0.0, 0.0), 0.1,
        )
        for model, values in rewards.items()
        for i, reward in enumerate(values)
    )  # fmt: skip
    return Results(RunFolder(Path("run"), {**MANIFEST, **changes}, facts), trials)


def row(table, name):
    (found,) = [cells for cells in table.rows if cells[0] == name]
    return found[1:]


@pytest.fixture
def seven():
    said = [[near()]] * 4 + [[near(), front(True)], [front(False), near()], [front(True)] * 1]
    return results(said, {"sloop": [10, 20, 30, 40, 50, 60, 70], "bayes": [100] * 7})


def test_table_one_counts_a_target_once_per_preposition(seven):
    table = table_one(seven)
    assert row(table, "near")[0] == 6
    assert row(table, "front")[0] == 3
    near_sloop = row(table, "near")[1]
    assert near_sloop.mean == 35
    half = 2.570582 * np.std([10, 20, 30, 40, 50, 60], ddof=1) / np.sqrt(6)
    assert near_sloop.high == pytest.approx(35 + half, abs=1e-4)
    assert row(table, "front")[1] == Estimate(
        60.0, pytest.approx(np.nan, nan_ok=True), pytest.approx(np.nan, nan_ok=True)
    )
    assert row(table, "front, good")[0] == 2
    assert row(table, "front, bad")[1].mean == 60


def test_table_two_and_the_paper_s_beside(seven):
    table = table_two(seven)
    one, two = row(table, "1"), row(table, "2")
    assert (one[0], one[1].mean, two[0], two[1].mean) == (5, 34, 2, 55)
    assert table.head[-2:] == ("paper: n", "paper: SLOOP")
    assert (one[-2:], two[-2:]) == ((100, 321.0), (83, 264.0))
    assert row(table, "all")[-1] == 282.0  # as its rows weigh


def test_frames_split_trials_in_three(seven):
    table = frame_table(seven)
    told = {cells[0]: (cells[1], cells[2].mean) for cells in table.rows}
    assert told == {
        "all frame relations good": (2, 60),
        "some frame relation bad": (1, 60),
        "no frame relation": (4, 25),
    }


def test_the_primary_comparison_is_not_corrected(seven):
    primary, *rest = comparison_table(seven).rows
    assert primary[0] == "primary: bayes − sloop"
    assert primary[2].mean == 60
    assert primary[3] == f"{2 / 2**7:.4f}"  # only all signs as they are, or all flipped
    assert primary[4] is None
    assert rest == []


def test_the_summary_ranks_models_and_names_the_primary_comparison(seven):
    scores = {
        "sloop": {"mean_log_score_1pct": -5.0, "ci95_1pct": [-5.5, -4.5]},
        "bayes": {"mean_log_score_1pct": -4.0, "ci95_1pct": [-4.5, -3.5]},
    }
    beliefs, searches, primary = in_short(seven, {"models": scores}).splitlines()
    assert beliefs.endswith("`bayes` −4.00 [−4.50, −3.50], `sloop` −5.00 [−5.50, −4.50].")
    assert searches.startswith("- Searches, by mean discounted reward at range 3: `bayes` 100 [")
    assert "`bayes` − `sloop` at range 3 is 60 [" in primary
    assert primary.endswith(f"p = {2 / 2**7:.4f}.")
    assert in_short(seven).splitlines() == [searches, primary]


def test_one_model_alone_is_compared_with_nothing(tmp_path):
    folder = sweep_files(request(tmp_path, models="sloop", ranges="3"))
    sweep = read_results(folder.path)
    made = make_report([sweep]).markdown("figures")
    assert "rimary" not in made
    assert "### Comparisons" not in made
    assert sweeps_table([sweep, sweep]).head == ("planner; relations; starts", "sloop")


def test_rewards_of_completed_searches_only():
    sweep = results([[near()]] * 4, {"sloop": [-200, 100, 300, -100], "bayes": [100] * 4})
    cells = row(reward_table(sweep), "sloop")
    assert (cells[0], cells[1].mean, cells[2], cells[3].mean) == (4, 25, 2, 200)
    assert row(completed_table(sweep), "sloop") == (0, 2, 2, 2, 2)  # in 11 and 12 steps
    assert row(completed_table(sweep), "bayes") == (1, 4, 4, 4, 4)


def test_starts_of_a_target_are_averaged():
    sweep = results([[near()], [near()]], {"sloop": [0, 100], "bayes": [0, 0]})
    more = [
        Trial(TrialKey("d0", "T", "sloop", 3.0, 1), "m", "c0", True, 5, 50.0, 50.0, (0, 0), 0.1)
    ]
    both = Results(sweep.folder, (*sweep.trials, *more))
    assert both.rewards("sloop", 3.0) == {("d0", "T"): 25.0, ("d1", "T"): 100.0}


def test_sweeps_beside_each_other_are_of_the_same_descriptions(seven):
    other = results([[near()]], {"bayes": [7]}, model_names=["bayes"], relations="parsed")
    table = sweeps_table([seven, other])
    assert table.head[1:] == ("sloop", "bayes", "bayes − sloop")
    assert [cell and cell.mean for cell in table.rows[0][1:]] == [40, 100, 60]
    assert [cell and cell.mean for cell in table.rows[1][1:]] == [None, 7, None]
    assert table.rows[1][0] == "fast 1000; parsed relations; 1 start"
    with pytest.raises(InputError, match="are of different maps; expected sweeps of the same"):
        sweeps_table([seven, results([[near()]], {"bayes": [7]}, maps={"m": "3"})])


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    return sweep_files(request(folder, models="sloop-m4,bayes", ranges="3"))


@pytest.fixture(scope="module")
def quality(tmp_path_factory, run):
    from sloop_ppl.eval._quality_files import score_quality

    path = tmp_path_factory.mktemp("quality") / "quality.json"
    told = score_quality([run.path.parent / "said.jsonl"], models="sloop-m4,bayes")
    path.write_text(json.dumps(told.to_json()))
    return path


@pytest.mark.slow
def test_the_report_is_written_whole(run, quality, tmp_path):
    made = make_report([read_results(run.path)], quality=quality)
    text = write_report(made, tmp_path / "report").read_text()
    home = tmp_path / "report"
    for name in ("overview", "table1", "table2", "comparisons", "quality", "quality-calibration"):
        assert (home / "tables" / f"{name}.csv").read_text().count("\n") > 1
        assert (home / "tables" / f"{name}.tex").read_text().startswith("\\begin{table}")
    pictures = ("quality", "completed", "rewards", "example-best", "example-worst")
    for name in pictures:
        assert f"(figures/{name}.png)" in text
        assert (home / "figures" / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    page = (home / "report.html").read_text()
    assert page.count("<table>") == text.count("\n| --- |")
    assert "Paired differences of discounted reward" in page
    file = tmp_path / "results.md"
    write_docs(made, file)
    assert file.read_text() == text.replace("(figures/", "(images/results/")
    assert (tmp_path / "images" / "results" / "rewards.png").is_file()


def test_the_command_prints_the_agreed_keys(run, capsys):
    with pytest.raises(SystemExit) as done:
        main(["eval", "report", str(run.path), "--json"])
    assert done.value.code == 0
    told = json.loads(capsys.readouterr().out)
    assert list(told) == ["relations", "planner", "models"]
    assert told["planner"] == "fast"
    assert told["models"]["bayes"]["3"]["n"] == 3


def test_no_run_and_no_quality(run, tmp_path):
    with pytest.raises(InputError, match=r"cannot be read: No such file .*; expected a folder"):
        read_results(tmp_path)
    bad = tmp_path / "q.json"
    bad.write_text("{}")
    with pytest.raises(InputError, match="is not what `sloop eval quality --json` prints"):
        make_report([read_results(run.path)], quality=bad)
