"""Where a search takes place: the protocol, and the simulated grid of the paper."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError, OutsideMap
from sloop_ppl.maps import Grid
from sloop_ppl.planning.pose import HEADINGS, Pose, as_pose
from sloop_ppl.planning.sensors import MaskSensor, checked_reports, is_hashable
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import RobotState, SearchAction, SearchObservation
from sloop_ppl.rng import child, scalar_rng

__all__ = [
    "Environment",
    "GridEnvironment",
    "Outcome",
    "Report",
    "SearchEnded",
    "checked_outcome",
    "given_places",
    "observation_of",
    "robot_after",
    "start_pose",
    "true_cells",
]

Place = tuple[float, float]


@dataclass(frozen=True)
class Report:
    """What an environment tells after an action.

    Parameters
    ----------
    seen
        Target -> what the sensor reports of it after a move: its place in metres for a sensor that
        sees a mask. None, or no entry, where it was not detected.
    found
        Targets that a find marked.

    Raises
    ------
    InputError
        When `seen` is no mapping, or `found` no collection of names.
    """

    seen: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    found: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.seen, Mapping):
            raise InputError(
                f"What a report has seen is {self.seen!r}; expected a mapping from target to what "
                "the sensor reports"
            )
        names: object = self.found
        if isinstance(names, str) or not isinstance(names, Iterable):
            raise InputError(
                f"What a report has found is {self.found!r}; expected the names of targets in a "
                "tuple"
            )
        object.__setattr__(self, "found", tuple(names))


class Outcome(NamedTuple):
    """What came of an action; a plain tuple of three will do.

    Parameters
    ----------
    pose
        Where the robot is, as far as it knows: metres and radians. It may differ from the planned
        pose; beliefs follow it, planners start from the cell that covers it.
    report
        What was sensed and found.
    collision
        Whether the robot ran into something.
    """

    pose: Pose
    report: Report
    collision: bool = False


class SearchEnded(Exception):
    """The robot cannot go on: raised by `Environment.execute`, it ends the search as it stands.

    Parameters
    ----------
    reason
        Why, as a sentence for the notes of the episode, such as "The battery is empty".
    """

    def __init__(self, reason: str) -> None:
        self.reason = reason
        super().__init__(reason)


@runtime_checkable
class Environment(Protocol):
    """What a search asks of a simulator or a robot.

    Attributes
    ----------
    pose
        Where the robot is before the first action; metres and radians.
    """

    pose: Pose

    def execute(self, action: SearchAction) -> Outcome:
        """Carry out an action, whose `name` tells it, and return what came of it.

        Raises
        ------
        SearchEnded
            When the robot cannot go on; the episode then ends with what was done before.
        """
        ...


class GridEnvironment:
    """The simulated environment of the paper: targets stand still, moves and sensor are sampled.

    Parameters
    ----------
    space
        The search space, with sensor and motion.
    places
        True place of each target, x and y in metres.
    start
        Where the robot begins.
    rng
        Where moves and reports are drawn from.

    Attributes
    ----------
    pose
        Where the robot is; continuous, as the motion leaves it.

    Notes
    -----
    A move off the map or through a no-fly building leaves the pose; the latter is a collision. A
    find before the first look marks nothing.
    """

    def __init__(
        self,
        space: SearchSpace,
        places: Mapping[str, Place],
        start: Pose,
        *,
        rng: np.random.Generator,
    ) -> None:
        self.pose = start
        self._space, self._rng = space, rng
        # the masks' own draws are scalar, which the standard library does ten times faster
        masked = getattr(type(space.sensor), "sample", None) is MaskSensor.sample
        self._sensor_rng = scalar_rng(rng) if masked else rng
        cells = true_cells(space.target_ids, places, space.grid)
        self._cells = dict(zip(space.target_ids, cells, strict=True))
        # a target is anywhere in its cell, for the sensor in the middle of it
        self._places = {
            name: space.grid.centre_of(*divmod(cell, space.n_cols))
            for name, cell in self._cells.items()
        }
        self._found: set[str] = set()
        self._looked = False

    def execute(self, action: SearchAction) -> Outcome:
        """Carry out a move or a find and return pose, report and collision."""
        if action.index >= 3:
            return Outcome(self.pose, Report(found=self._find(action)))
        collision = self._move(action.name)
        self._looked = True
        hidden = {t: place for t, place in self._places.items() if t not in self._found}
        seen = self._space.sensor.sample(self.pose, hidden, self._sensor_rng)
        reports = checked_reports(self._space.sensor, seen)
        return Outcome(self.pose, Report(MappingProxyType(reports)), collision)

    def _move(self, action: str) -> bool:
        """Change the pose, unless something is in the way, and tell whether it was a building."""
        space = self._space
        after = as_pose(
            space.motion.sample(self.pose, action, self._rng), f"The pose after '{action}'"
        )
        # Buildings are cells: what stands in the way is looked up between the cells of both ends.
        row, col, _ = space.decode(space.snap(self.pose))
        try:
            end_row, end_col, _ = space.decode(space.snap(after))
        except OutsideMap:
            return False
        if space.blocks(space.encode(row, col, 0), end_row - row, end_col - col):
            return True
        self.pose = _settled(space, after)
        return False

    def _find(self, action: SearchAction) -> tuple[str, ...]:
        if not self._looked:
            return ()
        view = self._space.view_mask(self.pose).reshape(-1)
        new = tuple(
            name
            for i, (name, cell) in enumerate(self._cells.items())
            if action.marks >> i & 1 and view[cell] and name not in self._found
        )
        self._found.update(new)
        return new


def _settled(space: SearchSpace, pose: Pose) -> Pose:
    """Return a pose without the rounding errors of many moves from one cell's middle to another."""
    near = space.pose_at(space.snap(pose))
    # 1e-6 m or radians: far below a cell, far above what thousands of moves add up.
    turn = math.remainder(pose[2] - near[2], 2 * math.pi)
    off = max(abs(pose[0] - near[0]), abs(pose[1] - near[1]), abs(turn))
    return near if off < 1e-6 else pose


