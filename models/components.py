"""Mixture components: the ways a speaker's phrases may bear on where a target is."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.models._logspace import log_normalise
from sloop_ppl.models._vocabulary import speaker_words
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.registry import Registry

__all__ = ["COMBINATIONS", "CUT_TO", "Component", "PhraseTable", "cut_below_uniform"]

PhraseTable = Callable[[GroundedRelation], Tensor]
"""Gives the log truth of one phrase at every cell, shape (S,)."""

CUT_TO = 1e-12
"""Probability that the published code leaves to a cell it cuts."""


@dataclass(frozen=True)
class Component:
    """One way of reading a description.

    Parameters
    ----------
    name
        What it is called in results.
    weight
        Prior probability, > 0; weights are normalised over the components that apply.
    combine
        How the phrases combine, a name in `COMBINATIONS`.
    keep_frames
        False to leave front, behind, left and right out.
    read_as
        A relation every phrase is read as, such as ``"near"``; None to keep what was said.
    cut
        True to cut cells below uniform, as the published code does.

    Raises
    ------
    InputError
        When the weight is not a positive number.

    Notes
    -----
    Source: SLOOP sec. III-E, the mixture of m = 2 and m = 4 components.
    """

    name: str
    weight: float = 1.0
    combine: str = "product"
    keep_frames: bool = True
    read_as: str | None = None
    cut: bool = False

    def __post_init__(self) -> None:
        if not (math.isfinite(self.weight) and self.weight > 0):
            raise InputError(
                f"Component '{self.name}' has weight {self.weight}; expected a positive number"
            )

    @property
    def uses_frames(self) -> bool:
        """Tell whether the component reads frame relations as they were said."""
        return self.is_literal and self.keep_frames

    @property
    def is_literal(self) -> bool:
        """Tell whether the component takes the phrases it keeps as they were said, all of them."""
        return self.combine == "product" and self.read_as is None

    def reads(self, term: GroundedRelation) -> bool:
        """Tell whether the component takes a phrase as it was said."""
        kept = self.keep_frames or not term.needs_frame
        return self.is_literal and kept and not term.is_silent

    def terms_it_reads(self, terms: tuple[GroundedRelation, ...]) -> tuple[GroundedRelation, ...]:
        """Return the terms this component keeps, as it reads them."""
        speaking = (t for t in terms if not t.is_silent)
        kept = tuple(t for t in speaking if self.keep_frames or not t.needs_frame)
        if self.read_as is None:
            return kept
        # A denied phrase has no affirmative reading to fall back on.
        return tuple(t.as_relation(self.read_as) for t in kept if not t.negated)


Combination = Callable[[tuple[GroundedRelation, ...], PhraseTable], Tensor]
COMBINATIONS: Registry[Combination] = Registry("combination")
"""Ways to combine phrases: each returns log factors whose sum over rows is the combination's log
weight of every cell; shape (L, S), with further axes before S for latents that phrases share."""


def _product(terms: tuple[GroundedRelation, ...], phrase: PhraseTable) -> Tensor:
    """Return one row per phrase: all phrases hold."""
    return torch.stack(torch.broadcast_tensors(*(phrase(term) for term in terms)))


def _sum(terms: tuple[GroundedRelation, ...], phrase: PhraseTable) -> Tensor:
    """Return one row: one of the phrases holds, each as likely, so the one meant is summed out."""
    tables = (log_normalise(phrase(term)) for term in terms)
    each = torch.stack(torch.broadcast_tensors(*tables))
    return (torch.logsumexp(each, 0) - math.log(len(terms)))[None]


def _keyword(terms: tuple[GroundedRelation, ...], phrase: PhraseTable) -> Tensor:  # noqa: ARG001
    """Return one row: 1 on the grounds' cells and 1 / (H W) elsewhere (SLOOP sec. V, keyword)."""
    on_ground = torch.stack([term.on_ground for term in terms]).any(0)
    elsewhere = torch.tensor(-math.log(on_ground.numel()), dtype=torch.float64)
    return torch.where(on_ground, torch.zeros_like(elsewhere), elsewhere)[None]


def _nothing(terms: tuple[GroundedRelation, ...], phrase: PhraseTable) -> Tensor:  # noqa: ARG001
    """Return one row of zeros: what was said tells nothing."""
    return torch.zeros(1, terms[0].city.grid.size, dtype=torch.float64)


def _uninformative(terms: tuple[GroundedRelation, ...], phrase: PhraseTable) -> Tensor:  # noqa: ARG001
    """Return one row: each phrase is any of a speaker's words, as likely, wherever the target is.

    Under ``speaker`` normalisation it is the probability of words chosen carelessly.
    """
    log_p = -len(terms) * math.log(len(speaker_words()))
    return torch.full((1, terms[0].city.grid.size), log_p, dtype=torch.float64)


COMBINATIONS.add("product", _product)
COMBINATIONS.add("sum", _sum)
COMBINATIONS.add("keyword", _keyword)
COMBINATIONS.add("nothing", _nothing)
COMBINATIONS.add("uninformative", _uninformative)


def cut_below_uniform(log_p: Tensor) -> Tensor:
    """Return a normalised table with every cell below uniform set to 1e-12, normalised again.

    Parameters
    ----------
    log_p
        Log probabilities over cells, shape (S,).

    Notes
    -----
    Source: the published code; the paper's text has no such cut.
    """
    below = log_p < -math.log(log_p.shape[-1])
    return log_normalise(torch.where(below, math.log(CUT_TO), log_p))
