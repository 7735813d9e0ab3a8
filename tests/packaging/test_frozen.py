"""Data are frozen: nobody changes a result, a settings record or a map behind another's back."""

import ast

from support.tree import ROOTS


def dataclasses():
    """Return the name of each public dataclass of a module but the readers' -> is it frozen."""
    found = {}
    for folder in ROOTS.values():
        for path in sorted(folder.rglob("*.py")):
            if path.parent.name in ("language", "osm"):  # readers keep notes as they go
                continue
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                    marks = [ast.unparse(mark) for mark in node.decorator_list]
                    for mark in marks:
                        if mark.startswith("dataclass"):
                            found[node.name] = "frozen=True" in mark
    return found


def test_public_dataclasses_are_frozen():
    found = dataclasses()
    assert len(found) > 100
    assert [name for name, frozen in found.items() if not frozen] == []
