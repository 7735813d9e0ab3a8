"""A posterior of a model with parameters of its own is saved, read and told more."""

from __future__ import annotations

import pytest

from sloop_ppl.cli.app import main


def run(capsys, *argv):
    with pytest.raises(SystemExit) as done:
        main([str(a) for a in argv])
    out, err = capsys.readouterr()
    assert done.value.code == 0, err
    return out


def test_a_search_takes_a_posterior_with_parameters(tmp_path, capsys):
    (tmp_path / "f.toml").write_text("[model]\nlapse = 0.1\n[frames]\nkappa = 2\n")
    saved = tmp_path / "p.nc"
    text = "the green toyota is behind velvet dog"
    run(
        capsys, "infer", text, "--map", "cleveland", "--params", tmp_path / "f.toml", "--out", saved
    )
    first = run(capsys, "search", "--posterior", saved, "--planner", "greedy", "--json")
    more = run(
        capsys, "search", "it is near ivy", "--posterior", saved, "--planner", "greedy", "--json"
    )
    assert first != more
