"""The Python of docs/search.md runs as it stands, and its pages are as short as they should be."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "search.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
SECTIONS = ("Your own planner", "Your own sensor", "Your own motion", "Your own environment")


def section(title):
    return PAGE.split(f"\n## {title}\n", 1)[1].split("\n## ", 1)[0]


@pytest.mark.parametrize("title", SECTIONS)
def test_what_one_brings_takes_at_most_forty_lines(title):
    (longest, *_) = sorted(
        re.findall(r"```python\n(.*?)```", section(title), re.DOTALL), key=len, reverse=True
    )
    assert len([line for line in longest.splitlines() if line.strip()]) <= 40


def test_the_page_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    names: dict[str, object] = {}
    try:
        for code in BLOCKS:
            file = re.match(r"# (\w+\.py)\n", code)
            if file:
                (tmp_path / file[1]).write_text(code)
            elif "gymnasium" not in code:
                exec(compile(code, "docs/search.md", "exec"), names)
    finally:
        for module in ("nearest", "sensors", "windy"):
            sys.modules.pop(module, None)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("True ")
    assert lines[1].startswith("Nearest ")
    assert [line.split()[:2] for line in lines[2:4]] == [["Disk", "True"], ["Radio", "True"]]
    assert lines[4].startswith("True ")
    assert lines[5].startswith("True ")
    assert names["episode"].poses[1].x_m % 5 != 2.5
