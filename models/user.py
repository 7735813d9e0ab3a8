"""Load a user's model from a Python file, without touching the package."""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

from torch import Tensor

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.models.guard import described, guarded, line_of
from sloop_ppl.models.presets import Preset, preset
from sloop_ppl.models.terms import RelationTerm

__all__ = ["FunctionLikelihood", "is_user_model", "load_model"]

_WANTED = (
    "a Preset, a likelihood with a method log_g(term, direction_rad), or a function "
    "log_g(term, direction_rad)"
)


@dataclass(frozen=True)
class FunctionLikelihood:
    """A likelihood that is one function.

    Parameters
    ----------
    function : takes a term and directions in radians, or None, and returns log g.
    """

    function: Callable[[RelationTerm, Tensor | None], Tensor]

    def log_g(self, term: RelationTerm, direction_rad: Tensor | None) -> Tensor:
        """Return what the function gives."""
        return self.function(term, direction_rad)


def is_user_model(spec: str) -> bool:
    """Tell whether a model's name means a file: ``mine.py`` or ``mine.py:NAME``."""
    return spec.endswith(".py") or ".py:" in spec


def load_model(spec: str, base: str = "bayes") -> Preset:
    """Return the model that a Python file holds.

    Parameters
    ----------
    spec : ``FILE.py:NAME``. NAME is a Preset; or a likelihood (an object or class with ``log_g``,
        or a function of a term and directions); or a function without arguments that returns
        one of these.
    base : the model whose likelihood a likelihood takes the place of.

    Raises
    ------
    UnknownName : when the file has nothing of that name that is a model.
    InputError : when the file does not exist, fails, or names nothing; when NAME is something else.

    Notes
    -----
    The file is run, with its folder importable. What its likelihood returns is checked at every
    call, and what it raises is said in one line.
    """
    file, _, name = spec.rpartition(".py:") if ".py:" in spec else (spec[:-3], "", "")
    path = Path(f"{file}.py")
    module = _run(path)
    there = [n for n, value in vars(module).items() if _is_candidate(n, value, module)]
    if not name:
        listed = ", ".join(f"{path.name}:{n}" for n in there) or f"none in it; expected {_WANTED}"
        raise InputError(f"Model '{spec}' names no model of the file; there are: {listed}")
    if not hasattr(module, name):
        raise UnknownName(f"model of {path.name}", name, there)
    told = f"{path.name}:{name}"
    found = getattr(module, name)
    with _told(told, path):
        if inspect.isclass(found) or (_is_function(found) and not _needs(found)):
            found = found()
    place = f"{path.resolve()}:{name}"
    if isinstance(found, Preset):
        kept = guarded(found.likelihood, told, path, place)
        return replace(found, name=told, likelihood=kept)
    if callable(getattr(found, "log_g", None)):
        likelihood = found
    elif _is_function(found) and len(_needs(found)) == 2:
        likelihood = FunctionLikelihood(found)
    else:
        raise InputError(f"Model '{told}' is a {type(found).__name__}; expected {_WANTED}")
    return replace(preset(base), name=told, likelihood=guarded(likelihood, told, path, place))


def _run(path: Path) -> ModuleType:
    if not path.is_file():
        raise InputError(f"Model file '{path}' does not exist; give FILE.py:NAME")
    digest = hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:12]
    name = f"_sloop_user_{path.stem}_{digest}"
    made = importlib.util.spec_from_file_location(name, path)
    if made is None or made.loader is None:
        raise InputError(f"Model file '{path}' is no Python file; give FILE.py:NAME")
    module = importlib.util.module_from_spec(made)
    folder = str(path.resolve().parent)
    sys.modules[name] = module  # dataclasses look their module up by name
    sys.path.insert(0, folder)
    try:
        with _told(path.name, path):
            made.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    finally:
        sys.path.remove(folder)
    return module


@contextmanager
def _told(what: str, path: Path) -> Iterator[None]:
    """Turn what a user's code raises into one line that says where."""
    try:
        yield
    except (Exception, SystemExit) as error:
        line = line_of(error, path)
        at = f" at line {line}" if line else ""
        raise InputError(f"Model '{what}' fails{at}: {described(error)}") from error


def _is_candidate(name: str, value: Any, module: ModuleType) -> bool:
    if name.startswith("_") or inspect.ismodule(value):
        return False
    if inspect.isclass(value) or _is_function(value):
        if value.__module__ != module.__name__:
            return False
        return hasattr(value, "log_g") or (_is_function(value) and len(_needs(value)) in (0, 2))
    return isinstance(value, Preset) or callable(getattr(value, "log_g", None))


def _is_function(value: Any) -> bool:
    return inspect.isfunction(value)


def _needs(function: Callable[..., Any]) -> list[str]:
    """Return the arguments a function cannot do without."""
    kinds = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    return [
        p.name
        for p in inspect.signature(function).parameters.values()
        if p.default is inspect.Parameter.empty and p.kind in kinds
    ]
