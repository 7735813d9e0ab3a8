"""A belief over the targets' cells, as a pomdp-py distribution on a numpy table per target."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl._cell_axes import in_order
from sloop_ppl.errors import BeliefCollapse, InputError
from sloop_ppl.maps import Grid
from sloop_ppl.planning._pomdp import GenerativeDistribution
from sloop_ppl.planning.pose import Pose
from sloop_ppl.planning.sensors import CellLikelihood, MaskSensor
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import RobotState, SearchAction, SearchObservation, SearchState

__all__ = ["GridBelief", "check_table", "observation_likelihoods"]

# States drawn at a time: a call of numpy costs as much as dozens of numbers.
_BLOCK = 256


class GridBelief(GenerativeDistribution):
    """Independent beliefs over the cells of N targets, with the robot's state known.

    Parameters
    ----------
    space
        The search space.
    tables
        Probability table of each target, keys the space's ids, each of shape (H, W); they are
        normalised.
    robot
        The robot's state.
    rng
        Where samples come from.
    pose
        Where the robot says it is, metres; the middle of its cell when None.

    Raises
    ------
    InputError
        When a table has another shape, is not finite, is negative or sums to zero.
    """

    def __init__(
        self,
        space: SearchSpace,
        tables: Mapping[str, NDArray[np.float64]],
        robot: RobotState,
        *,
        rng: np.random.Generator,
        pose: Pose | None = None,
    ) -> None:
        self.space, self.robot, self._rng = space, robot, rng
        self.pose = space.pose_at(robot.pose) if pose is None else pose
        self._tables = tuple(check_table(t, tables[t], space.grid) for t in space.target_ids)
        self._initial = self._tables
        self._reset()

    def _reset(self) -> None:
        self._cumulative: list[NDArray[np.float64]] | None = None
        self._drawn: list[tuple[int, ...]] = []

    def _after(
        self, tables: tuple[NDArray[np.float64], ...], robot: RobotState, pose: Pose | None
    ) -> GridBelief:
        """Return a belief of other tables that are known to be sound, shape (H * W,)."""
        belief = type(self).__new__(type(self))
        belief.space, belief.robot, belief._rng = self.space, robot, self._rng
        belief.pose = self.space.pose_at(robot.pose) if pose is None else pose
        belief._tables, belief._initial = tables, self._initial
        belief._reset()
        return belief

    @property
    def tables(self) -> dict[str, NDArray[np.float64]]:
        """The probability table of each target, each of shape (H, W), summing to one."""
        return {
            name: table.reshape(self.space.shape)
            for name, table in zip(self.space.target_ids, self._tables, strict=True)
        }

    @property
    def flat(self) -> tuple[NDArray[np.float64], ...]:
        """The probability tables in the order of the ids, each of shape (H * W,)."""
        return self._tables

    @cached_property
    def in_view(self) -> tuple[int, ...]:
        """The cells in view from where the robot says it is, flat indices."""
        if self.pose == self.space.pose_at(self.robot.pose):
            return tuple(self.robot.view)
        return tuple(np.flatnonzero(self.space.view_mask(self.pose)).tolist())

    @cached_property
    def _at_pose(self) -> RobotState:
        """The robot with the view of its own pose, by which a tree search values a find."""
        if self.pose == self.space.pose_at(self.robot.pose):
            return self.robot
        return self.robot.with_view(frozenset(self.in_view))

    @property
    def unseen(self) -> frozenset[int]:
        """The cells that the middle of the robot's cell would show, and its own pose does not."""
        return self.robot.view.difference(self.in_view)

    def random(self) -> SearchState:
        """Draw a state: each target's cell by binary search in its cumulative sum."""
        if not self._drawn:
            self._draw()
        return SearchState(self._at_pose, self._drawn.pop())

    def _draw(self) -> None:
        if self._cumulative is None:
            self._cumulative = [np.cumsum(table) for table in self._tables]
        uniform = self._rng.random((len(self._tables), _BLOCK))
        columns = [
            # Scaled by the last sum, which rounding may leave off one.
            np.searchsorted(total, u * total[-1], side="right").tolist()
            for total, u in zip(self._cumulative, uniform, strict=True)
        ]
        self._drawn = list(zip(*columns, strict=True))

    def mpe(self) -> SearchState:
        """Return the most probable state."""
        return SearchState(self._at_pose, tuple(int(np.argmax(t)) for t in self._tables))

    def __getitem__(self, state: SearchState) -> float:
        if state.robot != self.robot:
            return 0.0
        return math.prod(float(t[c]) for t, c in zip(self._tables, state.cells, strict=True))

    probability = __getitem__

    def updated(
        self,
        action: SearchAction,
        observation: SearchObservation,
        next_robot: RobotState,
        pose: Pose | None = None,
    ) -> GridBelief:
        """Return the exact posterior after one step.

        Parameters
        ----------
        action, observation
            What was done and observed.
        next_robot
            The robot after it.
        pose
            Where the sensor was, metres; the middle of the robot's cell when None.

        Raises
        ------
        BeliefCollapse
            When the observation is impossible under the belief.
        """
        likelihoods = observation_likelihoods(
            self.space, self.robot, action, observation, next_robot, pose
        )
        return self.conditioned(likelihoods, observation, next_robot, pose)

    def conditioned(
        self,
        likelihoods: Sequence[CellLikelihood | None],
        observation: SearchObservation,
        next_robot: RobotState,
        pose: Pose | None = None,
    ) -> GridBelief:
        """Return the posterior given what a step showed of each target; see `updated`."""
        tables = tuple(
            table if seen is None else self._conditioned(i, table, seen, observation)
            for i, (table, seen) in enumerate(zip(self._tables, likelihoods, strict=True))
        )
        return self._after(tables, next_robot, pose)

    def replaced(self, tables: Mapping[str, NDArray[np.float64]]) -> GridBelief:
        """Return a belief with other tables, which are checked, and the same robot."""
        space = self.space
        sound = tuple(check_table(t, tables[t], space.grid) for t in space.target_ids)
        return self._after(sound, self.robot, self.pose)

    def _conditioned(
        self,
        index: int,
        table: NDArray[np.float64],
        seen: CellLikelihood,
        observation: SearchObservation,
    ) -> NDArray[np.float64]:
        new = _product(table, seen)
        weight = self.space.config.recovery_weight
        if weight and not new.any():
            # The initial belief is mixed in only here, where the present one is contradicted.
            new = _product((1 - weight) * table + weight * self._initial[index], seen)
        total = float(new.sum())
        if not 0 < total < math.inf:
            name = self.space.target_ids[index]
            report = observation.seen[index]
            what = "not seen" if report in (-1, None) else f"reported as {report!r}"
            if self.space.sees_mask and report >= 0:
                what = f"seen at cell {divmod(report, self.space.n_cols)}"
            remedy = "" if weight else ", or set recovery_weight to mix in the belief of the start"
            raise BeliefCollapse(
                f"Target '{name}' was {what}, which its belief held impossible; give a belief "
                f"that is nowhere zero{remedy}",
                prior=table.reshape(self.space.shape),
                observation=observation,
            )
        new /= total
        return new


