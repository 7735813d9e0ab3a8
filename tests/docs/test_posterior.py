"""The Python of docs/posterior.md runs as it stands, and what the page says is so."""

from __future__ import annotations

import re
from pathlib import Path

import matplotlib
import pytest

PAGE = Path(__file__).parents[2] / "docs" / "posterior.md"


@pytest.mark.slow
def test_the_page_runs_and_says_what_is_so(tmp_path, monkeypatch, capsys):
    matplotlib.use("agg")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for number, code in enumerate(re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)):
        exec(compile(code, f"{PAGE.name}, block {number}", "exec"), names)
    out = capsys.readouterr().out
    assert (tmp_path / "sheet.png").stat().st_size > 50_000
    assert "cannot be ranked" in out
    assert "| exact | 0.0e+00 |" in out
    slips = dict(re.findall(r"(\w+) \('\w+',\) 0\.10 -> ([\d.]+)", out))
    page = " ".join(PAGE.read_text().split())
    wrong, near, west = re.search(
        r"probability (\.\d\d) and .* with (\.\d\d) and (\.\d\d),", page
    ).groups()
    assert [slips[w] for w in ("on", "near", "west")] == [f"0{p}" for p in (wrong, near, west)]
    after, before = re.search(r"found, (\.\d\d) of .* it \((\.\d\d) before\)", page).groups()
    assert re.findall(r"(0\.\d\d) within 15 m of there", out) == [f"0{before}", f"0{after}"]
    assert (tmp_path / "words.png").stat().st_size > 10_000
    ranks = dict(re.findall(r"^(\w+) (\d+) 0\.\d\d$", out, re.MULTILINE))
    assert ranks == {"near": "1", "west": "11", "on": "11"}
    assert "4.86 nats of one speaker, 4.64 of two" in out
    trusted = dict(re.findall(r"(\w+) is reliable: (0\.\d\d)", out))
    assert float(trusted["Ann"]) > float(trusted["Bo"]) > float(trusted["Cy"])


def test_every_picture_of_the_page_is_there():
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", PAGE.read_text())
    assert len(pictures) == 4
    assert [p for p in pictures if not (PAGE.parent / p).exists()] == []
