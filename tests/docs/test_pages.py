"""The Python of the pages of the site runs as it stands, and their commands have such options."""

from __future__ import annotations

import ast
import re
import shlex
from types import SimpleNamespace

import numpy as np
import pytest
from support.tree import ROOT
from typer.main import get_command

import sloop_ppl as sloop
from sloop_ppl.cli.app import app
from sloop_ppl.eval import METRICS
from sloop_ppl.language import RELATIONS

DOCS = ROOT / "docs"
HOW_TO = sorted(path for path in (DOCS / "howto").glob("*.md") if path.stem != "index")
PAGES = [*HOW_TO, *(DOCS / f"{name}.md" for name in ("index", "concepts", "installing"))]


def test_each_thing_one_brings_has_a_page():
    table = (DOCS / "howto" / "index.md").read_text()
    for path in HOW_TO:
        assert f"({path.name})" in table
        assert path.read_text().startswith("# ")
    assert len(HOW_TO) == 9


@pytest.fixture
def printed(run_page, capsys):
    def run(name):
        names = run_page(DOCS / f"{name}.md")
        return names, capsys.readouterr().out.splitlines()

    return run


def test_the_home_page_runs(printed):
    names, lines = printed("index")
    assert names["run"].found
    assert lines[0].endswith(" (41, 41)")


def test_the_concepts_run(printed):
    names, lines = printed("concepts")
    assert lines[0] == "GreenToyota behind ('VelvetDog',) ()"
    assert any(re.fullmatch(r"\d\.\d\d bits: .*\?", line) for line in lines)
    assert len(names["post"].texts) == 1


def test_a_surveyed_front_turns_the_belief(printed):
    _, lines = printed("howto/frame_prior")
    one, other = (ast.literal_eval(line.split(" ", 1)[1]) for line in lines)
    assert one[0] < other[0] - 15  # behind is the other side
    assert one[1] < other[1]


def test_an_engine_of_several_runs_is_close_to_the_exact_one(printed):
    _, (line,) = printed("howto/engine")
    assert float(line.rsplit(" ", 1)[1]) < 0.03


def test_the_patient_planner_loses(printed):
    _, lines = printed("howto/planner")
    returns = {line.split()[0]: float(line.split()[-1]) for line in lines}
    assert returns["Patient"] < min(returns["greedy"], returns["fast"])


def test_a_ring_finds_the_car(printed):
    _, (line,) = printed("howto/sensor")
    assert line.startswith("True ")


def test_the_environment_counts_what_was_done(printed):
    names, _ = printed("howto/environment")
    assert sum(names["world"].counts.values()) == names["episode"].steps
    assert names["episode"].found


def test_the_yard_is_read_and_believed(printed):
    try:
        names, lines = printed("howto/relation")
    finally:
        RELATIONS.remove("in the yard of")
    assert lines[0] == "in the yard of BoltonPrattBuilding"
    city, belief = names["post"].city, names["post"].belief("RedBike")
    off_m = city.fields("BoltonPrattBuilding").distance_m
    assert belief[off_m <= 20].sum() > 0.8
    assert belief[(off_m > 0) & (off_m <= 15)].mean() > belief[off_m == 0].mean()


def test_a_metric_is_measured_beside_the_others(printed):
    _, lines = printed("howto/metric")
    assert len(lines) == 2
    assert "chebyshev_m" not in METRICS


def test_a_profile_is_drawn_beside_a_belief(printed, tmp_path):
    printed("howto/plot")
    assert (tmp_path / "profile.png").stat().st_size > 30_000


def test_a_map_made_of_two_features_is_searched(printed):
    names, (line,) = printed("howto/map")
    assert line.startswith("CityMap('campus', 41 x 41 cells of 5 m, 2 landmarks)")
    assert names["post"].relations("RedBike")[0].ground == "OldLibrary"


def test_the_page_on_map_files_runs(printed, tmp_path):
    names, _ = printed("maps")
    assert names["city"].grid.shape == (41, 41)
    assert names["finer"].grid.shape == (81, 81)
    assert (tmp_path / "blocks.png").stat().st_size > 10_000


def test_the_page_on_description_files_runs(printed):
    names, (line,) = printed("descriptions")
    assert line.startswith("The red bike is near Ivy. ")
    assert names["description"].targets["RedBike"].x_m == 2.5
    assert len(names["examples"]) == 32


def test_the_page_on_evaluation_has_a_metric_that_measures(tmp_path, monkeypatch):
    text = (DOCS / "evaluation.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(# mine\.py\n.*?)```", text, re.DOTALL)
    (writing,) = re.findall(r"```python\n(from importlib.*?)```", text, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    exec(writing, {})
    assert len((tmp_path / "said.jsonl").read_text("utf-8").splitlines()) == 32
    names = {}
    exec(code, names)
    grid = sloop.load_map("cleveland").grid
    belief = np.zeros(grid.shape)
    belief[grid.cell_at(12.5, -7.5)] = 1
    truth = SimpleNamespace(x_m=2.5, y_m=2.5, cell=grid.cell_at(2.5, 2.5), area=None)
    assert names["median_walk_m"](belief, grid, truth) == 20


def test_the_page_on_reading_runs(printed):
    pytest.importorskip("spacy", reason="the pipeline needs pip install 'sloop-ppl[spacy]'")
    try:
        names, _ = printed("language")
    finally:
        RELATIONS.remove("kitty-corner")
    assert [(r.relation, r.ground) for r in names["said"].relations] == [("behind", "Ivy")]
    assert {u.status for u in names["said"].unresolved} == {"retracted", "asked"}
    (read,) = names["doc"]._.spatial_relations
    assert (read.relation, read.ground) == ("behind", "VelvetDog")


def test_every_page_with_python_is_run_by_a_test():
    tests = "\n".join(path.read_text() for path in (ROOT / "tests" / "docs").glob("test_*.py"))
    for page in DOCS.rglob("*.md"):
        made = page.parent.name == "tutorials" or page.stem == "gallery"  # of code that is run
        if "```python" in page.read_text(encoding="utf-8") and not made:
            named = page.relative_to(DOCS).with_suffix("").as_posix()
            assert f'"{named}"' in tests or f'"{page.name}"' in tests or f"{page.name}" in tests


def commands():
    texts = [page.read_text(encoding="utf-8") for page in PAGES]
    blocks = [block for text in texts for block in re.findall(r"```\n(.*?)```", text, re.DOTALL)]
    lines = {line.partition(" #")[0] for block in blocks for line in block.splitlines()}
    return sorted(line for line in lines if line.startswith("sloop "))


@pytest.mark.parametrize("line", commands())
def test_every_option_of_a_command_is_known(line):
    command, rest = get_command(app), shlex.split(line)[1:]
    while hasattr(command, "commands"):
        command, rest = command.commands[rest[0]], rest[1:]
    known = {name for parameter in command.params for name in parameter.opts}
    assert {word for word in rest if word.startswith("--")} <= known
