"""Load what a user wrote in a Python file of their own: ``FILE.py:NAME``."""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from types import ModuleType
from typing import Any

from sloop_ppl._foreign import is_file
from sloop_ppl.errors import InputError, SloopError, UnknownName

__all__ = [
    "UserFile",
    "UserValue",
    "described",
    "failing",
    "is_function",
    "is_user_file",
    "line_of",
    "load_from_file",
    "needed_arguments",
    "open_user_file",
]


@dataclass(frozen=True)
class UserFile:
    """A user's file that was run.

    Parameters
    ----------
    path
        The file.
    name
        The name that was asked for; empty where none was.
    module
        What the file made.
    """

    path: Path
    name: str
    module: ModuleType

    @property
    def label(self) -> str:
        """How to speak of the named thing: file name and name."""
        return f"{self.path.name}:{self.name}"

    @property
    def own(self) -> dict[str, Any]:
        """What the file itself defines, by name; imported classes and functions are left out."""
        there = {}
        for name, value in vars(self.module).items():
            if name.startswith("_") or inspect.ismodule(value):
                continue
            made = inspect.isclass(value) or inspect.isfunction(value)
            if made and value.__module__ != self.module.__name__:
                continue
            there[name] = value
        return there


@dataclass(frozen=True)
class UserValue:
    """What a user's file holds under a name.

    Parameters
    ----------
    value
        The thing itself.
    label
        How to speak of it.
    kind
        What it is, such as ``"Planner"``.
    path
        The file.
    """

    value: Any
    label: str
    kind: str
    path: Path

    def guard(self, value: Any, methods: Sequence[str]) -> Any:
        """Return an object whose methods say in one line what they raise; it is changed.

        One that cannot be changed, such as one made in C, is returned as it is.
        """
        for name in methods:
            method = getattr(value, name, None)
            if callable(method) and not hasattr(method, "guarded"):
                with suppress(AttributeError):
                    object.__setattr__(value, name, self._guarded(method))
        return value

    def _guarded(self, method: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(method)
        def call(*arguments: Any, **options: Any) -> Any:
            try:
                return method(*arguments, **options)
            except SloopError:
                raise
            except Exception as error:
                line = line_of(error, self.path)
                at = f" at line {line}" if line else ""
                raise InputError(
                    f"{self.kind} '{self.label}' fails in {method.__name__}{at}: {described(error)}"
                ) from error

        call.guarded = True  # type: ignore[attr-defined]
        return call


def is_user_file(spec: str) -> bool:
    """Tell whether a name means a file: ``mine.py`` or ``mine.py:NAME``."""
    return spec.endswith(".py") or ".py:" in spec


def load_from_file(
    spec: str,
    kind: str,
    wanted: str,
    accepts: Callable[[Any], bool],
    arguments: Sequence[Any] = (),
) -> UserValue:
    """Return what a file holds under a name.

    Parameters
    ----------
    spec
        ``FILE.py:NAME``. NAME is the thing itself, or a class or function that makes it.
    kind
        What it is, capitalised, for messages.
    wanted
        What is expected, for messages.
    accepts
        Tells whether an object is such a thing.
    arguments
        What a class or function is called with, as many as it needs.

    Raises
    ------
    UnknownName
        When the file has nothing of that name.
    InputError
        When the file does not exist, fails, or names nothing; when NAME is something else.
    """
    file = open_user_file(spec, kind)
    there = [n for n, v in file.own.items() if accepts(v) or is_function(v)]
    if not file.name:
        listed = ", ".join(f"{file.path.name}:{n}" for n in there) or "none in it"
        raise InputError(
            f"{kind} '{spec}' names nothing of the file; there are: {listed}; expected {wanted}"
        )
    if not hasattr(file.module, file.name):
        raise UnknownName(f"{kind.lower()} of {file.path.name}", file.name, there)
    value = getattr(file.module, file.name)
    if inspect.isclass(value) and not accepts(value):
        raise InputError(f"{kind} '{file.label}' is a {value.__name__}; expected {wanted}")
    if inspect.isclass(value) or (is_function(value) and not accepts(value)):
        with failing(kind, file.label, file.path):
            value = value(*arguments[: len(needed_arguments(value))])
    if not accepts(value):
        raise InputError(f"{kind} '{file.label}' is a {type(value).__name__}; expected {wanted}")
    return UserValue(value, file.label, kind, file.path)


def open_user_file(spec: str, kind: str) -> UserFile:
    """Run a user's file, with its folder importable, and return it.

    Raises
    ------
    InputError
        When it does not exist or fails; the message has the line.
    """
    if not is_user_file(spec):
        raise InputError(f"{kind} '{spec}' is no file of yours; give FILE.py:NAME")
    file, _, wanted = spec.rpartition(".py:") if ".py:" in spec else (spec[:-3], "", "")
    path = Path(f"{file}.py")
    if not is_file(path):
        raise InputError(f"{kind} file '{path}' does not exist; give FILE.py:NAME")
    digest = hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:12]
    name = f"_sloop_user_{path.stem}_{digest}"
    made = importlib.util.spec_from_file_location(name, path)
    if made is None or made.loader is None:
        raise InputError(f"{kind} file '{path}' is no Python file; give FILE.py:NAME")
    module = importlib.util.module_from_spec(made)
    folder = str(path.resolve().parent)
    sys.modules[name] = module  # dataclasses look their module up by name
    sys.path.insert(0, folder)
    try:
        with failing(kind, path.name, path):
            made.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    finally:
        sys.path.remove(folder)
    return UserFile(path, wanted, module)


@contextmanager
def failing(kind: str, label: str, path: Path) -> Iterator[None]:
    """Turn what a user's code raises into one line that says where."""
    try:
        yield
    except (Exception, SystemExit) as error:
        line = line_of(error, path)
        at = f" at line {line}" if line else ""
        raise InputError(f"{kind} '{label}' fails{at}: {described(error)}") from error


def is_function(value: Any) -> bool:
    """Tell whether something is a plain function."""
    return inspect.isfunction(value)


def needed_arguments(function: Callable[..., Any]) -> list[str]:
    """Return the arguments a function or class cannot do without."""
    kinds = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    return [
        p.name
        for p in inspect.signature(function).parameters.values()
        if p.default is inspect.Parameter.empty and p.kind in kinds
    ]


def line_of(error: BaseException, path: Path) -> int | None:
    """Return the last line of a file that an error passed through; None if it did not."""
    if isinstance(error, SyntaxError):
        return error.lineno
    frames = traceback.extract_tb(error.__traceback__)
    own = [f.lineno for f in frames if Path(f.filename).resolve() == path.resolve()]
    return own[-1] if own else None


def described(error: BaseException) -> str:
    """Return an error's type and message on one line."""
    message = error.msg if isinstance(error, SyntaxError) else str(error)
    return " ".join(f"{type(error).__name__}: {message}".split()).removesuffix(":")
