"""The Python of docs/planning_with_language.md runs as it stands and says what the page says."""

from __future__ import annotations

import re
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "planning_with_language.md"


def test_the_page_runs(capsys):
    names: dict[str, object] = {}
    for number, code in enumerate(re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)):
        exec(compile(code, f"{PAGE.name}, block {number}", "exec"), names)
    lines = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r"True \d+ VelvetDog", lines[0])
    assert lines[1] == "('The green Toyota is behind Velvet Dog.', 'It is close to Velvet Dog.')"
    assert lines[2].startswith("{'product': ")
    assert lines[3:] == ["3 True True", "True"]
