"""The Python of docs/asking.md runs as it stands: the program finds that it misread a sentence."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "asking.md"


def shares(out, words):
    """Return what the page printed of the bar behind some words."""
    return ast.literal_eval(next(re.finditer(rf"{words}: (\{{.*?\}})", out))[1])


def test_the_page_runs_and_says_what_is_so(capsys):
    names: dict[str, object] = {}
    for number, code in enumerate(re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)):
        exec(compile(code, f"{PAGE.name}, block {number}", "exec"), names)
    out = capsys.readouterr().out
    assert "read as: ('Ivy',)" in out
    read, turned, last = (shares(out, f"the bar{w}") for w in ("", " now", " at last"))
    assert read["Ivy"] >= read["BarleyHouse"] > 0.2
    assert turned["BarleyHouse"] > 0.6 > 0.3 > turned["Ivy"]
    assert last["BarleyHouse"] > 0.9
    nats = [float(n) for n in re.search(r"([\d.]+), ([\d.]+), ([\d.]+) nats", out).groups()]
    assert nats == sorted(nats, reverse=True)
    doubts = dict(re.findall(r"^(.+) (0\.\d+)$", out, re.MULTILINE))
    # One of two that contradict each other is wrong; what else was said is for the first.
    cort, root = float(doubts["the Cort one"]), float(doubts["Root-McBride"])
    assert cort > 0.8 > 0.55 > root
    assert out.count("after 0 steps: ") == 2
    asking, silent = map(int, re.search(r"(-?\d+) with asking, (-?\d+) without", out).groups())
    assert asking > silent


def test_what_the_page_says_of_the_numbers_is_so():
    from sloop_ppl.bridge.asking import AnswererModel, list_question_kinds
    from sloop_ppl.bridge.asking.candidates import MOST_CELLS
    from sloop_ppl.planning._ask_value import FINAL_SIMS, SHORTLIST, SHORTLIST_SIMS

    text = " ".join(PAGE.read_text().split())
    person = AnswererModel()
    for words in (
        f"`error` ({person.error:g}:",
        f"`dont_know` ({person.dont_know:g} about",
        f"(`angle_deg`, {person.angle_deg:g})",
        f"(`distance_share`, {person.distance_share:g})",
        f"`other_geometry` ({person.other_geometry:g})",
        f"more than {MOST_CELLS:,} cells",
        f"with {SHORTLIST_SIMS} simulations an answer",
        f"anew with {FINAL_SIMS}",
        {4: "the most informative four questions"}[SHORTLIST],
    ):
        assert words in text
    kinds = re.search(r"`sloop list questions`: (.*?)\. One of your own", text)[1]
    assert re.findall(r"`(\w+)` \(", kinds) == list_question_kinds()


@pytest.mark.parametrize("picture", re.findall(r"!\[.*?\]\((.*?)\)", PAGE.read_text()))
def test_the_pictures_are_there(picture):
    assert (PAGE.parent / picture).stat().st_size > 50_000
