"""Compile functions with numba: typed, cached where a cache folder can be written."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

__all__ = ["inlined", "jit"]

F = TypeVar("F", bound=Callable[..., object])

_njit: Any = numba.njit
_log = logging.getLogger(__name__)


def jit(function: F) -> F:
    """Compile a function at its first call, without the interpreter's lock while it runs.

    Machine code is kept beside the source or, where that is read-only, in numba's folder in the
    user's cache; where neither can be written, it is made anew in every process. Division by
    zero gives infinities, as in numpy.
    """
    return _compiled(function, forceinline=False)


def inlined(function: F) -> F:
    """Compile a function as a part of those that call it."""
    return _compiled(function, forceinline=True)


def _compiled(function: F, *, forceinline: bool) -> F:
    # Without its run time numba counts no references to arrays, which took half of the time;
    # what is compiled here must therefore not make arrays.
    options = {"nogil": True, "error_model": "numpy", "forceinline": forceinline, "_nrt": False}
    try:
        compiled = _njit(cache=True, **options)(function)
    except RuntimeError as error:
        _log.info("no cache for %s: %s", function.__name__, error)
        compiled = _njit(**options)(function)
    return cast("F", compiled)
