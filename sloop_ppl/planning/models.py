"""The models of the search: how states, observations, rewards and actions follow."""

from __future__ import annotations

import math
import random
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from sloop_ppl.planning._pomdp import (
    ObservationModel,
    PolicyModel,
    RewardModel,
    RolloutPolicy,
    TransitionModel,
)
from sloop_ppl.planning.sensors import MaskSensor, checked_reports
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import RobotState, SearchAction, SearchObservation, SearchState

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

    Parameters
    ----------
    space
        The search space, by which the planner ``fast`` knows the domain.
    rng
        Where the slips of a stochastic motion are drawn from; an exact one needs none.
    """

    def __init__(self, space: SearchSpace, rng: random.Random | None = None) -> None:
        self.space = space
        self._rng = random.Random(0) if rng is None else rng
        self._stochastic = space.stochastic

    @cached_property
    def native(self) -> NativeSearch:
        """The search as the planner ``fast`` runs it."""
        from sloop_ppl.planning._search_kernel import NativeSearch

        return NativeSearch(self.space)

    def sample(self, state: SearchState, action: SearchAction) -> SearchState:
        """Return a state that follows; it is certain unless moves slip."""
        robot = state.robot
        if robot.ended:
            return state
        index = action.index
        if index < 3:
            if self._stochastic:
                return SearchState(self._slipped(robot, index), state.cells)
            return SearchState(robot._next[index] or robot.moved(index), state.cells)
        return self._found(state, action)

    def argmax(self, state: SearchState, action: SearchAction) -> SearchState:
        """Return the most probable state that follows."""
        if state.robot.ended:
            return state
        if action.index < 3:
            return SearchState(state.robot.moved(action.index), state.cells)
        return self._found(state, action)

    def probability(
        self, next_state: SearchState, state: SearchState, action: SearchAction
    ) -> float:
        """Return the probability that a state follows."""
        robot = state.robot
        if robot.ended or action.index >= 3 or not self._stochastic:
            return float(next_state == self.argmax(state, action))
        if next_state.cells != state.cells:
            return 0.0
        return sum(
            chance
            for chance, pose, collided in self.space.outcomes(action.index, robot.pose)
            if next_state.robot == robot.at(pose, collided)
        )

    def _slipped(self, robot: RobotState, index: int) -> RobotState:
        """Return the robot after one outcome of a move, drawn from the motion's own outcomes."""
        space, rest = self.space, self._rng.random()
        outcomes = space.outcomes(index, robot.pose)
        for chance, pose, collided in outcomes:
            rest -= chance
            if rest < 0.0:
                return robot.at(pose, collided)
        return robot.at(*outcomes[-1][1:])

    def _found(self, state: SearchState, action: SearchAction) -> SearchState:
        robot, marks = state.robot, 0
        if robot.looked:
            for i, cell in enumerate(state.cells):
                if cell in robot.view:
                    marks |= 1 << i
        return SearchState(robot.marked(marks & action.marks), state.cells)


