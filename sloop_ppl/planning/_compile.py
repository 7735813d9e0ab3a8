"""Compile functions with numba: what is kept on disk, what is a part of others, who is told."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba.core import event
from numba.core.caching import FunctionCache, IndexDataCacheFile

__all__ = [
    "COMPILING",
    "PART_OPTIONS",
    "callable_part",
    "called",
    "inlined",
    "int64",
    "jit",
    "notify_compiling",
    "uncached",
]

COMPILING = "compiling the planner, once after an install; this takes some seconds"
"""What to say while `notify_compiling` calls back."""

F = TypeVar("F", bound=Callable[..., object])

int64: Any = np.int64
"""numpy's, under a name that a type checker takes for `int`, as compiled code does."""

_njit: Any = numba.njit
_log = logging.getLogger(__name__)

# Without its run time numba counts no references to arrays, which took half of the time; what is
# compiled here must therefore not make arrays. Division by zero gives infinities, as in numpy.
_OPTIONS = {"nogil": True, "error_model": "numpy", "_nrt": False, "no_cfunc_wrapper": True}

# A function that only machine code calls needs no entry from Python. Of functions with dozens of
# arrays among their arguments the entries took a third of the time that compiling takes.
PART_OPTIONS = {**_OPTIONS, "no_cpython_wrapper": True, "forceinline": True}
"""Options of functions that are compiled as a part of those that call them."""


def jit(function: F) -> F:
    """Compile a function of this package at its first call; it runs without the interpreter's lock.

    Machine code is kept beside the source or, where that is read-only, in numba's folder in the
    user's cache; where neither can be written, it is made anew in every process. It must be called
    with types of this package alone, because the cache names types by their modules: another
    process might not be able to import those of a user. For these there is `uncached`.
    """
    compiled = _njit(**_OPTIONS)(function)
    try:
        compiled._cache = _ForgivingCache(function)
    except (OSError, RuntimeError) as error:
        _log.info("no cache for %s: %s", function.__name__, error)
    return cast("F", compiled)


def uncached(function: F) -> F:
    """Compile a function at its first call in every process, as `jit` does for types of ours."""
    return cast("F", _njit(**_OPTIONS)(getattr(function, "py_func", function)))


def inlined(function: F) -> F:
    """Compile a function as a part of each that calls it; Python cannot call it."""
    return cast("F", _njit(**PART_OPTIONS)(function))


def called(function: F) -> F:
    """Compile a function once, to be called by machine code; Python cannot call it."""
    return cast("F", _njit(**{**PART_OPTIONS, "forceinline": False})(function))


def callable_part(function: F) -> F:
    """Compile a function as `inlined` does, which Python can call, too."""
    return cast("F", _njit(**{**PART_OPTIONS, "no_cpython_wrapper": False})(function))


class _ForgivingCache(FunctionCache):
    """numba's cache of one function, for which whatever cannot be loaded is not there.

    numba itself compares the function's own file alone with what it was when the machine code was
    made, and raises when the index names a module that is gone or is cut off. Here machine code is
    fresh when none of the modules with compiled functions has changed.
    """

    def __init__(self, py_func: Callable[..., object]) -> None:
        base: Any = super()  # numba has no types
        base.__init__(py_func)
        self._cache_file = IndexDataCacheFile(
            cache_path=self._cache_path,
            filename_base=self._impl.filename_base,
            source_stamp=_source_stamp(py_func.__code__.co_filename),
        )

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the machine code of a signature, or None."""
        base: Any = super()
        try:
            return base.load_overload(sig, target_context)
        except Exception as error:  # unpickling and linking can raise anything
            _log.info("compiling %s anew: %r", self._name, error)
        try:
            base.flush()  # else saving would stumble over the same index
        except OSError as error:
            _log.info("the cache of %s cannot be written: %s", self._name, error)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep the machine code of a signature, where that can be done."""
        base: Any = super()
        try:
            base.save_overload(sig, data)
        except Exception as error:  # another process may write the same index
            _log.info("the machine code of %s was not kept: %r", self._name, error)


@cache
def _source_stamp(filename: str) -> str:
    """Return a hash of a function's own file and of those whose functions it may have inlined."""
    digest = hashlib.sha256()
    # Inlined functions live in the modules _*.py: a change in any of them makes machine code stale.
    for path in sorted({Path(filename), *Path(__file__).parent.glob("_*.py")}):
        digest.update(path.read_bytes())
    return digest.hexdigest()


@contextmanager
def notify_compiling(callback: Callable[[], None]) -> Iterator[None]:
    """Call a function once, when one of this package's functions begins to be compiled.

    Nothing is called while machine code comes from the cache.

    Parameters
    ----------
    callback
        Called without arguments, in the thread that compiles.

    Examples
    --------
    >>> with notify_compiling(lambda: print("compiling the planner, once after an install")):
    ...     pass
    """
    listener = _Listener(callback)
    with event.install_listener("numba:compile", listener):
        yield


class _Listener(event.Listener):
    """Tells the first of our functions that is compiled."""

    def __init__(self, callback: Callable[[], None]) -> None:
        self._callback = callback
        self._notified = False

    def on_start(self, event: Any) -> None:
        """Call back when the function is one of ours and nothing was said yet."""
        function = event.data["dispatcher"].py_func
        if not self._notified and function.__module__.startswith("sloop_ppl."):
            self._notified = True
            self._callback()

    def on_end(self, event: Any) -> None:
        """Say nothing when it is done."""
