"""Let matplotlib be imported where the environment names a backend that is not there.

A notebook sets ``MPLBACKEND`` for all its child processes; a command that it starts may run in
another environment, without the notebook's backend, in which matplotlib cannot even be imported.
Figures of this package need no backend.
"""

from __future__ import annotations

import os
from importlib.util import find_spec

__all__ = ["forget_missing_backend"]

_VARIABLE, _MODULE = "MPLBACKEND", "module://"


def forget_missing_backend() -> None:
    """Remove ``MPLBACKEND`` from the environment when it names a module that is not installed."""
    backend = os.environ.get(_VARIABLE, "")
    if backend.startswith(_MODULE) and not _is_there(backend.removeprefix(_MODULE)):
        del os.environ[_VARIABLE]


def _is_there(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except (ImportError, ValueError):
        return False