def checked_outcome(space: SearchSpace, action: SearchAction, outcome: Any) -> Outcome:
    """Return what an environment reports of an action, or say what is wrong with it.

    Raises
    ------
    OutsideMap
        When the pose is off the map.
    InputError
        When it is no pose, report and collision, or speaks of something that is not searched for.
    """
    try:
        pose, report, collision = outcome
    except (TypeError, ValueError):
        raise InputError(
            f"The environment returned {outcome!r} for '{action.name}'; expected "
            "(pose, report, collision)"
        ) from None
    pose = as_pose(pose, "The pose that the environment reports")
    try:
        space.snap(pose)
    except OutsideMap as error:
        raise OutsideMap(f"The environment reports a pose off the map: {error}") from None
    if isinstance(report, Mapping):
        report = Report(report)
    if report is None:
        report = Report()
    if not isinstance(report, Report):
        raise InputError(
            f"The environment's report is {report!r}; expected a Report, or a mapping from target "
            "to what the sensor reports"
        )
    for name in (*report.seen, *report.found):
        if name not in space.target_ids:
            raise InputError(
                f"The environment reports of '{name}'; expected one of the targets: "
                f"{', '.join(space.target_ids)}"
            )
    for name in report.found:
        if not action.marks >> space.target_ids.index(name) & 1:
            raise InputError(
                f"The environment reports that '{action.name}' found '{name}', which it does not "
                "look for; expected finds alone to find"
            )
    for name, seen in report.seen.items():
        if isinstance(space.sensor, MaskSensor):
            try:
                space.sensor.cell_of(seen)
            except InputError as error:
                raise type(error)(f"The environment's report of '{name}': {error}") from None
        elif not is_hashable(seen):
            raise InputError(
                f"The environment's report of '{name}' is a {type(seen).__name__}, which cannot be "
                "hashed; expected a number, a tuple or None"
            )
    return Outcome(pose, report, bool(collision))


def robot_after(
    space: SearchSpace, robot: RobotState, action: SearchAction, outcome: Outcome
) -> RobotState:
    """Return the robot as the planners see it: in the cell that covers the reported pose."""
    pose = space.snap(outcome.pose)
    if action.index < 3:
        return space.robot(pose, robot.found, robot.finds, True, outcome.collision)
    # One bit for each target, in the order of the ids.
    marks = sum(1 << space.target_ids.index(name) for name in outcome.report.found)
    return space.robot(pose, robot.found | marks, robot.finds + 1, robot.looked)


def observation_of(
    space: SearchSpace, action: SearchAction, robot: RobotState, outcome: Outcome
) -> SearchObservation:
    """Return what was reported as the trees know it."""
    if action.index >= 3:
        return SearchObservation((-1,) * len(space.target_ids), robot.found)
    pose = robot.pose if space.stochastic else -1
    reports = [
        None if robot.found >> i & 1 else outcome.report.seen.get(name)
        for i, name in enumerate(space.target_ids)
    ]
    if isinstance(space.sensor, MaskSensor):
        cells = tuple(space.sensor.cell_of(report) for report in reports)
        return SearchObservation(cells, robot.found, pose)
    # What is in view is not told by such a report, so a find is worth considering after each.
    return SearchObservation(tuple(reports), robot.found, pose, some=True)


