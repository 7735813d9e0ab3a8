"""The README's Python runs as it stands."""

from __future__ import annotations

import re
from pathlib import Path

import matplotlib
import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_the_python_in_the_readme_runs(tmp_path, monkeypatch, capsys):
    (code,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    monkeypatch.chdir(tmp_path)
    matplotlib.use("agg")
    exec(compile(code, "README.md", "exec"), {})
    assert (tmp_path / "belief.png").stat().st_size > 10_000
    assert "find" in capsys.readouterr().out


def test_every_link_in_the_readme_leads_somewhere():
    links = re.findall(r"\]\((?!http)([^)]+)\)", (ROOT / "README.md").read_text())
    assert links
    for file, _, heading in (link.partition("#") for link in links):
        assert (ROOT / file).exists()
        if heading:
            lines = (ROOT / file).read_text().splitlines()
            titles = [line.lstrip("# ") for line in lines if line.startswith("#")]
            assert heading in [re.sub(r"[^\w-]", "", t.lower().replace(" ", "-")) for t in titles]
