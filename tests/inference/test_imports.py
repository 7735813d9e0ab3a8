"""The modules of inference import one another one way, those for types and in functions too."""

from __future__ import annotations

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import sloop_ppl.inference
import sloop_ppl.models

ROOMS = {
    "sloop_ppl.inference": Path(sloop_ppl.inference.__file__).parent,
    "sloop_ppl.models": Path(sloop_ppl.models.__file__).parent,
}


def imported(path: Path, room: str, known: set[str]) -> set[str]:
    """The modules of a room that a file names in any import, wherever it stands in the file."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        found |= {name for name in names if name in known and name != room}
    return found


def graph(room: str) -> dict[str, set[str]]:
    folder = ROOMS[room]
    modules = {}
    for path in sorted(folder.rglob("*.py")):
        parts = path.relative_to(folder).with_suffix("").parts
        name = ".".join((room, *(p for p in parts if p != "__init__")))
        modules[name] = path
    del modules[room]  # what re-exports them all
    return {name: imported(path, room, set(modules)) - {name} for name, path in modules.items()}


@pytest.mark.parametrize("room", ROOMS)
def test_there_is_no_circle(room):
    edges = graph(room)
    if room == "sloop_ppl.models":  # packages re-export what their own modules define
        packages = {"sloop_ppl.models.frames", "sloop_ppl.models.likelihoods"}
        edges = {
            name: {n for n in others if not (n in packages and name.startswith(n))}
            for name, others in edges.items()
        }
    try:
        TopologicalSorter(edges).prepare()
    except CycleError as error:
        pytest.fail(f"modules of {room} import in a circle: {' -> '.join(error.args[1])}")


def test_a_circle_would_be_found(tmp_path):
    """The walk sees imports for types and inside functions."""
    path = tmp_path / "a.py"
    path.write_text(
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from r.b import B\n"
        "def f():\n    import r.c\n"
    )
    assert imported(path, "r", {"r.b", "r.c", "r.d"}) == {"r.b", "r.c"}
