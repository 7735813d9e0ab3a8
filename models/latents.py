"""Latents that a model declares beside cell, component, frame and lapse."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.models.terms import RelationTerm

__all__ = ["Latent"]


def _every_relation(relation: RelationTerm) -> bool:  # noqa: ARG001
    return True


@dataclass(frozen=True)
class Latent:
    """A discrete latent of a description, such as which of two landmarks of one name is meant.

    The program draws it at a site of its name and reads each relation that it concerns as it is
    meant under each of its values.

    Parameters
    ----------
    name
        Name of its site; no other site has it.
    support
        Its values, distinct.
    prior
        Probability of each value, summing to one.
    concerns
        Tells of a grounded relation whether its meaning depends on the latent; all do by default.
    given
        Returns a grounded relation as it is meant under a value. By default the value stands in
        ``relation.latents[name]``, where a likelihood finds it.

    Raises
    ------
    InputError
        When the prior does not sum to one or does not fit the support, or a value comes twice.

    Notes
    -----
    A latent that concerns one phrase is summed out within that phrase, before tempering; one that
    several phrases depend on is shared by them, and by all targets. Each value's table is
    normalised over the map by itself: normalising the values together would return the prior.

    Examples
    --------
    >>> from dataclasses import replace
    >>> kiosk = Latent(
    ...     "ground_0",
    ...     ("Kiosk", "Kiosk2"),
    ...     (0.5, 0.5),
    ...     concerns=lambda relation: relation.ground == "Kiosk",
    ...     given=lambda relation, ground: replace(relation, grounds=(ground,)),
    ... )
    """

    name: str
    support: tuple[Any, ...]
    prior: tuple[float, ...]
    concerns: Callable[[RelationTerm], bool] = _every_relation
    given: Callable[[RelationTerm, Any], RelationTerm] | None = None

    def __post_init__(self) -> None:
        if not self.name or not isinstance(self.name, str):
            raise InputError(f"A latent is named {self.name!r}; expected a name that is not empty")
        if not self.support or len(set(self.support)) != len(self.support):
            raise InputError(
                f"Latent '{self.name}' has the support {self.support}; expected distinct values, "
                "at least one"
            )
        if len(self.prior) != len(self.support):
            raise InputError(
                f"Latent '{self.name}' has {len(self.prior)} prior probabilities for "
                f"{len(self.support)} values; expected one each"
            )
        total = math.fsum(self.prior)
        if not all(p >= 0 for p in self.prior) or not math.isclose(total, 1.0, abs_tol=1e-9):
            raise InputError(
                f"The prior of latent '{self.name}' sums to {total:g}; expected probabilities of "
                "at least 0 that sum to 1"
            )

    @property
    def log_prior(self) -> Tensor:
        """Log prior of its values, shape (V,)."""
        return torch.tensor(self.prior, dtype=torch.float64).log()

    def meant(self, relation: RelationTerm, value: Any) -> RelationTerm:
        """Return a grounded relation as it is meant under a value."""
        if self.given is not None:
            return self.given(relation, value)
        return relation.with_latent(self.name, value)
