"""Let matplotlib be imported where the environment names a backend that is not there.

A notebook sets ``MPLBACKEND`` for all its child processes; a command that it starts may run in
another environment, without the notebook's backend, in which matplotlib cannot even be imported.
Figures of this package need no backend.
"""

from __future__ import annotations

import os
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path

from sloop_ppl._foreign import is_file

__all__ = ["forget_missing_backend"]

_VARIABLE, _MODULE = "MPLBACKEND", "module://"


def forget_missing_backend() -> None:
    """Remove ``MPLBACKEND`` from the environment when it names a backend that is not installed."""
    backend = os.environ.get(_VARIABLE, "")
    if backend.startswith(_MODULE):
        there = _is_there(backend.removeprefix(_MODULE))
    else:
        there = not backend or _has_name(backend.lower())
    if not there:
        del os.environ[_VARIABLE]


def _has_name(name: str) -> bool:
    """Tell whether matplotlib, which is not imported, or a package for it has such a backend."""
    package = find_spec("matplotlib")
    folders = (package and package.submodule_search_locations) or ()
    return (
        name == "notebook"  # another name of nbagg
        or any(is_file(Path(at) / "backends" / f"backend_{name}.py") for at in folders)
        or bool(entry_points(group="matplotlib.backend", name=name))
    )


def _is_there(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except (ImportError, ValueError):
        return False
