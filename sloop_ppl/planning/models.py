"""The models of the search: how states, observations, rewards and actions follow."""

from __future__ import annotations

import random
from functools import cached_property
from typing import TYPE_CHECKING

from sloop_ppl.planning._pomdp import (
    ObservationModel,
    PolicyModel,
    RewardModel,
    RolloutPolicy,
    TransitionModel,
)
from sloop_ppl.planning.detection import Detector
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import SearchAction, SearchObservation, SearchState

if TYPE_CHECKING:
    from sloop_ppl.planning._search_kernel import NativeSearch

__all__ = [
    "PublishedRollout",
    "RandomRollout",
    "SearchObservationModel",
    "SearchPolicyModel",
    "SearchRewardModel",
    "SearchTransitionModel",
]

History = tuple[tuple[SearchAction, SearchObservation], ...]


class SearchTransitionModel(TransitionModel):
    """Moves change the pose; a find marks what is in view; nothing changes once it is over.

    Attributes
    ----------
    space : the search space, by which the planner ``fast`` knows the domain.
    """

    def __init__(self, space: SearchSpace) -> None:
        self.space = space

    @cached_property
    def native(self) -> NativeSearch:
        """The search as the planner ``fast`` runs it."""
        from sloop_ppl.planning._search_kernel import NativeSearch

        return NativeSearch(self.space)

    def sample(self, state: SearchState, action: SearchAction) -> SearchState:
        """Return the state that follows; it is certain."""
        robot = state.robot
        if robot.ended:
            return state
        index = action.index
        if index < 3:
            return SearchState(robot._next[index] or robot.moved(index), state.cells)
        marks = 0
        if robot.looked:
            for i, cell in enumerate(state.cells):
                if cell in robot.view:
                    marks |= 1 << i
        return SearchState(robot.marked(marks & action.marks), state.cells)

    argmax = sample

    def probability(
        self, next_state: SearchState, state: SearchState, action: SearchAction
    ) -> float:
        """Return one for the state that follows, else zero."""
        return float(next_state == self.sample(state, action))


class SearchObservationModel(ObservationModel):
    """After a move the robot senses its view; a find tells what has been found.

    Parameters
    ----------
    space : the search space.
    rng : where the errors of a noisy sensor are drawn from; an exact one needs none.
    """

    def __init__(self, space: SearchSpace, rng: random.Random | None = None) -> None:
        self._nothing = (-1,) * len(space.target_ids)
        self._blank = [SearchObservation(self._nothing, m) for m in range(space.all_found + 1)]
        self._made: dict[tuple[tuple[int, ...], int], SearchObservation] = {}
        self._detector = Detector(space)
        self._noisy = space.config.noisy
        self._rng = random.Random(0) if rng is None else rng

    def sample(self, next_state: SearchState, action: SearchAction) -> SearchObservation:
        """Return what is observed on reaching a state."""
        robot = next_state.robot
        if action.index >= 3:
            return self._blank[robot.found]
        if self._noisy:
            seen = self._sensed(next_state)
        elif robot.view.isdisjoint(next_state.cells):
            return self._blank[robot.found]
        else:
            seen = self._in_view(next_state)
        key = seen, robot.found
        made = self._made.get(key)
        if made is None:
            made = self._made[key] = SearchObservation(seen, robot.found)
        return made

    def argmax(self, next_state: SearchState, action: SearchAction) -> SearchObservation:
        """Return what an exact sensor observes on reaching a state."""
        seen = self._in_view(next_state) if action.index < 3 else self._nothing
        return SearchObservation(seen, next_state.robot.found)

    def probability(
        self, observation: SearchObservation, next_state: SearchState, action: SearchAction
    ) -> float:
        """Return the probability of an observation on reaching a state."""
        robot = next_state.robot
        if observation.found != robot.found:
            return 0.0
        if action.index >= 3:
            return float(observation.seen == self._nothing)
        chance = 1.0
        for i, (cell, seen) in enumerate(zip(next_state.cells, observation.seen, strict=True)):
            if robot.found >> i & 1:
                chance *= float(seen < 0)
            else:
                chance *= self._detector.probability(robot, cell, seen)
        return chance

    def _in_view(self, state: SearchState) -> tuple[int, ...]:
        view, found = state.robot.view, state.robot.found
        return tuple(
            cell if cell in view and not found >> i & 1 else -1
            for i, cell in enumerate(state.cells)
        )

    def _sensed(self, state: SearchState) -> tuple[int, ...]:
        robot = state.robot
        return tuple(
            -1 if robot.found >> i & 1 else self._detector.sample(robot, cell, self._rng)
            for i, cell in enumerate(state.cells)
        )


