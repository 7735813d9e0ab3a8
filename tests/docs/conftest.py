"""Running the Python of a page, whatever files it writes first."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib
import pytest


@pytest.fixture
def run_page(tmp_path, monkeypatch) -> Callable[[Path], dict[str, object]]:
    """Return a function that runs a page's Python in an empty folder and returns its names.

    A block that begins with the comment ``# name.py`` is what one puts into a file of that name.
    One after a comment ``<!-- not run: ... -->`` needs what a test has not.
    """
    matplotlib.use("agg")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    before = set(sys.modules)

    def run(page: Path) -> dict[str, object]:
        names: dict[str, object] = {"__name__": "page"}
        monkeypatch.setitem(sys.modules, "page", type(sys)("page"))  # dataclasses look it up
        text = page.read_text(encoding="utf-8")
        text = re.sub(r"<!-- not run: [^\n]+ -->\n```python\n.*?```", "", text, flags=re.DOTALL)
        blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
        assert blocks
        for number, code in enumerate(blocks):
            file = re.match(r"# (\w+\.py)\n", code)
            if file:
                (tmp_path / file[1]).write_text(code, encoding="utf-8")
            else:
                exec(compile(code, f"{page.name}, block {number}", "exec"), names)
        return names

    yield run
    for name in set(sys.modules) - before:
        if str(getattr(sys.modules[name], "__file__", None)).startswith(str(tmp_path)):
            del sys.modules[name]
