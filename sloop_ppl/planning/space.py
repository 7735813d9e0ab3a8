"""The search on a grid: where moves lead, what is seen from each pose, and when it is over."""

from __future__ import annotations

import math
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import CityMap, Grid
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.motion import (
    MOVES,
    ExactMotion,
    Motion,
    MoveTable,
    SlippingMotion,
    move_table,
)
from sloop_ppl.planning.obstacles import Offsets, is_blocked, tall_cells, walls_of
from sloop_ppl.planning.pose import HEADINGS, Pose
from sloop_ppl.planning.sensors import (
    FanSensor,
    MaskSensor,
    Sensor,
    check_sensor,
    load_sensor,
)
from sloop_ppl.planning.values import RobotState, SearchAction

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

__all__ = ["MAX_TARGETS", "SearchSpace"]

MAX_TARGETS = 10
"""How many targets can be searched for at once."""


class SearchSpace:
    """What agent and environment know about the map; all of it is computed on demand and kept.

    A pose of the planners has a number, ``(row * n_cols + col) * 8 + heading``: the middle of a
    cell and an eighth of a turn. Sensor and motion are asked at its metres and radians.

    Parameters
    ----------
    grid
        The map's cells, or their number as ``(n_rows, n_cols)``, then of 5 m.
    target_ids
        Names of the targets, distinct, 1 to `MAX_TARGETS`.
    config
        The settings; what it leaves to the size of the map is filled in.
    tall
        Cells of buildings that close flight and sight where the settings ask for it, True where
        they stand, shape (H, W).
    walls
        What these buildings cover, metres, from which flights keep `SearchConfig.clearance_m`.
    sensor
        What the robot senses; the fan of the settings when None.
    motion
        How moves change the pose; the moves of the settings when None.

    Attributes
    ----------
    actions
        The actions in their declared order: forward, left, right, then the finds.
    move_table
        The outcomes of the moves on the grid.

    Raises
    ------
    InputError
        When there is no target or too many, the sensor sees further than the map, or the settings
        ask for something of a sensor or motion that is given.
    """

    def __init__(
        self,
        grid: Grid | tuple[int, int],
        target_ids: tuple[str, ...],
        config: SearchConfig,
        tall: NDArray[np.bool_] | None = None,
        *,
        sensor: Sensor | MaskSensor | None = None,
        motion: Motion | None = None,
        walls: BaseGeometry | None = None,
    ) -> None:
        if not 1 <= len(target_ids) <= MAX_TARGETS:
            raise InputError(
                f"{len(target_ids)} targets were given; expected 1 to {MAX_TARGETS}: "
                "search for the others in a second search"
            )
        self.grid = grid = grid if isinstance(grid, Grid) else _grid_of(*grid)
        self.n_rows, self.n_cols = grid.shape
        self.config = config = config.filled_in(grid.shape)
        # Row-major flat indices throughout: cell = row * n_cols + col.
        self.tall = np.zeros(grid.shape, dtype=bool) if tall is None else tall
        self.no_fly = frozenset(np.flatnonzero(self.tall).tolist() if config.no_fly else ())
        self.walls = walls if config.no_fly and config.clearance_m > 0 else None
        if self.walls is not None:
            self.no_fly |= _cells_near(grid, self.walls, config.clearance_m)
        self.target_ids = target_ids
        self.max_finds = config.max_finds or len(target_ids)
        self.all_found = (1 << len(target_ids)) - 1
        self.actions = _actions(target_ids, config.find_each)
        self._given = sensor, motion
        self.sensor = _fan(grid, config, self.tall) if sensor is None else sensor
        self.motion = _moves(grid.cell_m, config) if motion is None else motion
        if sensor is not None:
            check_sensor(sensor)
            config.refuse_settings_of("sensor", type(sensor).__name__)
        if motion is not None:
            config.refuse_settings_of("motion", type(motion).__name__)
        self.move_table: MoveTable = move_table(self.motion, grid.cell_m)
        self._robots: dict[tuple[int, int, int, bool, bool], RobotState] = {}
        self._views: dict[int, frozenset[int]] = {}
        self._near_walls: dict[tuple[int, int], frozenset[int]] = {}
        self._cells: dict[int, NDArray[np.intp]] = {}

    @classmethod
    def of_city(
        cls,
        city: CityMap,
        target_ids: tuple[str, ...],
        config: SearchConfig,
        *,
        sensor: Sensor | str | None = None,
        motion: Motion | None = None,
    ) -> SearchSpace:
        """Return the space of a map, with its tall buildings where the settings ask for them.

        Parameters
        ----------
        city
            The map.
        target_ids, config, motion
            As in the class.
        sensor
            A sensor, or ``FILE.py:NAME`` of one or of what makes one of the map.
        """
        if isinstance(sensor, str):
            sensor = load_sensor(sensor, city)
        tall = walls = None
        if config.no_fly or config.occlusion:
            tall = tall_cells(city, config.flight_height_m)
        if config.no_fly and config.clearance_m > 0:
            walls = walls_of(city, config.flight_height_m)
        return cls(city.grid, target_ids, config, tall, sensor=sensor, motion=motion, walls=walls)

    @property
    def shape(self) -> tuple[int, int]:
        """``(n_rows, n_cols)`` of the grid."""
        return self.n_rows, self.n_cols

    @property
    def n_cells(self) -> int:
        """Number of cells."""
        return self.n_rows * self.n_cols

    @property
    def moves(self) -> tuple[SearchAction, ...]:
        """Forward, left and right."""
        return self.actions[:3]

    @property
    def finds(self) -> tuple[SearchAction, ...]:
        """The find actions."""
        return self.actions[3:]

    def find(self, target_id: str) -> SearchAction:
        """Return the action that finds a target.

        Raises
        ------
        UnknownName
            When no such target is searched for.
        """
        if target_id not in self.target_ids:
            raise UnknownName("target of a find", target_id, self.target_ids)
        place = self.target_ids.index(target_id)
        return self.finds[place if self.config.find_each else 0]

    def encode(self, row: int, col: int, heading: int) -> int:
        """Return the number of a pose.

        Raises
        ------
        OutsideMap
            When there is no such cell.
        """
        self.grid.check_cell(row, col)
        return (row * self.n_cols + col) * HEADINGS + heading % HEADINGS

    def decode(self, number: int) -> tuple[int, int, int]:
        """Return row, column and heading of a pose."""
        cell, heading = divmod(number, HEADINGS)
        return *divmod(cell, self.n_cols), heading

    def pose_at(self, number: int) -> Pose:
        """Return a pose in metres and radians."""
        row, col, heading = self.decode(number)
        return Pose(*self.grid.centre_of(row, col), heading * 2 * math.pi / HEADINGS)

    def snap(self, pose: Pose) -> int:
        """Return the number of the pose nearest to a continuous one.

        Raises
        ------
        OutsideMap
            When it is off the map.
        """
        row, col = self.grid.cell_covering(pose[0], pose[1])
        return self.encode(row, col, round(pose[2] / (2 * math.pi / HEADINGS)))

    def robot(
        self,
        pose: int,
        found: int = 0,
        finds: int = 0,
        looked: bool = False,
        collided: bool = False,
    ) -> RobotState:
        """Return the robot at a pose; the same object for the same values."""
        key = pose, found, finds, looked, collided
        robot = self._robots.get(key)
        if robot is None:
            robot = self._robots[key] = RobotState(self, *key)
        return robot

    def is_over(self, found: int, finds: int) -> bool:
        """Tell whether the search ends: all found, or no find left."""
        return found == self.all_found or finds >= self.max_finds

    @property
    def stochastic(self) -> bool:
        """Whether moves may slip."""
        return self.move_table.stochastic

    @property
    def sees_mask(self) -> bool:
        """Whether the sensor reports the place of what is in its view."""
        return isinstance(self.sensor, MaskSensor)

    @property
    def hit(self) -> float:
        """Probability of detecting what is in view."""
        return float(getattr(self.sensor, "true_positive_rate", 1.0))

    @cached_property
    def _offsets(self) -> tuple[Offsets, ...] | None:
        self._mask(self.pose_at(0))  # say at once what is wrong with a mask
        return self.sensor.offsets() if isinstance(self.sensor, MaskSensor) else None

    @cached_property
    def fans(self) -> tuple[Offsets, ...]:
        """Rows north and columns east of the cells that can be in view, by heading."""
        if self._offsets is not None:
            return self._offsets
        rows, cols = self.n_rows - 1, self.n_cols - 1
        # The union over all poses of the offsets in view, per heading, for a view that depends on
        # the place.
        planes = np.zeros((HEADINGS, 2 * rows + 1, 2 * cols + 1), dtype=bool)
        for number in range(self.n_cells * HEADINGS):
            row, col, heading = self.decode(number)
            part = planes[heading, rows - row :, cols - col :][: self.n_rows, : self.n_cols]
            part |= self._mask(self.pose_at(number))
        return tuple(
            tuple((int(r) - rows, int(c) - cols) for r, c in np.argwhere(plane)) for plane in planes
        )

    @cached_property
    def hides(self) -> bool:
        """Whether less than the fan may be in view from some pose, the map's border aside."""
        return self.sensor.hides if isinstance(self.sensor, MaskSensor) else True

    def view(self, pose: int) -> frozenset[int]:
        """Return the cells in view from a pose, as flat indices."""
        view = self._views.get(pose)
        if view is None:
            if self._offsets is None or self.hides:
                seen = np.flatnonzero(self._mask(self.pose_at(pose))).tolist()
            else:
                row, col, heading = self.decode(pose)
                seen = [
                    (row + dr) * self.n_cols + col + dc
                    for dr, dc in self._offsets[heading]
                    if 0 <= row + dr < self.n_rows and 0 <= col + dc < self.n_cols
                ]
            view = self._views[pose] = frozenset(seen)
        return view

    def view_cells(self, pose: int) -> NDArray[np.intp]:
        """Return the cells in view from a pose, flat indices in order."""
        cells = self._cells.get(pose)
        if cells is None:
            cells = self._cells[pose] = np.array(sorted(self.view(pose)), dtype=np.intp)
        return cells

    def view_mask(self, pose: int | Pose) -> NDArray[np.bool_]:
        """Return the cells in view as True, shape (H, W), from a pose by number or in metres."""
        if isinstance(pose, tuple):
            number = self.snap(pose)
            if number not in self._views or self.pose_at(number) != pose:
                return self._mask(pose)
            pose = number
        mask = np.zeros(self.n_cells, dtype=bool)
        mask[self.view_cells(pose)] = True
        return mask.reshape(self.shape)

    def _mask(self, pose: Pose) -> NDArray[np.bool_]:
        """Return what the sensor sees from a pose, checked, shape (H, W)."""
        mask = np.asarray(self.sensor.view(pose))
        if mask.shape != self.shape or mask.dtype != bool:
            raise InputError(
                f"The view of sensor {type(self.sensor).__name__} has shape {mask.shape} and type "
                f"{mask.dtype}; expected the map's cells, {self.shape}, as bool"
            )
        return mask

    def blocks(self, pose: int, rows: int, cols: int) -> bool:
        """Tell whether a no-fly building stands in the way of a move by so many cells."""
        if not self.no_fly or not (rows or cols):
            return False
        row, col, _ = self.decode(pose)
        if not (0 <= row + rows < self.n_rows and 0 <= col + cols < self.n_cols):
            return False
        end = (row + rows) * self.n_cols + col + cols
        if end in self.no_fly or is_blocked(self.no_fly, self.n_cols, row, col, rows, cols):
            return True
        return self.walls is not None and row * self.n_cols + col in self._too_near(rows, cols)

    def _too_near(self, rows: int, cols: int) -> frozenset[int]:
        """Return the cells from which a straight flight to an offset comes too near to walls."""
        near = self._near_walls.get((rows, cols))
        if near is None:
            import shapely

            x, y = (a.ravel() for a in np.meshgrid(self.grid.x_m, self.grid.y_m))
            step = self.grid.cell_m
            ends = [[x, x + cols * step], [y, y + rows * step]]
            flights = shapely.linestrings(np.moveaxis(np.array(ends), (0, 1, 2), (2, 1, 0)))
            hit = shapely.dwithin(flights, self.walls, self.config.clearance_m)
            near = self._near_walls[rows, cols] = frozenset(np.flatnonzero(hit).tolist())
        return near

    def displaced(self, pose: int, rows: int, cols: int, turn: int) -> tuple[int, bool]:
        """Return the pose at an offset, and whether a building stopped the robot before it.

        Off the map and behind a no-fly building there is no pose: the robot stays.
        """
        row, col, heading = self.decode(pose)
        if not (0 <= row + rows < self.n_rows and 0 <= col + cols < self.n_cols):
            return pose, False
        if self.blocks(pose, rows, cols):
            return pose, True
        return self.encode(row + rows, col + cols, heading + turn), False

    def moved(self, index: int, pose: int) -> tuple[int, bool]:
        """Return the most probable pose after a move, and whether the robot collides."""
        rows, cols, turn = self.move_table.offsets[index, pose % HEADINGS, 0].tolist()
        return self.displaced(pose, rows, cols, turn)

    def outcomes(self, index: int, pose: int) -> tuple[tuple[float, int, bool], ...]:
        """Return probability, pose and collision of each outcome of a move."""
        table, heading = self.move_table, pose % HEADINGS
        return tuple(
            (chance, *self.displaced(pose, *offset))
            for chance, offset in zip(
                table.chance[index, heading].tolist(),
                table.offsets[index, heading].tolist(),
                strict=True,
            )
            if chance > 0
        )

    def next_pose(self, index: int, pose: int) -> int:
        """Return the most probable pose after a move (0 forward, 1 left, 2 right)."""
        return self.moved(index, pose)[0]

    def preferences(self, pose: int) -> tuple[bytes, int, int]:
        """Return how `preferred_moves` is looked up: table, offset of the pose, allowed moves."""
        row, col, heading = self.decode(pose)
        steps = tuple(tuple(o) for o in self.move_table.offsets[:, heading, 0].tolist())
        table = _preferences(self.shape, heading, steps)
        # Place of offset (-row, -col) in the flat table of (2 H - 1) x (2 W - 1) offsets.
        corner = (self.n_rows - 1 - row) * (2 * self.n_cols - 1) + self.n_cols - 1 - col
        return table, corner, 0b111 if self.next_pose(0, pose) != pose else 0b110

    @cached_property
    def preference_keys(self) -> tuple[int, ...]:
        """What is added to the offset of a pose for each cell, by flat index."""
        skip = self.n_cols - 1
        return tuple(cell + cell // self.n_cols * skip for cell in range(self.n_cells))

    def preferred_moves(self, pose: int, cell: int) -> int:
        """Return the bit mask of the moves preferred for a target in a cell.

        Bit i stands for action i: forward when it brings the robot nearer to the cell, a turn
        when it turns the robot towards it.
        """
        table, corner, allowed = self.preferences(pose)
        return table[corner + self.preference_keys[cell]] & allowed

    def __reduce__(self) -> tuple[Any, ...]:
        sensor, motion = self._given
        made = self.grid, self.target_ids, self.config, self.tall, sensor, motion, self.walls
        return _space, made


def _space(
    grid: Grid,
    target_ids: tuple[str, ...],
    config: SearchConfig,
    tall: NDArray[np.bool_],
    sensor: Sensor | None,
    motion: Motion | None,
    walls: BaseGeometry | None,
) -> SearchSpace:
    return SearchSpace(grid, target_ids, config, tall, sensor=sensor, motion=motion, walls=walls)


def _cells_near(grid: Grid, walls: BaseGeometry, distance_m: float) -> frozenset[int]:
    """Return the cells whose centre is within a distance of walls, as flat indices."""
    import shapely

    x, y = np.meshgrid(grid.x_m, grid.y_m)
    near = shapely.dwithin(shapely.points(x, y), walls, distance_m)
    return frozenset(np.flatnonzero(near).tolist())


def _grid_of(n_rows: int, n_cols: int) -> Grid:
    """Return a grid of so many cells of 5 m, in the middle of nowhere."""
    return Grid(0.0, 0.0, (n_cols - 0.5) * 5.0, (n_rows - 0.5) * 5.0)


def _fan(grid: Grid, config: SearchConfig, tall: NDArray[np.bool_]) -> FanSensor:
    return FanSensor(
        grid,
        config.sensor_range_cells,
        config.sensor_min_range_cells,
        config.fov_deg,
        tall if config.occlusion else None,
        true_positive_rate=config.true_positive_rate,
        false_positive_rate=config.false_positive_rate,
        position_noise_cells=config.position_noise_cells,
    )


def _moves(cell_m: float, config: SearchConfig) -> ExactMotion:
    rates = {
        "stay_rate": config.stay_rate,
        "overshoot_rate": config.overshoot_rate,
        "overturn_rate": config.overturn_rate,
    }
    if any(rates.values()):
        return SlippingMotion(cell_m, config.step_cells, config.turn_deg, **rates)
    return ExactMotion(cell_m, config.step_cells, config.turn_deg)


def _actions(target_ids: tuple[str, ...], find_each: bool) -> tuple[SearchAction, ...]:
    moves = [SearchAction(name, i) for i, name in enumerate(MOVES)]
    if find_each:
        finds = [SearchAction(f"find({t})", 3 + i, 1 << i) for i, t in enumerate(target_ids)]
    else:
        finds = [SearchAction("find", 3, (1 << len(target_ids)) - 1)]
    return tuple(moves + finds)


@lru_cache(maxsize=64)
def _preferences(
    shape: tuple[int, int], heading: int, moves: tuple[tuple[int, int, int], ...]
) -> bytes:
    """Return the preferred moves by offset of the target, rows then columns, as bit masks."""
    step, left_by, right_by = moves[0], moves[1][2], moves[2][2]
    row, col = np.mgrid[-(shape[0] - 1) : shape[0], -(shape[1] - 1) : shape[1]]
    # Squared distances in cells: nearer after the step than before.
    nearer = (row - step[0]) ** 2 + (col - step[1]) ** 2 < row**2 + col**2
    bearing = np.arctan2(row, col) - heading * 2 * np.pi / HEADINGS

    def off(eighths: int) -> NDArray[np.float64]:
        by = eighths * 2 * np.pi / HEADINGS
        # Wrapped to [-pi, pi), then its size.
        wrapped: NDArray[np.float64] = np.abs((bearing - by + np.pi) % (2 * np.pi) - np.pi)
        return wrapped

    here = (row == 0) & (col == 0)
    # 1e-9: a target on the direction half way is nearer by neither.
    left = ~here & (off(left_by) < off(0) - 1e-9)
    right = ~here & (off(right_by) < off(0) - 1e-9)
    return bytes((nearer | left << 1 | right << 2).astype(np.uint8).ravel())