def _product(table: NDArray[np.float64], seen: CellLikelihood) -> NDArray[np.float64]:
    inside = table[seen.cells] * seen.inside
    # p(report | cell) * p(cell): one factor outside the view, one per cell within.
    new: NDArray[np.float64] = table * seen.outside if seen.outside else np.zeros_like(table)
    new[seen.cells] = inside
    return new


def observation_likelihoods(
    space: SearchSpace,
    robot: RobotState,
    action: SearchAction,
    observation: SearchObservation,
    next_robot: RobotState,
    pose: Pose | None = None,
) -> list[CellLikelihood | None]:
    """Return what a step shows of each target's cell; None where it shows nothing.

    Parameters
    ----------
    pose
        Where the sensor was, metres; the middle of the robot's cell when None.
    """
    likelihoods: list[CellLikelihood | None] = []
    cells = space.view_cells(next_robot.pose)
    if pose is not None:
        cells = np.flatnonzero(space.view_mask(pose))
    for i, seen in enumerate(observation.seen):
        bit = 1 << i
        if robot.found & bit:
            likelihoods.append(None)
        elif action.index < 3:
            likelihoods.append(_of_report(space, cells, pose or next_robot.pose, seen))
        elif not robot.looked or not action.marks & bit:
            likelihoods.append(None)
        else:
            # A find is exact: found says in view, not found says elsewhere.
            inside = 1.0 if observation.found & bit else 0.0
            likelihoods.append(CellLikelihood(cells, np.full(len(cells), inside), 1.0 - inside))
    return likelihoods


def _of_report(
    space: SearchSpace, cells: NDArray[np.intp], pose: Pose | int, seen: Any
) -> CellLikelihood:
    """Return the probability of one report by cell."""
    if isinstance(space.sensor, MaskSensor):
        return space.sensor.cell_likelihood(cells, seen)
    where = pose if isinstance(pose, tuple) else space.pose_at(pose)
    log = np.asarray(space.sensor.log_likelihood(where, seen), dtype=np.float64)
    if log.shape != space.shape or np.isnan(log).any() or log.max() == math.inf:
        raise InputError(
            f"The log_likelihood of sensor {type(space.sensor).__name__} has shape {log.shape}; "
            f"expected {space.shape}, without NaN or plus infinity"
        )
    # Scaled to a greatest value of 1, else a log density far below 0 would become 0 everywhere.
    top = float(log.max())
    scaled = np.exp(log - top if top > -math.inf else log)  # a factor of no account
    return CellLikelihood(np.arange(space.n_cells), scaled.reshape(-1), 0.0)


def check_table(name: str, table: NDArray[np.float64], grid: Grid) -> NDArray[np.float64]:
    """Return a belief as a normalised vector of length H * W; xarray is read by coordinate.

    Raises
    ------
    InputError
        When it has another shape, is not finite, is negative or sums to zero.
    """
    found = in_order(table, f"The belief of '{name}'", grid)
    array = np.asarray(found, dtype=np.float64, order="C")
    if array.shape != grid.shape:
        raise InputError(
            f"The belief of '{name}' has shape {array.shape}; the map has {grid.shape}: "
            "it was made on another map or with another cell size"
        )
    total = float(array.sum())
    if not math.isfinite(total) or bool((array < 0).any()) or total <= 0:
        raise InputError(
            f"The belief of '{name}' is not a distribution (sum {total:g}, least "
            f"{float(array.min()):g}); expected finite numbers >= 0 that do not all vanish"
        )
    return (array / total).ravel()
