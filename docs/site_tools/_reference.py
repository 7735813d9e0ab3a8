"""The pages of the reference: a page per room, with every name of its ``__all__``."""

from __future__ import annotations

import inspect
from functools import cache
from importlib import import_module
from types import ModuleType
from typing import Any

import sloop_ppl

__all__ = ["REFERENCE", "page_of", "reference_pages"]

# Module -> page. Rooms first; then parts of rooms, with the names their room has not.
REFERENCE = {
    "sloop_ppl.maps": "maps",
    "sloop_ppl.language": "language",
    "sloop_ppl.models": "models",
    "sloop_ppl.inference": "inference",
    "sloop_ppl.planning": "planning",
    "sloop_ppl.bridge": "bridge",
    "sloop_ppl.eval": "eval",
    "sloop_ppl.plots": "plots",
    "sloop_ppl.web": "web",
    "sloop_ppl.simulation": "simulation",
    "sloop_ppl.maps.osm": "maps_osm",
    "sloop_ppl.models.frames": "models_frames",
    "sloop_ppl.models.likelihoods": "models_likelihoods",
    "sloop_ppl.bridge.asking": "bridge_asking",
    "sloop_ppl.errors": "errors",
}
_INTRODUCTION = """\
# Reference

Every public name, with types, shapes and units. `H` and `W` are the rows and columns of a map's
grid; arrays are `[row, col]` with row 0 in the south; places are `(x_m, y_m)`, metres east and
north of the map's centre; angles are radians, anticlockwise from east.

`import sloop_ppl as sloop` has these names, which load on first use:

{facade}

## Rooms

{rooms}
"""


@cache
def reference_pages() -> dict[str, tuple[str, str]]:
    """Return path of each page -> its title and its text in Markdown."""
    modules = {name: module for name in REFERENCE if (module := _module(name)) is not None}
    pages = {"reference/index.md": ("Overview", _overview(modules))}
    for name, module in modules.items():
        pages[page_of(name)] = (name.removeprefix("sloop_ppl."), _room(name, module, modules))
    return pages


def page_of(module: str) -> str:
    """Return the path of the page of a module, within the documentation."""
    return f"reference/{REFERENCE[module]}.md"


def _module(name: str) -> ModuleType | None:
    """Return a module, or None where this version of the package has none of that name."""
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        return None


def _overview(modules: dict[str, ModuleType]) -> str:
    facade = ["| name | |", "| --- | --- |"]
    for name in sloop_ppl.__all__:
        value = getattr(sloop_ppl, name)
        if isinstance(value, ModuleType) or name.startswith("__"):
            continue
        home = next(m for m in modules if name in modules[m].__all__)
        facade.append(f"| [`{name}`][{home}.{name}] | {_summary(value)} |")
    rooms = ["| room | |", "| --- | --- |"]
    rooms += [f"| [`{m}`]({REFERENCE[m]}.md) | {_summary(modules[m])} |" for m in modules]
    return _INTRODUCTION.format(facade="\n".join(facade), rooms="\n".join(rooms))


def _room(name: str, module: ModuleType, modules: dict[str, ModuleType]) -> str:
    parent = modules.get(name.rpartition(".")[0])
    known = set() if parent is None else set(parent.__all__)
    groups: dict[str, list[str]] = {"Functions": [], "Classes": [], "Values": []}
    table = ["| name | |", "| --- | --- |"]
    for public in sorted(module.__all__, key=str.lower):
        value = getattr(module, public)
        if isinstance(value, ModuleType) or public in known:
            continue
        kind = _kind(value)
        groups[kind].append(_entry(name, public, kind, value))
        summary = _summary(value) if kind != "Values" else _type_of(value)
        table.append(f"| [`{public}`][{name}.{public}] | {summary} |")
    parts = [f"# {name}", inspect.getdoc(module) or "", "\n".join(table)]
    for title, entries in groups.items():
        if entries:
            parts += [f"## {title}", *entries]
    return "\n\n".join(parts) + "\n"


def _kind(value: Any) -> str:
    if inspect.isclass(value):
        return "Classes"
    return "Functions" if inspect.isfunction(value) else "Values"


def _entry(module: str, public: str, kind: str, value: Any) -> str:
    """Return the lines at which mkdocstrings puts a name's documentation."""
    path, anchor = f"{module}.{public}", ""
    if kind == "Functions" and value.__module__ == path:
        # A module of the same name, which sources alone would take for what is meant
        path, anchor = f"{path}.{public}", f"[](){{#{path}}}\n\n"
    options = ["    options:", "      show_if_no_docstring: true"] if kind == "Values" else []
    return anchor + "\n".join([f"::: {path}", *options])


def _summary(value: Any) -> str:
    text = inspect.getdoc(value) or ""
    return " ".join(text.split("\n\n")[0].split()).replace("|", "\\|").replace("``", "`")


def _type_of(value: Any) -> str:
    """Return what a value is, for one that has no docstring of its own."""
    kind = type(value)
    if kind.__module__ == "builtins":
        return f"a {kind.__name__}"
    return f"a `{kind.__name__}`"
