"""Asks during a search: what planning gets as arrays are questions here."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.bridge.asking.answerer_model import AnswererModel
from sloop_ppl.bridge.asking.answerers import Answerer
from sloop_ppl.bridge.asking.candidates import CandidateQuestions
from sloop_ppl.bridge.asking.question import Question
from sloop_ppl.errors import BeliefCollapse, InputError, on_one_line
from sloop_ppl.inference import AnswerFactor
from sloop_ppl.planning.questions import QuestionTable, Reply

if TYPE_CHECKING:
    from sloop_ppl.bridge._tracking import BeliefTracker

__all__ = ["Dialogue", "PosteriorQuestioner"]

Tables = Mapping[str, NDArray[np.float64]]

_OFFERED = 4
"""Questions that planning gets of each target: the tree of pouct has one action for each."""


@dataclass(frozen=True)
class Dialogue:
    """How questions are asked during a search.

    Parameters
    ----------
    answerer
        Who answers.
    most
        How many questions may be asked, >= 0.
    cost
        What each takes from the reward, >= 0.
    steps
        How many steps each takes, >= 0.
    person
        How the person is believed to answer.
    kinds
        Names of the kinds of questions; all when None.
    landmarks
        Ids of the landmarks to ask about; the salient ones when None.
    choose
        Chooses what is asked without weighing it against its cost: called with the candidates and
        the belief, it returns a candidate's position, or None for no question. None for the usual
        choice by expected reward. For comparison with other ways to ask.

    Raises
    ------
    InputError
        When there is no answerer, or a number is negative.
    """

    answerer: Answerer
    most: int = 1
    cost: float = 10.0
    steps: int = 0
    person: AnswererModel = field(default_factory=AnswererModel)
    kinds: tuple[str, ...] | None = None
    landmarks: tuple[str, ...] | None = None
    choose: Callable[[CandidateQuestions, NDArray[np.float64]], int | None] | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.answerer, Answerer):
            raise InputError(
                f"The answerer is a {type(self.answerer).__name__}; expected an object with a "
                "method answer(question) that returns words"
            )
        for name in ("most", "cost", "steps"):
            if not 0 <= getattr(self, name) < np.inf:
                raise InputError(f"{name} of a dialogue is {getattr(self, name)}; expected >= 0")


class PosteriorQuestioner:
    """The questions that a posterior is worth asking, and the posterior after their answers.

    Parameters
    ----------
    tracker
        Keeps the posterior during the search.
    dialogue
        How it is asked.
    notify
        Called with each question and answer, and with what goes wrong.
    least
        Probability that no cell's belief falls below, for a search that is not to believe anything
        impossible.
    """

    def __init__(
        self,
        tracker: BeliefTracker,
        dialogue: Dialogue,
        *,
        notify: Callable[[str], None] | None = None,
        least: float = 0.0,
    ) -> None:
        self._tracker, self._dialogue = tracker, dialogue
        self._notify = notify or _ignore
        self._least = least
        self._asked: list[str] = []
        self._known: tuple[object, ...] = ()
        self._candidates: dict[str, CandidateQuestions] = {}
        self._questions: dict[tuple[str, int], Question] = {}
        self._offered: dict[str, Question] = {}

    @property
    def insists(self) -> bool:
        """Whether what it offers is asked without being weighed against its cost."""
        return self._dialogue.choose is not None

    def questions(self, beliefs: Tables, left: int) -> Sequence[QuestionTable]:
        """Return the most informative questions, as arrays."""
        del left
        self._refresh(tuple(beliefs))
        tables = []
        self._offered = {}
        for target, candidates in self._candidates.items():
            for k in self._chosen(candidates, beliefs[target]):
                key = target, k
                if key not in self._questions:
                    self._questions[key] = candidates.question(k)
                question = self._questions[key]
                if question.text not in self._offered:
                    self._offered[question.text] = question
                    tables.append(
                        QuestionTable(
                            question.text,
                            target,
                            question.p_answer()[: len(question.answers)],
                            self._dialogue.cost,
                            self._dialogue.steps,
                        )
                    )
        return tables

    def ask(self, question: QuestionTable) -> Reply:
        """Ask a question, and return the beliefs after the answer."""
        asked = self._offered[question.name]
        self._asked.append(asked.text)
        try:
            answer = self._dialogue.answerer.answer(asked)
        except Exception as error:  # whoever answers may be any program; the search goes on
            note = f"no answer: {on_one_line(str(error) or type(error).__name__, 120)}"
            self._notify(f"     asked: “{asked.text}” {note}; the search goes on")
            return Reply(None, None, goes_on=False, note=note)
        if answer is None:
            self._notify(f"     asked: “{asked.text}” no answer; the search goes on")
            return Reply(None, None, goes_on=False, note="no answer")
        text = answer.answer if isinstance(answer, AnswerFactor) else answer
        self._notify(f"     asked: “{asked.text}” answered: “{on_one_line(text, 120)}”")
        try:
            factor = answer if isinstance(answer, AnswerFactor) else asked.answer(answer)
            note = self._take(factor)
        except InputError as error:  # BeliefCollapse is one
            is_excluded = isinstance(error, BeliefCollapse)
            note = "not believed: it excludes all else" if is_excluded else "not understood"
            self._notify(f"     the answer is {note}; the search goes on")
            return Reply(text, None, note=note)
        posterior = self._tracker.posterior
        beliefs = {
            target: np.maximum(posterior.belief(target), self._least)
            for target in self._tracker.searched
        }
        return Reply(text, beliefs, note=note)

    def _chosen(self, candidates: CandidateQuestions, belief: NDArray[np.float64]) -> list[int]:
        choose = self._dialogue.choose
        if choose is None:
            return candidates.best(_OFFERED, belief)
        k = choose(candidates, belief)
        return [] if k is None else [k]

    def _take(self, factor: AnswerFactor) -> str:
        """Take an answer in; return what is to be said of it."""
        self._tracker.update(factor)
        checked = self._tracker.posterior.checked_answers()
        doubted = [one for one in checked if one.factor.informs and one.p < 0.5]
        note = ""
        for one in doubted:
            if one.factor is factor:
                note = f"doubted: right with probability {one.p:.2f}"
                self._notify(f"     the answer is {note}")
            else:
                self._notify(
                    f"     now doubted: “{one.factor.answer}” to “{one.factor.question}”, right "
                    f"with probability {one.p:.2f}"
                )
        return note

    def _refresh(self, targets: tuple[str, ...]) -> None:
        """Make the candidates anew where something was said or answered since."""
        posterior = self._tracker.language
        # What is seen of a cell tells nothing more of what was meant, given the cell.
        known = (*posterior.factors, *posterior.answers, *self._asked, targets)
        if len(known) == len(self._known) and all(
            a is b or a == b for a, b in zip(known, self._known, strict=True)
        ):
            return
        self._known, self._candidates, self._questions = known, {}, {}
        now = self._tracker.posterior
        for target in targets:
            candidates = CandidateQuestions(
                now,
                target,
                kinds=self._dialogue.kinds,
                person=self._dialogue.person,
                landmarks=self._dialogue.landmarks,
                without=self._asked,
            )
            if len(candidates):
                self._candidates[target] = candidates


def _ignore(line: str) -> None:
    del line
