"""What docs and examples import is public: in the ``__all__`` of a room or of a part of it."""

from __future__ import annotations

import ast
import re
from importlib import import_module

import pytest
from support.tree import ROOT, package_names

# gymnasium imports it by this name, as its own registry wants it
ALLOWED = {("sloop_ppl.planning.gym_register", name) for name in ("ENVIRONMENT", "register")}

PAGES = sorted([*ROOT.glob("docs/**/*.md"), ROOT / "README.md", *ROOT.glob("examples/**/*.py")])


def imports(page):
    """Return (module, name) of each import of ours in a page's Python or an example."""
    text = page.read_text(encoding="utf-8")
    blocks = [text] if page.suffix == ".py" else re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    return {
        (node.module, alias.name)
        for block in blocks
        for node in ast.walk(ast.parse(block))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("sloop_ppl")
        for alias in node.names
    }


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_what_is_imported_is_public(page):
    for module, name in imports(page) - ALLOWED:
        assert module in package_names(), f"{page.name} imports {name} from the module {module}"
        assert name in import_module(module).__all__, f"{name} is not in the __all__ of {module}"