class SearchObservationModel(ObservationModel):
    """After a move the robot senses its view; a find shows what has been found.

    Parameters
    ----------
    space
        The search space.
    rng
        Where the errors of a sensor are drawn from; an exact one needs none.
    """

    def __init__(self, space: SearchSpace, rng: random.Random | None = None) -> None:
        self._space = space
        self._nothing: tuple[Any, ...] = (-1,) * len(space.target_ids)
        self._blank = [SearchObservation(self._nothing, m) for m in range(space.all_found + 1)]
        self._made: dict[tuple[tuple[int, ...], int, int], SearchObservation] = {}
        self._sensor = space.sensor
        self._mask = space.sensor if isinstance(space.sensor, MaskSensor) else None
        self._stochastic = space.stochastic
        self._plain = self._mask is not None and self._mask.exact and not self._stochastic
        self._rng = random.Random(0) if rng is None else rng
        self._generator: np.random.Generator | None = None

    def sample(self, next_state: SearchState, action: SearchAction) -> SearchObservation:
        """Return what is observed on reaching a state."""
        robot = next_state.robot
        if action.index >= 3:
            return self._blank[robot.found]
        if self._plain and robot.view.isdisjoint(next_state.cells):
            return self._blank[robot.found]  # most of a rollout comes this way
        if self._mask is None:
            return self._reported(next_state)
        exact = self._mask.exact
        seen = self._in_view(next_state) if exact else self._sensed(self._mask, next_state)
        # One object per observation: the trees of pomdp-py compare them, identical ones at no cost.
        key = seen, robot.found, robot.pose if self._stochastic else -1
        made = self._made.get(key)
        if made is None:
            made = self._made[key] = SearchObservation(*key)
        return made

    def argmax(self, next_state: SearchState, action: SearchAction) -> SearchObservation:
        """Return what an exact sensor observes on reaching a state."""
        if action.index >= 3:
            return self._blank[next_state.robot.found]
        pose = next_state.robot.pose if self._stochastic else -1
        return SearchObservation(self._in_view(next_state), next_state.robot.found, pose)

    def probability(
        self, observation: SearchObservation, next_state: SearchState, action: SearchAction
    ) -> float:
        """Return the probability (density, of a sensor with densities) of an observation."""
        robot = next_state.robot
        if observation.found != robot.found:
            return 0.0
        if action.index >= 3:
            return float(observation.seen == self._nothing)
        if self._stochastic and observation.pose != robot.pose:
            return 0.0
        chance = 1.0
        for i, (cell, seen) in enumerate(zip(next_state.cells, observation.seen, strict=True)):
            if robot.found >> i & 1:
                # A found target is not reported any more.
                chance *= float(seen in (-1, None))
            else:
                chance *= self._chance(robot, cell, seen)
        return chance

    def _chance(self, robot: RobotState, cell: int, seen: Any) -> float:
        if self._mask is None:
            table = self._sensor.log_likelihood(self._space.pose_at(robot.pose), seen)
            return math.exp(float(table.reshape(-1)[cell]))
        cells = self._space.view_cells(robot.pose)
        likelihood = self._mask.cell_likelihood(cells, seen)
        if cell not in robot.view:
            return likelihood.outside
        return float(likelihood.inside[likelihood.cells == cell][0])

    def _in_view(self, state: SearchState) -> tuple[int, ...]:
        view, found = state.robot.view, state.robot.found
        return tuple(
            cell if cell in view and not found >> i & 1 else -1
            for i, cell in enumerate(state.cells)
        )

    def _sensed(self, sensor: MaskSensor, state: SearchState) -> tuple[int, ...]:
        robot, cells = state.robot, self._space.view_cells(state.robot.pose)
        return tuple(
            -1 if robot.found >> i & 1 else sensor.sample_cell(cells, robot.view, cell, self._rng)
            for i, cell in enumerate(state.cells)
        )

    def _reported(self, state: SearchState) -> SearchObservation:
        """Return what a sensor that sees no mask reports; a rollout knows what is in view."""
        robot, space = state.robot, self._space
        if self._generator is None:
            # Sensors of users want a generator of numpy; seeded by the stream of the rollouts.
            self._generator = np.random.default_rng(self._rng.getrandbits(63))
        places = {
            name: space.grid.centre_of(*divmod(cell, space.n_cols))
            for i, (name, cell) in enumerate(zip(space.target_ids, state.cells, strict=True))
            if not robot.found >> i & 1
        }
        sampled = self._sensor.sample(space.pose_at(robot.pose), places, self._generator)
        reports = checked_reports(self._sensor, sampled)
        return SearchObservation(
            tuple(reports.get(name) for name in space.target_ids),
            robot.found,
            robot.pose if self._stochastic else -1,
            some=any(
                cell in robot.view and not robot.found >> i & 1
                for i, cell in enumerate(state.cells)
            ),
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
        return self.of(state.robot, action, next_state.robot)

    argmax = sample

    def of(self, robot: RobotState, action: SearchAction, after: RobotState) -> float:
        """Return the reward of a step, which needs nothing but the robot before and after it."""
        if robot.ended:
            return 0.0
        if action.index < 3:
            return self._collision if after.collided else self._move
        return self._right if after.found != robot.found else self._wrong


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
            # By bit mask of the preferred moves, none of them meaning any.
            tuple(m for m in moves if mask >> m.index & 1) or moves
            for mask in range(8)
        )
        self._finds = space.finds
        self._keys = space.preference_keys
        self._mask = space.sees_mask
        self._random = rng.random

    def rollout(self, state: SearchState, history: History | None = None) -> SearchAction:
        """Return the next action of a rollout."""
        robot = state.robot
        if robot.ended:
            return self._finds[0]
        if history:
            last = history[-1][1]
            if last.any:
                return self._find(last, state)
        table, corner, allowed = robot._prefer or robot.preferences
        keys = self._keys
        cells = state.cells
        if len(cells) == 1:
            mask = table[corner + keys[cells[0]]] & allowed
        else:
            mask = 0
            for i, cell in enumerate(cells):
                if not robot.found >> i & 1:
                    # A move is preferred that serves any target that is left.
                    mask |= table[corner + keys[cell]]
            mask &= allowed
        choices = self._choices[mask]
        return choices[int(self._random() * len(choices))]

    def _find(self, last: SearchObservation, state: SearchState) -> SearchAction:
        """Return the find of the first unfound target that was seen, or is in view."""
        if len(self._finds) == 1:
            return self._finds[0]
        robot = state.robot
        for i, (seen, cell) in enumerate(zip(last.seen, state.cells, strict=True)):
            there = seen >= 0 if self._mask else cell in robot.view
            if there and not robot.found >> i & 1:
                return self._finds[i]
        return self._finds[0]