class SearchRewardModel(RewardModel):
    """The one reward of agent and environment."""

    def __init__(self, space: SearchSpace) -> None:
        config = space.config
        self._move = config.move_reward
        self._right = config.right_find_reward
        self._wrong = config.wrong_find_reward
        self._collision = config.collision_reward

    def sample(self, state: SearchState, action: SearchAction, next_state: SearchState) -> float:
        """Return the reward of a transition; zero once the search is over."""
        robot = state.robot
        if robot.ended:
            return 0.0
        if action.index < 3:
            return self._collision if action.index == 0 and robot.collides else self._move
        return self._right if next_state.robot.found != robot.found else self._wrong

    argmax = sample


class SearchPolicyModel(PolicyModel):
    """Every move, and a find once the robot has looked from its pose."""

    def __init__(self, space: SearchSpace, rng: random.Random) -> None:
        self._all, self._moves, self._rng = space.actions, space.moves, rng

    def get_all_actions(
        self,
        state: SearchState | None = None,
        history: History | None = None,  # noqa: ARG002
    ) -> tuple[SearchAction, ...]:
        """Return the actions that may be taken, in their declared order."""
        if state is None or state.robot.looked:
            return self._all
        return self._moves

    def sample(self, state: SearchState) -> SearchAction:
        """Return any action that may be taken."""
        return self._rng.choice(self.get_all_actions(state))


class RandomRollout(RolloutPolicy):
    """Any action that may be taken, each as likely."""

    def __init__(self, space: SearchSpace, rng: random.Random) -> None:
        self._all, self._moves, self._random = space.actions, space.moves, rng.random

    def rollout(self, state: SearchState, history: History | None = None) -> SearchAction:  # noqa: ARG002
        """Return the next action of a rollout."""
        actions = self._all if state.robot.looked else self._moves
        return actions[int(self._random() * len(actions))]


class PublishedRollout(RolloutPolicy):
    """Find what was just seen; else a move that goes nearer to or turns towards some target.

    Notes
    -----
    Source: SLOOP's published code (preferred actions of its rollout policy).
    """

    def __init__(self, space: SearchSpace, rng: random.Random) -> None:
        moves = space.moves
        self._choices = tuple(
            tuple(m for m in moves if mask >> m.index & 1) or moves for mask in range(8)
        )
        self._finds = space.finds
        self._keys = space.preference_keys
        self._random = rng.random

    def rollout(self, state: SearchState, history: History | None = None) -> SearchAction:
        """Return the next action of a rollout."""
        robot = state.robot
        if robot.ended:
            return self._finds[0]
        if history:
            last = history[-1][1]
            if last.any:
                return self._find(last, robot.found)
        table, corner, allowed = robot._prefer
        keys = self._keys
        cells = state.cells
        if len(cells) == 1:
            mask = table[corner + keys[cells[0]]] & allowed
        else:
            mask = 0
            for i, cell in enumerate(cells):
                if not robot.found >> i & 1:
                    mask |= table[corner + keys[cell]]
            mask &= allowed
        choices = self._choices[mask]
        return choices[int(self._random() * len(choices))]

    def _find(self, last: SearchObservation, found: int) -> SearchAction:
        if len(self._finds) == 1:
            return self._finds[0]
        for i, cell in enumerate(last.seen):
            if cell >= 0 and not found >> i & 1:
                return self._finds[i]
        return self._finds[0]
