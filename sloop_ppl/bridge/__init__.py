"""Where language meets planning: the facade functions, reports, and what commands ask for.

Names load on first use, because `infer` brings torch with it, and `search` pomdp-py.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sloop_ppl.bridge.facade import infer, parse
    from sloop_ppl.bridge.searching import search

__all__ = ["infer", "parse", "search"]

_HOME = {"infer": "facade", "parse": "facade", "search": "searching"}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
