"""The picture and the Python of docs/models.md show what the page says."""

import importlib.util
import inspect
import re
from dataclasses import replace
from pathlib import Path

import pytest

import sloop_ppl as sloop
from sloop_ppl.inference import ParameterDraws
from sloop_ppl.models.program import generative_model, log_phrase
from sloop_ppl.models.simulation import SPEAKER
from sloop_ppl.models.tuning import load_parameters, with_parameters

ROOT = Path(__file__).parents[2]


def test_one_sentence_under_three_models(tmp_path):
    path = ROOT / "examples" / "paper_code_ours.py"
    spec = importlib.util.spec_from_file_location("example_paper_code_ours", path)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    beliefs = example.main(tmp_path / "a.png")
    text, code, ours = beliefs.values()
    assert (tmp_path / "a.png").stat().st_size > 10_000
    assert 0.5 * abs(text - code).sum() > 0.2
    assert 0.5 * abs(ours - code).sum() > 0.2
    said = sloop.parse(example.TEXT, city := sloop.load_map("cleveland"))
    turned = sloop.parse(example.TEXT.replace("behind", "in front of"), city)
    apart = {
        name: 0.5
        * abs(beliefs[name] - sloop.infer(turned, city, model).belief("GreenToyota")).sum()
        for name, model in example.MODELS.items()
    }
    assert apart["the paper's text"] < 1e-9
    assert min(apart["its published code"], apart["ours (bayes)"]) > 0.1
    assert said.relations != turned.relations


def test_a_listener_is_less_sure_than_untempered_and_surer_than_the_speaker(tmp_path):
    path = ROOT / "examples" / "listener_and_speaker.py"
    spec = importlib.util.spec_from_file_location("example_listener_and_speaker", path)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    listener, untempered, speaker = example.main(tmp_path / "a.png").values()
    assert (tmp_path / "a.png").stat().st_size > 10_000
    assert untempered < listener < speaker


def test_a_denied_phrase_has_the_belief_that_the_page_says(tmp_path):
    path = ROOT / "examples" / "denied_phrase.py"
    spec = importlib.util.spec_from_file_location("example_denied_phrase", path)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    asserted, denied = example.main(tmp_path / "a.png").values()
    assert (tmp_path / "a.png").stat().st_size > 10_000
    assert asserted > 0.8
    page = (ROOT / "docs" / "models.md").read_text()
    (row,) = re.findall(r'^\| "not near Ivy" \| (.*) \|$', page, re.MULTILINE)
    uniform, plain, scaled = map(float, row.split(" | "))
    assert denied == pytest.approx(scaled, abs=6e-5)
    city = sloop.load_map("cleveland")
    near = city.fields("Ivy").distance_m <= example.NEAR_M
    assert near.mean() == pytest.approx(uniform, abs=6e-5)
    certain = replace(example.MODEL, denial=1.0)  # "near" reaches 1, so this is 1 - g
    belief = sloop.infer(sloop.parse(example.TEXTS[1], city), city, certain).belief("RedBike")
    assert belief[near].sum() == pytest.approx(plain, abs=6e-5)


def test_every_picture_and_link_of_the_page_leads_somewhere():
    docs = ROOT / "docs"
    links = re.findall(r"\]\((?!http)([^)#]+)", (docs / "models.md").read_text())
    assert len(links) > 8
    assert [link for link in links if not (docs / link).exists()] == []


def test_every_line_of_the_table_of_equations_is_one_of_the_program():
    page = (ROOT / "docs" / "models.md").read_text()
    source = inspect.getsource(generative_model) + inspect.getsource(log_phrase)
    section = page.split("## The program")[1].split("### Readings and referents")[0]
    lines = re.findall(r"^\| .* \| `(.*)` \|$", section, re.MULTILINE)
    assert len(lines) == 16
    for line in lines:
        assert line in source, line


def test_the_plate_diagram_is_that_of_the_program(tmp_path):
    path = ROOT / "examples" / "program_graph.py"
    spec = importlib.util.spec_from_file_location("example_program_graph", path)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    graph = example.main(tmp_path / "program.dot")
    edges = set(re.findall(r'"GreenToyota/(\w+)" -> "GreenToyota/(\w+)"', graph.source))
    assert edges == {
        ("frame_0", "angle_0"),
        *((parent, "holds_0") for parent in ("component", "cell", "frame_0", "lapse_0")),
        *((parent, "holds_1") for parent in ("cell", "lapse_1")),
        *((parent, "temper") for parent in ("component", "cell")),
        ("component", "normaliser"),
    }
    heard = re.findall(r'(reading|ground_0) -> "GreenToyota/(\w+)"', graph.source)
    of_reading = ("holds_0", "holds_1", "temper", "normaliser")
    assert sorted(heard) == [("ground_0", "holds_1"), *(("reading", n) for n in sorted(of_reading))]
    assert "cluster_targets" in graph.source
    assert (ROOT / "docs" / "images" / "program.png").stat().st_size > 10_000


def test_the_program_fits_on_a_screen():
    """Of at most about sixty lines, its docstring apart."""
    lines = inspect.getsource(generative_model).splitlines()
    docstring = generative_model.__doc__.count("\n") + 1
    assert len(lines) - docstring <= 60


@pytest.mark.slow
def test_the_page_s_learning_runs_and_prints_what_it_shows(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "models.md").read_text()
    names: dict[str, object] = {}
    for number, code in enumerate(re.findall(r"```python\n(.*?)```", page, re.DOTALL)):
        exec(compile(code, f"models.md, block {number}", "exec"), names)
    out = capsys.readouterr().out
    shown = re.findall(r"```\n(near_m .*?)```", page, re.DOTALL)[0]
    for line in shown.splitlines():
        name, *numbers = line.replace(" to ", " ").split()
        (row,) = re.findall(rf"^{name} .*$", out, re.MULTILINE)[:1]
        told = [float(number) for number in row.replace(" to ", " ").split()[1:]]
        assert told == pytest.approx([float(number) for number in numbers], rel=0.1), name
    drawn = names["drawn"]
    rows = {row.name: row for row in drawn.summary}
    ann, bo = (rows[f"kappa_compass_by_speaker[{who}]"] for who in ("Ann", "Bo"))
    assert ann.low < 1.2 < ann.high < bo.low < bo.high
    assert names["of_bo"].likelihood.kappa_compass == pytest.approx(bo.median)
    again = ParameterDraws.load(tmp_path / "drawn.json")
    assert again.parameters == drawn.parameters
    assert with_parameters(SPEAKER, load_parameters(tmp_path / "speaker.json")) != SPEAKER
