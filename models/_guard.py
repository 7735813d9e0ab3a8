"""Check what a user's likelihood returns at every call, and say in one line what it raises."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.models.check import check_table
from sloop_ppl.models.frames import FrameDistribution
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.models.latents import Latent
from sloop_ppl.models.likelihoods import (
    ClosedFormMarginal,
    Parameter,
    RelationLikelihood,
    parameters_of,
    with_values,
)
from sloop_ppl.user_file import described, line_of

__all__ = ["GuardedLikelihood", "guarded", "trusted"]


@dataclass(frozen=True)
class GuardedLikelihood:
    """A likelihood whose tables are checked.

    Parameters
    ----------
    inner
        The user's likelihood.
    name
        What to call it in messages.
    path
        The file it stands in, to name the line that failed; None when there is none.
    spec
        ``FILE.py:NAME`` by which `load_model` finds it again; empty when it came otherwise.
    """

    inner: RelationLikelihood
    name: str
    path: Path | None
    spec: str = ""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """What the user's likelihood declares."""
        return parameters_of(self.inner)

    @property
    def latents(self) -> tuple[Latent, ...]:
        """The latents that the user's likelihood declares."""
        return tuple(getattr(self.inner, "latents", ()))

    def __getattr__(self, name: str) -> Any:
        if name != "inner" and name in {p.name for p in parameters_of(self.inner)}:
            return getattr(self.inner, name)
        raise AttributeError(f"'{type(self).__name__}' has no attribute '{name}'")

    def with_values(self, values: Mapping[str, float | Tensor]) -> GuardedLikelihood:
        """Return it with some parameters changed."""
        return replace(self, inner=with_values(self.inner, values))

    def log_g(self, term: GroundedRelation, direction_rad: Tensor | None) -> Tensor:
        """Return log g.

        Raises
        ------
        InputError
            When the user's code fails or returns no table of log probabilities.
        """
        cells = (term.n_cells,)
        shape = cells if direction_rad is None else (len(direction_rad), *cells)
        return self._called("log_g", term, shape, lambda: self.inner.log_g(term, direction_rad))

    def _called(
        self,
        method: str,
        term: GroundedRelation,
        shape: tuple[int, ...],
        call: Callable[[], Tensor],
    ) -> Tensor:
        about = f"relation '{term.relation}' of {term.ground} (site 'holds', phrase {term.index})"
        try:
            table = call()
        except (Exception, SystemExit) as error:
            line = None if self.path is None else line_of(error, self.path)
            at = f" at line {line} of {self.path.name}" if self.path and line else ""
            raise InputError(
                f"{method} of '{self.name}' fails for {about}{at}: {described(error)}"
            ) from error
        return check_table(table, shape, f"{method} of '{self.name}' for {about}")


@dataclass(frozen=True)
class GuardedMarginal(GuardedLikelihood):
    """A guarded likelihood that knows its own expectation over a frame."""

    inner: ClosedFormMarginal  # type: ignore[assignment]

    def log_marginal(self, term: GroundedRelation, frame: FrameDistribution) -> Tensor:
        """Return log E[g] over the frame, shape (S,)."""
        shape = (term.n_cells,)
        return self._called(
            "log_marginal", term, shape, lambda: self.inner.log_marginal(term, frame)
        )


def trusted(likelihood: RelationLikelihood) -> bool:
    """Tell whether a likelihood is of this package, whose tests hold it to its promises."""
    return type(likelihood).__module__.split(".")[0] == "sloop_ppl"


def guarded(
    likelihood: RelationLikelihood,
    name: str | None = None,
    path: Path | None = None,
    spec: str = "",
) -> GuardedLikelihood:
    """Return a likelihood whose every call is checked.

    Parameters
    ----------
    name, path
        What to call it, and the file it stands in; its type's when None.
    spec
        How it is found again; see `GuardedLikelihood`.

    Raises
    ------
    InputError
        When it has no method ``log_g``.
    """
    kind = type(likelihood)
    if not callable(getattr(likelihood, "log_g", None)):
        raise InputError(
            f"Likelihood is a {kind.__name__}; expected an object with a method "
            "log_g(term, direction_rad), such as one of sloop_ppl.models.LIKELIHOODS"
        )
    if name is None:
        name = kind.__name__
    if path is None:
        file = getattr(sys.modules.get(kind.__module__), "__file__", None)
        path = None if file is None else Path(file)
    if isinstance(likelihood, ClosedFormMarginal):
        return GuardedMarginal(likelihood, name, path, spec)
    return GuardedLikelihood(likelihood, name, path, spec)
