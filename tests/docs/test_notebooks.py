"""The notebooks run, their pages show their code, and each ends in something to look at."""

from __future__ import annotations

import importlib.util
import re
import sys

import pytest
from support.tree import ROOT

NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.py"))
_SPEC = importlib.util.spec_from_file_location(
    "site_tutorials", ROOT / "docs" / "site_tools" / "tutorials.py"
)
tutorials = importlib.util.module_from_spec(_SPEC)
sys.modules[_SPEC.name] = tutorials
_SPEC.loader.exec_module(tutorials)
NAMES = [path.stem for path in NOTEBOOKS]


def page(name):
    return (ROOT / "docs" / "tutorials" / f"{name}.md").read_text(encoding="utf-8")


def run(name, monkeypatch):
    monkeypatch.setenv("SLOOP_QUICK", "1")
    return list(
        tutorials.run_cells(tutorials.cells_of(ROOT / f"examples/notebooks/{name}.py"), name)
    )


def test_there_is_one_for_each_kind_of_user():
    assert NAMES == ["another_likelihood", "bring_a_domain", "look_into_a_posterior"]


def test_another_likelihood_scores_three_models(monkeypatch):
    done = run("another_likelihood", monkeypatch)
    printed = "".join(text for _, text, _ in done)
    assert printed.startswith("(41, 41) 1.0\n")
    scores = re.findall(r"^(.+?) +(-\d\.\d\d) \(.*n = \d+$", printed, re.MULTILINE)
    assert [name for name, _ in scores] == ["published", "published with Plateau", "bayes"]
    assert all(float(score) > -7.43 for _, score in scores)
    _ends_in_a_picture(done)


def test_looking_into_a_posterior_says_what_its_page_says(monkeypatch):
    done = run("look_into_a_posterior", monkeypatch)
    shown = re.findall(r"```text\n(.*?)\n```", page("look_into_a_posterior"), re.DOTALL)
    assert [text.rstrip() for _, text, _ in done if text] == shown
    assert sum(len(pictures) for *_, pictures in done) == 2
    _ends_in_a_picture(done)


def test_the_domain_finds_the_car_sooner_with_the_sentence(monkeypatch):
    done = run("bring_a_domain", monkeypatch)
    printed = "".join(text for _, text, _ in done)
    assert "the same: True" in printed
    moves = dict(re.findall(r"^(with|without) .*?(\d+) moves$", printed, re.MULTILINE))
    assert int(moves["with"]) < int(moves["without"])
    _ends_in_a_picture(done)


def _ends_in_a_picture(done):
    *_, pictures = [cells for cells in done if cells[0].is_code][-1]
    assert pictures
    assert len(pictures[-1]) > 30_000


@pytest.mark.parametrize("name", NAMES)
def test_the_page_has_the_notebook_s_cells_and_pictures(name):
    text = page(name)
    for cell in tutorials.cells_of(ROOT / "examples" / "notebooks" / f"{name}.py"):
        assert cell.text in text, "run make tutorials"
    for picture in re.findall(r"!\[.*?\]\((.*?)\)", text):
        assert (ROOT / "docs" / "tutorials" / picture).stat().st_size > 10_000


@pytest.mark.parametrize("name", NAMES)
def test_jupytext_reads_the_same_cells(name):
    jupytext = pytest.importorskip("jupytext", reason="jupytext is not installed")
    text = (ROOT / "examples" / "notebooks" / f"{name}.py").read_text(encoding="utf-8")
    book = jupytext.reads(text, fmt="py:percent")
    ours = tutorials.cells_of(ROOT / "examples" / "notebooks" / f"{name}.py")
    assert [cell.cell_type == "code" for cell in book.cells] == [cell.is_code for cell in ours]
    assert [cell.source.strip() for cell in book.cells] == [cell.text for cell in ours]
    assert book.metadata["kernelspec"]["name"] == "python3"
