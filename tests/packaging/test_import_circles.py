"""No modules import one another in a circle; imports for typing and inside functions count.

A package's face, its ``__init__``, imports its modules for others and is left out.
"""

from __future__ import annotations

import ast
from graphlib import CycleError, TopologicalSorter

from support.tree import ROOTS


def sources():
    """Return the name of each module of ours -> its source file."""
    names = {}
    for package, folder in ROOTS.items():
        for path in sorted(folder.rglob("*.py")):
            parts = path.relative_to(folder).with_suffix("").parts
            parts = parts[:-1] if parts[-1] == "__init__" else parts
            names[".".join((package, *parts))] = path
    return names


def imported(path, names):
    """Return the modules of ours that a file imports, wherever in it."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                found.add(whole if whole in names else node.module)
        elif isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
    return found & names.keys()


def test_no_modules_import_one_another():
    names = sources()
    assert len(names) > 200
    modules = {n for n, path in names.items() if path.name != "__init__.py"}
    graph = {name: imported(names[name], names) & modules - {name} for name in modules}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        raise AssertionError(f"a circle of imports: {' -> '.join(error.args[1])}") from None
