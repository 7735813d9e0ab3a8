"""Latents that a model declares beside cell, component, frame and lapse."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal, get_args

import torch
from torch import Tensor

from sloop_ppl.errors import InputError, SloopError, UnknownName
from sloop_ppl.models._choices import Choice, ChoiceKind
from sloop_ppl.models.grounded_relation import GroundedRelation

__all__ = ["Latent", "Per"]

Per = Literal["speaker", "description", "relation", "ground"]
"""Of what there is one latent."""


def _every_relation(relation: GroundedRelation) -> bool:  # noqa: ARG001
    return True


@dataclass(frozen=True)
class Latent:
    """A discrete latent of a description, such as which landmark of a name is the referent.

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
    per
        Of what there is one: ``"speaker"``, each ``"description"`` (text) of a speaker, each
        ``"relation"``, or each ``"ground"``. Sites are ``name``; ``name/text_d`` for later texts;
        ``T/name_j`` for relation j of target T; ``name/G`` for ground G.

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
    concerns: Callable[[GroundedRelation], bool] = _every_relation
    given: Callable[[GroundedRelation, Any], GroundedRelation] | None = None
    per: Per = "speaker"
    key: str = ""
    """Name under which a likelihood finds the value, where it is not that of the site."""
    choice: ChoiceKind | None = None
    """What is chosen, of a latent that a description declares and not a model; see `of_choice`."""

    def __post_init__(self) -> None:
        if not self.name or not isinstance(self.name, str):
            raise InputError(f"A latent is named {self.name!r}; expected a name that is not empty")
        if self.per not in get_args(Per):
            raise UnknownName(f"thing that latent {self.name} is one of", self.per, get_args(Per))
        try:
            distinct = len(set(self.support)) == len(self.support)
            numbers = [float(p) for p in self.prior]
        except (TypeError, ValueError) as error:
            raise InputError(
                f"Latent '{self.name}' has the support {self.support!r} and the prior "
                f"{self.prior!r}; expected hashable values and a number for each"
            ) from error
        if not self.support or not distinct:
            raise InputError(
                f"Latent '{self.name}' has the support {self.support}; expected distinct values, "
                "at least one"
            )
        if len(self.prior) != len(self.support):
            raise InputError(
                f"Latent '{self.name}' has {len(self.prior)} prior probabilities for "
                f"{len(self.support)} values; expected one each"
            )
        total = math.fsum(numbers)
        if not all(p >= 0 for p in numbers) or not math.isclose(total, 1.0, abs_tol=1e-9):
            raise InputError(
                f"The prior of latent '{self.name}' sums to {total:g}; expected probabilities of "
                "at least 0 that sum to 1"
            )

    @classmethod
    def of_choice(cls, choice: Choice) -> Latent:
        """Return the latent of something that a description leaves open."""
        return cls(
            choice.name,
            choice.support,
            choice.prior,
            concerns=partial(_depends_on, choice.name),
            given=partial(_chosen, choice.name),
            choice=choice.kind,
        )

    @property
    def is_data(self) -> bool:
        """Tell whether it is names and numbers alone, and no functions."""
        plain = all(isinstance(value, str | int | float) for value in self.support)
        return plain and self.concerns is _every_relation and self.given is None

    @property
    def log_prior(self) -> Tensor:
        """Log prior of its values, shape (V,)."""
        return torch.tensor(self.prior, dtype=torch.float64).log()

    def apply(self, relation: GroundedRelation, value: Any) -> GroundedRelation:
        """Return a grounded relation as it is meant under a value.

        Raises
        ------
        InputError
            When `given` fails, or returns no grounded relation.
        """
        if self.given is None:
            return relation.with_latent(self.key or self.name, value)
        found = self._asked("given", self.given, relation, value)
        if not isinstance(found, GroundedRelation):
            raise InputError(
                f"`given` of latent '{self.name}' returned {found!r} for '{relation.relation} "
                f"{relation.ground}'; expected a grounded relation: replace(relation, ...)"
            )
        return found

    def is_about(self, relation: GroundedRelation) -> bool:
        """Tell whether the meaning of a relation depends on the latent.

        Raises
        ------
        InputError
            When `concerns` fails.
        """
        return bool(self._asked("concerns", self.concerns, relation))

    def _asked(self, what: str, function: Callable[..., Any], *arguments: Any) -> Any:
        try:
            return function(*arguments)
        except SloopError:
            raise
        except Exception as error:
            relation = arguments[0]
            message = " ".join(f"{type(error).__name__}: {error}".split())
            raise InputError(
                f"`{what}` of latent '{self.name}' fails for '{relation.relation} "
                f"{relation.ground}': {message}"
            ) from error

    def each(self, relations: Sequence[tuple[str, int, GroundedRelation]]) -> tuple[Latent, ...]:
        """Return the latents that there are of this one, each with the name of its site.

        Parameters
        ----------
        relations
            All that a speaker said: target, position among its relations, relation.
        """
        if self.per == "speaker":
            return (self,)
        found: dict[str, Latent] = {}
        for target, j, relation in relations:
            if not self.is_about(relation):
                continue
            name, own = self._of(target, j, relation)
            if name not in found:
                both = partial(_both, self.concerns, own)
                found[name] = replace(
                    self, name=name, key=self.key or self.name, per="speaker", concerns=both
                )
        return tuple(found.values())

    def _of(
        self, target: str, j: int, relation: GroundedRelation
    ) -> tuple[str, Callable[[GroundedRelation], bool]]:
        """Return the name of the one that a relation depends on, and what else depends on it."""
        if self.per == "description":
            which = relation.description
            name = self.name if which == 0 else f"{self.name}/text_{which}"
            return name, lambda other: other.description == which
        if self.per == "ground":
            return f"{self.name}/{relation.ground}", lambda other: other.ground == relation.ground
        key = relation.figure, relation.index, relation.grounds
        return (
            f"{target}/{self.name}_{j}",
            lambda other: (other.figure, other.index, other.grounds) == key,
        )


def _depends_on(name: str, relation: GroundedRelation) -> bool:
    return any(choice.name == name for choice in relation.choices)


def _chosen(name: str, relation: GroundedRelation, value: Any) -> GroundedRelation:
    return relation.chosen(name, value)


def _both(
    one: Callable[[GroundedRelation], bool],
    other: Callable[[GroundedRelation], bool],
    term: GroundedRelation,
) -> bool:
    return one(term) and other(term)
