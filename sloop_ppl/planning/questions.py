"""Questions during a search as planning knows them: arrays and costs, no language."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.planning._by_value import ByValue

__all__ = ["AskedQuestion", "QuestionTable", "Questioner", "Reply"]

Tables = Mapping[str, NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class QuestionTable:
    """A question that may be asked.

    Parameters
    ----------
    name
        What it is called; no two that are offered together have one name.
    target
        Id of the target whose cell it tells most of.
    p_answer
        Probability of each answer if the target is in a cell, shape (A, H, W); sums to one over the
        answers.
    cost
        What asking takes from the reward, >= 0.
    steps
        How many steps it takes, >= 0: so much later comes all that follows.

    Raises
    ------
    InputError
        When cost or steps are negative, or the table has another shape.
    """

    name: str
    target: str
    p_answer: NDArray[np.float64]
    cost: float = 0.0
    steps: int = 0

    def __post_init__(self) -> None:
        if not 0 <= self.cost < np.inf or self.steps < 0:
            raise InputError(
                f"Question '{self.name}' costs {self.cost} and takes {self.steps} steps; expected "
                "a finite cost and a number of steps of at least 0"
            )
        if self.p_answer.ndim != 3 or len(self.p_answer) < 2:
            raise InputError(
                f"The answers of question '{self.name}' have shape {self.p_answer.shape}; "
                "expected (answers, rows, columns) with at least two answers"
            )


class Reply(NamedTuple):
    """What came of a question.

    Parameters
    ----------
    text
        The words; None when nobody answered.
    beliefs
        Target -> belief now, shape (H, W); None when the answer is uninformative.
    goes_on
        Whether more may be asked.
    note
        What is to be said about it, such as that the answer is doubted; may be empty.
    """

    text: str | None
    beliefs: Tables | None = None
    goes_on: bool = True
    note: str = ""


@runtime_checkable
class Questioner(Protocol):
    """Who knows what can be asked, and asks it."""

    def questions(self, beliefs: Tables, left: int) -> Sequence[QuestionTable]:
        """Return the questions that are worth a closer look, the most informative first.

        Parameters
        ----------
        beliefs
            Target -> belief now, shape (H, W).
        left
            How many may still be asked.
        """
        ...

    def ask(self, question: QuestionTable) -> Reply:
        """Ask one of those that `questions` returned last."""
        ...


@dataclass(frozen=True)
class AskedQuestion(ByValue):
    """A question that was asked during a search.

    Parameters
    ----------
    step
        How many steps had been taken.
    text
        The question.
    answer
        What was answered; None when nobody did.
    target
        Id of the target it was to tell of.
    cost
        What it cost, >= 0.
    steps
        How many steps it took.
    bits
        Expected information about the target's cell, bits.
    realised
        By how many bits the belief in the true cell rose; None where the place is not known.
    gain
        Expected discounted return with the question less that without it, its cost included; None
        where the planner does not say.
    note
        What is to be said about it; may be empty.
    """

    step: int
    text: str
    answer: str | None
    target: str = ""
    cost: float = 0.0
    steps: int = 0
    bits: float = 0.0
    realised: float | None = None
    gain: float | None = None
    note: str = ""
