"""What a question is worth to a search: the expected gain in discounted return.

The return that a belief promises is that of the path that the planner ``fast`` would take under it,
summed exactly over the cells, with a share of the value bound for what the path leaves. Nothing is
drawn, so the same path and the same cells are compared with and without the answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning.belief import GridBelief
from sloop_ppl.planning.information import AnswerTables
from sloop_ppl.planning.path_search import RunningPathSearch
from sloop_ppl.planning.questions import QuestionTable
from sloop_ppl.planning.space import SearchSpace

__all__ = ["FINAL_SIMS", "SHORTLIST", "SHORTLIST_SIMS", "AskValue", "ReturnEstimator"]

SHORTLIST = 4
"""Questions whose gain is estimated; the most informative ones."""

SHORTLIST_SIMS = 200
"""Simulations under each answer of these."""

FINAL_SIMS = 700
"""Simulations under each answer of the best of them, and without asking: with these, not with
those it was chosen by, it is decided whether it is asked. The greatest of several estimates is too
great on average (the winner's curse)."""

_LEAST_BITS = 0.02
_BOUND_SHARE = 0.5
"""Share of the value bound that a search comes to beyond the horizon; the bound knows the place."""


class AskValue(NamedTuple):
    """The gain of one question.

    Parameters
    ----------
    place
        Position of the question among those that were offered.
    gain
        Expected discounted return with it less that without it, its cost included; None where it
        was not estimated.
    bits
        Expected information, bits.
    """

    place: int
    gain: float | None
    bits: float


class ReturnEstimator:
    """Expected discounted returns of beliefs in one search space.

    Parameters
    ----------
    space
        The search space; one whose sensor sees a mask.
    """

    def __init__(self, space: SearchSpace) -> None:
        self.space = space
        self._running: dict[int, RunningPathSearch] = {}

    def expected_return(self, belief: GridBelief, sims: int) -> float:
        """Return what the search promises under a belief.

        Parameters
        ----------
        belief
            Where the targets are believed to be, and the robot.
        sims
            Simulations that the path is chosen with, > 0.
        """
        if sims not in self._running:
            config = replace(self.space.config, sims=sims, rollout=None, tree_depth=0)
            sensor, motion = self.space._given
            space = SearchSpace(
                self.space.grid, self.space.target_ids, config, self.space.tall,
                sensor=sensor, motion=motion, walls=self.space.walls,
            )  # fmt: skip
            self._running[sims] = RunningPathSearch(space)
        running = self._running[sims]
        running.forget()
        agent: Any = SimpleNamespace(belief=belief, history=())
        action, info = running.plan(agent)
        if action.index >= 3:
            return float(info.values[action.name])
        return running.path_return(belief, _BOUND_SHARE)

    def best(self, belief: GridBelief, questions: Sequence[QuestionTable]) -> AskValue | None:
        """Return the question with the greatest gain; None when there is none to be looked at.

        Parameters
        ----------
        belief
            Where the targets are believed to be, and the robot.
        questions
            What may be asked.
        """
        bits = question_bits(belief, questions)
        order = [k for k in np.argsort(-bits, kind="stable") if bits[k] >= _LEAST_BITS]
        if not order:
            return None
        short = order[:SHORTLIST]
        without = self.expected_return(belief, SHORTLIST_SIMS) if len(short) > 1 else 0.0
        gains = [
            self.gain(belief, questions[k], SHORTLIST_SIMS, without) if len(short) > 1 else 0.0
            for k in short
        ]
        k = int(short[int(np.argmax(gains))])
        if len(short) > 1 and max(gains) <= 0.0:
            return AskValue(k, max(gains), float(bits[k]))  # too great on average, and yet none
        gain = self.gain(belief, questions[k], FINAL_SIMS)
        return AskValue(k, gain, float(bits[k]))

    def gain(
        self,
        belief: GridBelief,
        question: QuestionTable,
        sims: int = FINAL_SIMS,
        without: float | None = None,
    ) -> float:
        """Return the expected discounted return with a question less that without it.

        Parameters
        ----------
        belief
            Where the targets are believed to be, and the robot.
        question
            The question.
        sims
            Simulations under each answer.
        without
            What the search promises without asking; estimated with as many when None.
        """
        if without is None:
            without = self.expected_return(belief, sims)
        expected = 0.0
        for p, table, informs in answered(belief, question):
            if not informs:
                expected += p * without
                continue
            after = belief.replaced({**belief.tables, question.target: table})
            expected += p * self.expected_return(after, sims)
        later = self.space.config.discount**question.steps
        return later * expected - question.cost - without


def question_bits(belief: GridBelief, questions: Sequence[QuestionTable]) -> NDArray[np.float64]:
    """Return the expected information of each question, bits, shape (Q,)."""
    tables, found = belief.tables, np.zeros(len(questions))
    for target in belief.space.target_ids:
        own = [k for k, question in enumerate(questions) if question.target == target]
        if own:
            flat = [questions[k].p_answer.reshape(len(questions[k].p_answer), -1) for k in own]
            found[own] = AnswerTables(flat).bits(tables[target].reshape(-1))
    return found


def answered(
    belief: GridBelief, question: QuestionTable
) -> list[tuple[float, NDArray[np.float64], bool]]:
    """Return each possible answer's probability, the belief after it, (H, W), and if it tells any.

    "I don't know" is as probable wherever the target is, so that nothing changes.
    """
    table = belief.tables[question.target]
    found = []
    for given in question.p_answer:
        part = given * table
        p = float(part.sum())
        if p > 0:
            found.append((p, part / p, float(np.ptp(given)) > 1e-12))
    return found
