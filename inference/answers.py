"""What an answer to a question says: a factor over named latents of the joint posterior."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.inference._log_tables import LogTable
from sloop_ppl.language import Description

if TYPE_CHECKING:
    from sloop_ppl.inference.joint import JointPosterior

__all__ = ["AnswerFactor", "CheckedAnswer", "check_answer", "checked_answers", "renumbered"]

Table = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class AnswerFactor:
    """An answer as evidence: how probable it was under each value of the latents it is about.

    Answers are independent given the latents, so they commute; one that tells nothing by its
    question, such as "I don't know", has no latents.

    Parameters
    ----------
    question, answer
        The words.
    latents
        Names of the latents in the joint posterior, such as ``("RedBike/cell",)`` or
        ``("ground_3",)``; as many as `likelihood` has axes.
    supports
        The values of each latent, by which it is known again; cells are a range.
    likelihood
        Probability of the answer under each value, in [0, 1].
    meant
        Its part in which the person answers as they mean to: the rest is error. Shape as
        `likelihood`.
    text
        Text of the description whose latents they are; empty for an answer about a cell.
    description
        What the answer says by itself, beyond the choice it makes; None for nothing.

    Raises
    ------
    InputError
        When a table has another shape than its latents, holds anything but probabilities, or is
        zero everywhere.
    """

    question: str
    answer: str
    latents: tuple[str, ...] = ()
    supports: tuple[Sequence[Any], ...] = ()
    likelihood: Table = field(default_factory=lambda: np.ones(()))
    meant: Table = field(default_factory=lambda: np.ones(()))
    text: str = ""
    description: Description | None = None

    def __post_init__(self) -> None:
        shape = tuple(len(values) for values in self.supports)
        for name in ("likelihood", "meant"):
            table = np.asarray(getattr(self, name), dtype=np.float64)
            object.__setattr__(self, name, table)
            sound = bool(np.isfinite(table).all() and (table >= 0).all() and (table <= 1).all())
            if table.shape != shape or len(shape) != len(self.latents) or not sound:
                raise InputError(
                    f"The {name} of answer '{self.answer}' has shape {table.shape}; expected "
                    f"probabilities of shape {shape}, one axis for each of its latents"
                )
        if not self.likelihood.any():
            raise InputError(
                f"Answer '{self.answer}' has probability 0 whatever is true; expected an answer "
                "that someone may give"
            )

    def table(self) -> LogTable:
        """Return the log likelihood as a factor of the joint posterior."""
        with np.errstate(divide="ignore"):
            return LogTable(self.latents, torch.from_numpy(np.log(self.likelihood)))

    @property
    def informs(self) -> bool:
        """Whether the choice among the answers tells anything."""
        return bool(self.latents)


class CheckedAnswer(NamedTuple):
    """An answer, and how probable it is that it was meant and true.

    Parameters
    ----------
    factor
        The answer.
    p
        Probability that it is no error, given everything; 1 for one that tells nothing.
    prior
        The same, as far as is known without any answer to this or another question.
    """

    factor: AnswerFactor
    p: float
    prior: float


def check_answer(answer: AnswerFactor, joint: JointPosterior, texts: Sequence[str]) -> None:
    """Refuse an answer to a question that was not asked of this posterior.

    Parameters
    ----------
    answer
        The answer.
    joint
        The joint posterior that it would become a factor of.
    texts
        What was said so far.

    Raises
    ------
    InputError
        When the posterior has no such latent, or one of other values.
    """
    known = set(joint.latents)
    for name, values in zip(answer.latents, answer.supports, strict=True):
        what = ""
        if name not in known:
            what = f"it is about '{name}', which this posterior does not have"
        elif _values(joint.support(name)) != _values(values):
            what = f"'{name}' has other values in this posterior"
        elif answer.text and answer.text not in texts:
            what = f"it is about “{answer.text}”, which was not said"
        if what:
            raise InputError(
                f"Answer '{answer.answer}' is to a question that was not asked here: {what}; ask "
                "again with sloop_ppl.ask(posterior, city)"
            )


def _values(support: Sequence[Any]) -> tuple[Any, ...] | int:
    """Return what identifies a support: its values, or the number of cells."""
    if isinstance(support, range):
        return len(support)
    return tuple(round(v, 9) if isinstance(v, float) else v for v in support)


def checked_answers(
    joint: JointPosterior, answers: Sequence[AnswerFactor], before: JointPosterior
) -> tuple[CheckedAnswer, ...]:
    """Return how probable it is that each answer was meant and true.

    Parameters
    ----------
    joint
        The joint posterior, all answers among its factors.
    answers
        The answers.
    before
        The joint posterior without any answer.

    Notes
    -----
    Given the value v of its latents, an answer a is no error with probability
    ``meant(a, v) / likelihood(a, v)``, which is averaged over what is known of v.
    """
    found = []
    for answer in answers:
        if not answer.informs:
            found.append(CheckedAnswer(answer, 1.0, 1.0))
            continue
        share = np.divide(
            answer.meant,
            answer.likelihood,
            out=np.zeros_like(answer.meant),
            where=answer.likelihood > 0,
        )
        after = float((joint.probabilities(*answer.latents) * share).sum())
        weights = before.probabilities(*answer.latents) * answer.likelihood
        prior = float((weights * share).sum() / max(weights.sum(), 1e-300))
        found.append(CheckedAnswer(answer, after, prior))
    return tuple(found)


def renumbered(
    answers: Sequence[AnswerFactor], shifts: Mapping[str, tuple[int, int]]
) -> tuple[AnswerFactor, ...]:
    """Return answers about frames and lapses with the numbers that these have now.

    Parameters
    ----------
    shifts
        Target -> first number of its relations that moves, and by how many: what one speaker adds
        is counted before the relations of those who spoke later.
    """

    def moved(name: str) -> str:
        target, _, site = name.partition("/")
        kind, _, number = site.rpartition("_")
        if kind not in ("frame", "lapse") or target not in shifts or not number.isdigit():
            return name
        first, by = shifts[target]
        return f"{target}/{kind}_{int(number) + by}" if int(number) >= first else name

    return tuple(
        replace(answer, latents=tuple(moved(name) for name in answer.latents)) for answer in answers
    )
