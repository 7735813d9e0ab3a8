"""`--prior` takes a name or a file, and `sloop list priors` says the names."""

from __future__ import annotations

import pytest

import sloop_ppl as sloop
from sloop_ppl.cli.app import main
from sloop_ppl.models import learn_cells

INFER = ["infer", "the green toyota is near velvet dog", "--map", "cleveland"]


def run(capsys, *argv):
    with pytest.raises(SystemExit) as done:
        main([str(a) for a in argv])
    out, err = capsys.readouterr()
    return done.value.code, out, err


def test_a_named_prior_moves_the_belief(capsys):
    _, flat, _ = run(capsys, *INFER, "--json")
    code, named, _ = run(capsys, *INFER, "--prior", "streets", "--json")
    assert code == 0
    assert named != flat
    assert flat == run(capsys, *INFER, "--prior", "uniform", "--json")[1]


def test_a_search_starts_from_a_named_prior(capsys):
    search = ["search", *INFER[1:], "--planner", "greedy", "--steps", "4", "--json"]
    code, flat, _ = run(capsys, *search)
    assert code == 0
    assert run(capsys, *search, "--prior", "uniform")[:2] == (0, flat)
    assert run(capsys, *search, "--prior", "streets")[1] != flat
    code, _, err = run(capsys, *search, "--prior", "streats")
    assert (code, err.count("\n")) == (2, 1)
    assert "did you mean 'streets'?" in err


def test_a_learnt_prior_is_a_file(tmp_path, capsys):
    city = sloop.load_map("cleveland")
    learn_cells([(city, (0.0, 0.0))]).save(tmp_path / "cells.json")
    assert run(capsys, *INFER, "--prior", tmp_path / "cells.json", "--json")[0] == 0


def test_a_wrong_name_is_one_line(capsys):
    code, out, err = run(capsys, *INFER, "--prior", "streats")
    assert (code, out) == (2, "")
    assert "did you mean 'streets'?" in err
    assert err.count("\n") == 1


def test_priors_are_listed(capsys):
    assert run(capsys, "list", "priors")[1].split() == [
        "uniform",
        "streets",
        "off-streets",
    ]
