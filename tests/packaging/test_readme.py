"""The README's Python runs as it stands."""

from __future__ import annotations

import re
import tomllib
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


REPOSITORY = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["urls"]["Source"]
SOURCES = (
    f"{REPOSITORY}/blob/main/",
    f"{REPOSITORY}/main/".replace("github.com", "raw.githubusercontent.com"),
)


def test_every_link_in_the_readme_leads_somewhere():
    text = (ROOT / "README.md").read_text()
    links = re.findall(r"\]\(([^)\s]+)\)|^\[[^\]]+\]: (\S+)$", text, re.MULTILINE)
    links = [one or other for one, other in links]
    assert [link for link in links if not link.startswith("https://")] == []  # for package indexes
    ours = [link for link in links if "sloop-ppl" in link]
    assert len(ours) > 20
    for link in ours:
        (source,) = [s for s in SOURCES if link.startswith(s)]
        file, _, heading = link.removeprefix(source).partition("#")
        assert (ROOT / file).exists(), link
        if heading:
            lines = (ROOT / file).read_text().splitlines()
            titles = [line.lstrip("# ") for line in lines if line.startswith("#")]
            assert heading in [re.sub(r"[^\w-]", "", t.lower().replace(" ", "-")) for t in titles]


def test_every_link_by_name_in_the_readme_is_defined_and_used():
    text = (ROOT / "README.md").read_text()
    prose = re.sub(r"```.*?```", "", text, flags=re.DOTALL)
    defined = set(re.findall(r"^\[([^\]]+)\]: ", prose, re.MULTILINE))
    prose = re.sub(r"^\[[^\]]+\]: .*$", "", prose, flags=re.MULTILINE)
    used = set(re.findall(r"\]\[([^\]]+)\]", prose))
    used |= set(re.findall(r"(?<!\])\[([^\]]+)\](?![(\[])", prose))
    assert used == defined