def true_cells(ids: tuple[str, ...], places: Mapping[str, Place], grid: Grid) -> tuple[int, ...]:
    """Return the flat index of each target's cell.

    Raises
    ------
    OutsideMap
        When a place is outside the map.
    InputError
        When places and targets do not fit each other.
    """
    _refuse_no_mapping(places)
    for name in (*ids, *places):
        if name not in places or name not in ids:
            raise InputError(
                f"'{name}' has {'no place' if name not in places else 'no belief'}; expected a "
                f"place for each of: {', '.join(ids)}"
            )
    cells = []
    for name in ids:
        x, y = _numbers(f"The place of '{name}'", places[name], (2,))
        try:
            row, col = grid.cell_at(x, y)
        except OutsideMap as error:
            raise OutsideMap(f"Target '{name}': {error}") from None
        cells.append(row * grid.n_cols + col)
    return tuple(cells)


def given_places(places: Mapping[str, Place], ids: tuple[str, ...]) -> dict[str, Place]:
    """Return the places of those targets of which they are told, for the record alone.

    Raises
    ------
    InputError
        When one is no place, or is of something that is not searched for.
    """
    _refuse_no_mapping(places)
    given = {}
    for name, place in places.items():
        if name not in ids:
            raise InputError(
                f"'{name}' has no belief; expected places of none but: {', '.join(ids)}"
            )
        x, y = _numbers(f"The place of '{name}'", place, (2,))
        given[name] = x, y
    return given


def _refuse_no_mapping(places: object) -> None:
    if not isinstance(places, Mapping):
        raise InputError(
            f"The places are {places!r}; expected a mapping from target to x and y in metres"
        )


def start_pose(
    start: tuple[float, ...] | None,
    space: SearchSpace,
    rng: np.random.Generator,
    area: NDArray[np.bool_] | None = None,
) -> Pose:
    """Return where the robot begins, in the middle of a cell.

    Parameters
    ----------
    start
        x and y in metres and, if given, heading in degrees, a multiple of 45; or a `Pose`, taken
        as it is; when None, any cell that is free, heading east.
    rng
        Where the cell is drawn from, by its own child stream.
    area
        True for the cells it may be drawn from, shape (H, W); all when None.

    Raises
    ------
    OutsideMap
        When it is outside the map.
    InputError
        When it is no start, inside a no-fly building, or no cell of the area is free.
    """
    closed, grid = space.no_fly, space.grid
    if start is None:
        # Cells, not places: the draw is the same for every planner, sensor and belief.
        cells = range(space.n_cells) if area is None else np.flatnonzero(area).tolist()
        free = [cell for cell in cells if cell not in closed]
        if not free:
            raise InputError(
                "No cell of the area is free to start in; give a start, a larger area, or fly "
                f"above {space.config.flight_height_m:g} m"
            )
        return space.pose_at(free[int(child(rng, "start").integers(len(free)))] * HEADINGS)
    x, y, *heading = _numbers("The start", start, (2, 3))
    try:
        at = grid.cell_covering if isinstance(start, Pose) else grid.cell_at
        row, col = at(x, y)
    except OutsideMap as error:
        raise OutsideMap(f"Start: {error}") from None
    if row * space.n_cols + col in closed:
        raise InputError(
            f"Start ({x:g}, {y:g}) is inside a no-fly building; start elsewhere, or fly above "
            f"{space.config.flight_height_m:g} m"
        )
    if isinstance(start, Pose):
        return start
    eighths = heading[0] / 45.0 if heading else 0.0
    if eighths != round(eighths):
        raise InputError(
            f"The start's heading is {heading[0]:g}; expected a multiple of 45 degrees, "
            "anticlockwise from east"
        )
    return space.pose_at(space.encode(row, col, round(eighths)))


def _numbers(what: str, value: object, lengths: tuple[int, ...]) -> list[float]:
    """Return a tuple of finite numbers, or say what is wrong with it."""
    try:
        numbers = [float(v) for v in value]  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) not in lengths or not all(math.isfinite(v) for v in numbers):
        form = "x, y" if lengths == (2,) else "x, y or x, y, heading"
        raise InputError(f"{what} is {value!r}; expected {form} as finite numbers")
    return numbers
