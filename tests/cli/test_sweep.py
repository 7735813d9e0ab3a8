"""`sloop eval search` and `sloop eval report` on the command line."""

import json

import pytest
from support.small_sweeps import LINES, write_lines

from sloop_ppl.cli import main

SHORT = (
    "--models", "uniform,sloop", "--ranges", "3", "--sims", "20", "--steps", "5",
    "--rollout", "published", "--workers", "1",
)  # fmt: skip


def run(capsys, code, *arguments):
    with pytest.raises(SystemExit) as done:
        main(["eval", *(str(a) for a in arguments)])
    out, err = capsys.readouterr()
    assert done.value.code == code, err
    return out, err


def refused(capsys, *arguments):
    """Run a command that must be refused; return the one line it says."""
    out, err = run(capsys, 2, *arguments)
    assert out == ""
    assert err.count("\n") == 1, err
    return err


def test_search_and_report(capsys, tmp_path):
    file, folder = write_lines(tmp_path / "said.jsonl"), tmp_path / "run"
    out, err = run(capsys, 0, "search", file, "--out", folder, *SHORT)
    assert out == f"6 trials in {folder}; see `sloop eval report {folder}`\n"
    assert err.splitlines()[0] == "0 of 6 trials"
    assert err.splitlines()[-1] == "6 of 6 trials, 0 s left"
    out, _ = run(capsys, 0, "report", folder, "--json")
    assert json.loads(out)["models"]["sloop"]["3"]["n"] == 3
    told = refused(capsys, "search", file, "--out", folder, *SHORT, "--seed", "1")
    assert "holds another sweep: searching.seed was 0 and is 1. Choose another folder" in told


def test_settings_of_simulations_are_said_to_go_unused(capsys, tmp_path):
    file = write_lines(tmp_path / "said.jsonl")
    _, err = run(
        capsys, 0, "search", file, "--out", tmp_path / "run", *SHORT, "--planner", "greedy"
    )
    assert err.splitlines()[-2:] == [
        f"note: planner 'greedy' runs no simulations, so --{name} is not used"
        for name in ("sims", "rollout")
    ]


def test_mistakes_are_one_line(capsys, tmp_path):
    bad = write_lines(tmp_path / "bad.jsonl", LINES[0] | {"map": "atlantis"}, LINES[1])
    out = ("--out", tmp_path / "run")
    told = refused(capsys, "search", bad, *out, *SHORT)
    assert "bad.jsonl:1: field 'map' names no map" in told
    assert told.endswith("or pass over them with --skip-bad\n")
    assert "Missing option '--out'" in refused(capsys, "search", bad, *SHORT)
    assert "No such file" in refused(capsys, "search", tmp_path / "none.jsonl", *out, *SHORT)
    assert "expected a folder that" in refused(capsys, "report", tmp_path)
    assert not (tmp_path / "run").exists()
    _, err = run(capsys, 0, "search", bad, *out, *SHORT, "--skip-bad")
    assert "passed over" in err
