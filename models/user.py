"""Load a user's model from a Python file, without touching the package."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from torch import Tensor

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.models._guard import guarded
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.models.presets import ObservationModel, preset
from sloop_ppl.user_file import failing, is_function, needed_arguments, open_user_file

__all__ = ["FunctionLikelihood", "load_model"]

_WANTED = (
    "an ObservationModel, a likelihood with a method log_g(term, direction_rad), or a function "
    "log_g(term, direction_rad)"
)


@dataclass(frozen=True)
class FunctionLikelihood:
    """A likelihood that is one function.

    Parameters
    ----------
    function
        Takes a term and directions in radians, or None, and returns log g.
    """

    function: Callable[[GroundedRelation, Tensor | None], Tensor]

    def log_g(self, term: GroundedRelation, direction_rad: Tensor | None) -> Tensor:
        """Return what the function gives."""
        return self.function(term, direction_rad)


def load_model(spec: str, base: str = "bayes") -> ObservationModel:
    """Return the model that a Python file holds.

    Parameters
    ----------
    spec
        ``FILE.py:NAME``. NAME is an ObservationModel; or a likelihood (an object or class with
        ``log_g``, or a function of a term and directions); or a function without arguments that
        returns one of these.
    base
        The model whose likelihood a likelihood takes the place of.

    Raises
    ------
    UnknownName
        When the file has nothing of that name that is a model.
    InputError
        When the file does not exist, fails, or names nothing; when NAME is something else.

    Notes
    -----
    The file is run, with its folder importable. What its likelihood returns is checked at every
    call, and what it raises is said in one line.
    """
    file = open_user_file(spec, "Model")
    there = [name for name, value in file.own.items() if _is_candidate(value)]
    if not file.name:
        names = (f"{file.path.name}:{name}" for name in there)
        listed = ", ".join(names) or f"none in it; expected {_WANTED}"
        raise InputError(f"Model '{spec}' names no model of the file; there are: {listed}")
    if not hasattr(file.module, file.name):
        raise UnknownName(f"model of {file.path.name}", file.name, there)
    path, label = file.path, file.label
    found = getattr(file.module, file.name)
    with failing("Model", label, path):
        if inspect.isclass(found) or (is_function(found) and not needed_arguments(found)):
            found = found()
    place = f"{path.resolve()}:{file.name}"
    if isinstance(found, ObservationModel):
        kept = guarded(found.likelihood, label, path, place)
        return replace(found, name=label, likelihood=kept)
    if callable(getattr(found, "log_g", None)):
        likelihood = found
    elif is_function(found) and len(needed_arguments(found)) == 2:
        likelihood = FunctionLikelihood(found)
    else:
        raise InputError(f"Model '{label}' is a {type(found).__name__}; expected {_WANTED}")
    return replace(preset(base), name=label, likelihood=guarded(likelihood, label, path, place))


def _is_candidate(value: Any) -> bool:
    if inspect.isclass(value) or is_function(value):
        if hasattr(value, "log_g"):
            return True
        return is_function(value) and len(needed_arguments(value)) in (0, 2)
    return isinstance(value, ObservationModel) or callable(getattr(value, "log_g", None))
