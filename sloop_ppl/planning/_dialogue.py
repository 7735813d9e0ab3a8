"""The questions of one search: which is asked when, and what comes of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.planning._ask_models import AskAction, QuestionBoard
from sloop_ppl.planning._ask_value import AskValue, ReturnEstimator, question_bits
from sloop_ppl.planning._pomdp import Agent
from sloop_ppl.planning.belief import GridBelief
from sloop_ppl.planning.information import realised_bits
from sloop_ppl.planning.planners import RunningPlanner
from sloop_ppl.planning.questions import AskedQuestion, Questioner
from sloop_ppl.planning.space import SearchSpace

__all__ = ["Dialogue"]

_MOVED = 0.1
"""Total variation of a belief from which on a question that was not worth asking is valued anew."""


class Dialogue:
    """What is asked during a search.

    Parameters
    ----------
    space
        The search space.
    questioner
        Who knows what can be asked.
    most
        How many questions may be asked, >= 0.
    in_tree
        Whether the planner has questions among its actions; else they are valued here.
    cells
        Target -> flat index of its true cell, as far as it is known.
    on_question
        Called with each question that was asked.

    Raises
    ------
    InputError
        When the questioner is none, `most` is negative, or questions would have to be valued for a
        sensor that sees no mask.
    """

    def __init__(
        self,
        space: SearchSpace,
        questioner: Any,
        most: int,
        *,
        in_tree: bool,
        cells: Mapping[str, int],
        on_question: Callable[[AskedQuestion], None] | None = None,
    ) -> None:
        if not isinstance(questioner, Questioner):
            raise InputError(
                f"The questioner is a {type(questioner).__name__}; expected an object with methods "
                "questions(beliefs, left) and ask(question)"
            )
        if most < 0:
            raise InputError(f"The number of questions is {most}; expected 0 or more")
        if not (in_tree or space.sees_mask):
            raise InputError(
                f"Questions cannot be valued for sensor {type(space.sensor).__name__}, which sees "
                "no mask; expected planner pouct or pomcp, or no questions"
            )
        self._space, self._questioner, self._in_tree = space, questioner, in_tree
        self._cells, self._on_question = cells, on_question
        self.board = QuestionBoard(space, most)
        self.asked: list[AskedQuestion] = []
        self._refused: tuple[Any, ...] = ()

    @cached_property
    def _estimator(self) -> ReturnEstimator:
        return ReturnEstimator(self._space)

    def choose(self, agent: Agent, running: RunningPlanner, step: int) -> tuple[Any, Any]:
        """Return the planner's next action, or ask first, as often as that is worth it.

        Returns
        -------
        tuple
            Action and `PlanInfo`, as of the planner.
        """
        while True:
            if self.board.left > 0:
                belief: GridBelief = agent.belief
                self.board.offer(self._questioner.questions(belief.tables, self.board.left))
            if not self._in_tree:
                worth = self._worth(agent.belief)
                if worth is not None:
                    self._ask(agent, running, step, worth.place, worth.gain)
                    continue
                return running.plan(agent)
            action, info = running.plan(agent)
            if not isinstance(action, AskAction):
                return action, info
            rest = [v for name, v in info.values.items() if not name.startswith("ask(")]
            gain = info.values[action.name] - max(rest) if rest else None
            self._ask(agent, running, step, action.place, gain)

    def _worth(self, belief: GridBelief) -> AskValue | None:
        """Return the question that is worth asking now; None when none is."""
        if not self.board.tables:
            return None
        if getattr(self._questioner, "insists", False):
            bits = float(question_bits(belief, self.board.tables[:1])[0])
            return AskValue(0, None, bits)
        if self._refused and len(self._refused) == len(belief.flat):
            moved = (
                np.abs(a - b).sum() / 2 for a, b in zip(belief.flat, self._refused, strict=True)
            )
            if max(moved) < _MOVED:
                return None
        best = self._estimator.best(belief, self.board.tables)
        if best is not None and (best.gain or 0.0) > 0:
            self._refused = ()
            return best
        self._refused = belief.flat
        return None

    def _ask(
        self, agent: Agent, running: RunningPlanner, step: int, place: int, gain: float | None
    ) -> None:
        """Ask a question and take in the answer."""
        table, belief = self.board.tables[place], agent.belief
        before = belief.tables[table.target]
        bits = float(question_bits(belief, [table])[0])
        reply = self._questioner.ask(table)
        realised = None
        if reply.beliefs is not None:
            updated = belief.replaced({**belief.tables, **reply.beliefs})
            agent.set_belief(updated)
            if table.target in self._cells:
                after = updated.tables[table.target]
                realised = realised_bits(before, after, self._cells[table.target])
        elif table.target in self._cells:
            realised = 0.0
        # The answer may have changed what can be asked, so no tree of before can be gone on with.
        running.forget()
        self.board.left = self.board.left - 1 if reply.goes_on else 0
        self.board.offer(())
        self.asked.append(
            AskedQuestion(
                step, table.name, reply.text, table.target, table.cost, table.steps, bits,
                realised, gain, reply.note,
            )
        )  # fmt: skip
        if self._on_question is not None:
            self._on_question(self.asked[-1])
