"""The Python of docs/performance.md runs as it stands."""

from __future__ import annotations

import re
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "performance.md"


def test_the_page_runs(capsys):
    names: dict[str, object] = {}
    text = PAGE.read_text(encoding="utf-8")
    for number, code in enumerate(re.findall(r"```python\n(.*?)```", text, re.DOTALL)):
        exec(compile(code, f"{PAGE.name}, block {number}", "exec"), names)
    out = capsys.readouterr().out
    assert "RefinedPosterior('cleveland', GreenToyota: 41 x 41 cells" in out
    assert "2 done" in out
    assert "0 ['RedBike']" in out


def test_the_commands_of_the_page_are_there():
    scripts = re.findall(r"benchmarks/(\w+\.py)", PAGE.read_text(encoding="utf-8"))
    assert scripts
    assert [s for s in scripts if not (PAGE.parents[1] / "benchmarks" / s).exists()] == []
