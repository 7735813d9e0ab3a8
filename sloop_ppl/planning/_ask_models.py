"""Asking as an action of the POMDP: the models of a search with questions among the actions."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning._pomdp import ObservationModel, PolicyModel, RewardModel, TransitionModel
from sloop_ppl.planning.models import (
    SearchObservationModel,
    SearchPolicyModel,
    SearchRewardModel,
    SearchTransitionModel,
)
from sloop_ppl.planning.questions import QuestionTable
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import SearchAction, SearchObservation, SearchState

__all__ = [
    "AnswerObservation",
    "AskAction",
    "AskObservationModel",
    "AskPolicyModel",
    "AskRewardModel",
    "AskTransitionModel",
    "AskedState",
    "QuestionBoard",
]


class AskAction(SearchAction):
    """The action of asking one of the questions on the board.

    Attributes
    ----------
    place
        Position of the question on the board.
    """

    __slots__ = ("place",)
    place: int

    def __init__(self, name: str, index: int, place: int) -> None:
        super().__init__(name, index)
        object.__setattr__(self, "place", place)

    def __reduce__(self) -> tuple[Any, ...]:
        return AskAction, (self.name, self.index, self.place)


class AskedState(SearchState):
    """A state of a simulation in which something was asked.

    Attributes
    ----------
    asked
        Bit mask of the questions on the board that were asked.
    """

    __slots__ = ("asked",)
    asked: int

    def __init__(self, state: SearchState, asked: int) -> None:
        super().__init__(state.robot, state.cells)
        object.__setattr__(self, "asked", asked)

    def __eq__(self, other: object) -> bool:
        return super().__eq__(other) and getattr(other, "asked", 0) == self.asked

    def __hash__(self) -> int:
        return hash((self.robot, self.cells, self.asked))

    def __reduce__(self) -> tuple[Any, ...]:
        return AskedState, (SearchState(self.robot, self.cells), self.asked)


class AnswerObservation(SearchObservation):
    """An answer, by its number.

    Attributes
    ----------
    answer
        Which of the answers.
    """

    __slots__ = ("answer",)
    answer: int

    def __init__(self, n_targets: int, found: int, answer: int) -> None:
        super().__init__((-1,) * n_targets, found)
        object.__setattr__(self, "answer", answer)
        object.__setattr__(self, "_hash", hash((self.seen, found, answer)))

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, AnswerObservation)
            and self.answer == other.answer
            and self.found == other.found
        )

    def __hash__(self) -> int:
        return self._hash  # type: ignore[no-any-return, attr-defined]

    def __reduce__(self) -> tuple[Any, ...]:
        return AnswerObservation, (len(self.seen), self.found, self.answer)


class QuestionBoard:
    """The questions that may be asked now; it changes from decision to decision.

    Parameters
    ----------
    space
        The search space.
    most
        How many questions may be asked in all, >= 0.
    """

    def __init__(self, space: SearchSpace, most: int) -> None:
        self._space, self.left = space, most
        self.tables: tuple[QuestionTable, ...] = ()
        self.actions: tuple[AskAction, ...] = ()
        self._flat: list[NDArray[np.float64]] = []
        self._target: list[int] = []

    def offer(self, tables: Sequence[QuestionTable]) -> None:
        """Put other questions on the board."""
        self.tables = tuple(tables) if self.left > 0 else ()
        first = len(self._space.actions)
        self.actions = tuple(
            AskAction(f"ask({table.name})", first + k, k) for k, table in enumerate(self.tables)
        )
        ids = self._space.target_ids
        self._target = [ids.index(table.target) for table in self.tables]
        self._flat = [
            np.cumsum(table.p_answer.reshape(len(table.p_answer), -1), 0) for table in self.tables
        ]

    def askable(self, asked: int) -> tuple[AskAction, ...]:
        """Return what may still be asked once the questions of a bit mask were."""
        if asked.bit_count() >= self.left:
            return ()
        return tuple(action for action in self.actions if not asked >> action.place & 1)

    def answer(self, place: int, cells: tuple[int, ...], u: float) -> int:
        """Return the answer that a uniform number stands for, if the targets are in these cells."""
        running = self._flat[place][:, cells[self._target[place]]]
        return int(np.searchsorted(running[:-1], u * running[-1], side="right"))

    def p_answer(self, place: int, cells: tuple[int, ...], answer: int) -> float:
        """Return the probability of an answer, if the targets are in these cells."""
        running = self._flat[place][:, cells[self._target[place]]]
        return float(running[answer] - (running[answer - 1] if answer else 0.0))


class AskTransitionModel(TransitionModel):
    """Asking changes nothing but what can still be asked."""

    def __init__(self, inner: SearchTransitionModel) -> None:
        self._inner, self.space = inner, inner.space

    def sample(self, state: SearchState, action: SearchAction) -> SearchState:
        """Return a state that follows."""
        asked = getattr(state, "asked", 0)
        if isinstance(action, AskAction):
            return AskedState(state, asked | 1 << action.place)
        after = self._inner.sample(state, action)
        return AskedState(after, asked) if asked else after

    def argmax(self, state: SearchState, action: SearchAction) -> SearchState:
        """Return the most probable state that follows."""
        asked = getattr(state, "asked", 0)
        if isinstance(action, AskAction):
            return AskedState(state, asked | 1 << action.place)
        after = self._inner.argmax(state, action)
        return AskedState(after, asked) if asked else after

    def probability(
        self, next_state: SearchState, state: SearchState, action: SearchAction
    ) -> float:
        """Return the probability that a state follows."""
        if isinstance(action, AskAction):
            return float(next_state == self.argmax(state, action))
        if getattr(next_state, "asked", 0) != getattr(state, "asked", 0):
            return 0.0
        after, before = (SearchState(s.robot, s.cells) for s in (next_state, state))
        return self._inner.probability(after, before, action)


class AskObservationModel(ObservationModel):
    """An answer follows from the cell of the target that the question is about."""

    def __init__(
        self, inner: SearchObservationModel, board: QuestionBoard, n_targets: int,
        rng: random.Random,
    ) -> None:  # fmt: skip
        self._inner, self._board, self._n, self._rng = inner, board, n_targets, rng

    def sample(self, next_state: SearchState, action: SearchAction) -> SearchObservation:
        """Return what is observed on reaching a state."""
        if isinstance(action, AskAction):
            answer = self._board.answer(action.place, next_state.cells, self._rng.random())
            return AnswerObservation(self._n, next_state.robot.found, answer)
        return self._inner.sample(next_state, action)

    def argmax(self, next_state: SearchState, action: SearchAction) -> SearchObservation:
        """Return the most probable observation."""
        if isinstance(action, AskAction):
            table = self._board.tables[action.place].p_answer
            p = [self._board.p_answer(action.place, next_state.cells, a) for a in range(len(table))]
            return AnswerObservation(self._n, next_state.robot.found, int(np.argmax(p)))
        return self._inner.argmax(next_state, action)

    def probability(
        self, observation: SearchObservation, next_state: SearchState, action: SearchAction
    ) -> float:
        """Return the probability of an observation."""
        if isinstance(action, AskAction):
            if not isinstance(observation, AnswerObservation):
                return 0.0
            return self._board.p_answer(action.place, next_state.cells, observation.answer)
        if isinstance(observation, AnswerObservation):
            return 0.0
        return self._inner.probability(observation, next_state, action)


class AskRewardModel(RewardModel):
    """A question takes its cost from the reward."""

    def __init__(self, inner: SearchRewardModel, board: QuestionBoard) -> None:
        self._inner, self._board = inner, board

    def sample(self, state: SearchState, action: SearchAction, next_state: SearchState) -> float:
        """Return the reward of a transition."""
        if isinstance(action, AskAction):
            return 0.0 if state.robot.ended else -self._board.tables[action.place].cost
        return self._inner.sample(state, action, next_state)

    argmax = sample


class AskPolicyModel(PolicyModel):
    """Every action of the search, and every question on the board that was not asked yet."""

    def __init__(self, inner: SearchPolicyModel, board: QuestionBoard) -> None:
        self._inner, self._board = inner, board

    def get_all_actions(
        self, state: SearchState | None = None, history: Any = None
    ) -> tuple[SearchAction, ...]:
        """Return the actions that may be taken, in their declared order."""
        asked = 0 if state is None else getattr(state, "asked", 0)
        return (*self._inner.get_all_actions(state, history), *self._board.askable(asked))

    def sample(self, state: SearchState) -> SearchAction:
        """Return any action of the search itself."""
        return self._inner.sample(state)
