"""Poses on a grid: where moves lead, what is seen from each, and when the search is over."""

from __future__ import annotations

import math
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.sensing import HEADINGS, cells_between, fan_offsets
from sloop_ppl.planning.values import RobotState, SearchAction

__all__ = ["MAX_TARGETS", "SearchSpace"]

MAX_TARGETS = 10
"""How many targets can be searched for at once."""


class SearchSpace:
    """What agent and environment know about the grid; all of it is computed on demand and kept.

    Parameters
    ----------
    shape : ``(n_rows, n_cols)`` of the grid.
    target_ids : names of the targets, distinct, 1 to `MAX_TARGETS`.
    config : the settings.
    tall : cells of buildings that close flight and sight where the settings ask for it, True where
        they stand, shape (H, W).

    Attributes
    ----------
    actions : the actions in their declared order: forward, left, right, then the finds.
    fans : cells seen from each heading, relative to the robot's.
    steps : rows north and columns east of a step forward by heading.

    Raises
    ------
    InputError : when there is no target or too many, or the sensor sees further than the map.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        target_ids: tuple[str, ...],
        config: SearchConfig,
        tall: NDArray[np.bool_] | None = None,
    ) -> None:
        if not 1 <= len(target_ids) <= MAX_TARGETS:
            raise InputError(
                f"{len(target_ids)} targets were given; expected 1 to {MAX_TARGETS}: "
                "search for the others in a second search"
            )
        if config.sensor_range_cells > max(shape):
            raise InputError(
                f"sensor_range_cells is {config.sensor_range_cells:g}, more than the map, which is "
                f"{shape[0]} x {shape[1]} cells; expected at most {max(shape)}"
            )
        self.n_rows, self.n_cols = shape
        self.tall = np.zeros(shape, dtype=bool) if tall is None else tall
        self.no_fly = frozenset(np.flatnonzero(self.tall).tolist() if config.no_fly else ())
        self._opaque = frozenset(np.flatnonzero(self.tall).tolist() if config.occlusion else ())
        self.target_ids = target_ids
        self.config = config
        self.max_finds = config.max_finds or len(target_ids)
        self.all_found = (1 << len(target_ids)) - 1
        self.actions = _actions(target_ids, config.find_each)
        self._turn = config.turn_deg // 45
        self.fans = tuple(
            fan_offsets(h, config.sensor_range_cells, config.sensor_min_range_cells, config.fov_deg)
            for h in range(HEADINGS)
        )
        self.steps = tuple(_step(h, config.step_cells) for h in range(HEADINGS))
        self._robots: dict[tuple[int, int, int, bool], RobotState] = {}
        self._views: dict[int, frozenset[int]] = {}

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
        UnknownName : when no such target is searched for.
        """
        if target_id not in self.target_ids:
            raise UnknownName("target of a find", target_id, self.target_ids)
        place = self.target_ids.index(target_id)
        return self.finds[place if self.config.find_each else 0]

    def encode(self, row: int, col: int, heading: int) -> int:
        """Return the number of a pose."""
        return (row * self.n_cols + col) * HEADINGS + heading

    def decode(self, pose: int) -> tuple[int, int, int]:
        """Return row, column and heading of a pose."""
        cell, heading = divmod(pose, HEADINGS)
        return *divmod(cell, self.n_cols), heading

    def robot(self, pose: int, found: int = 0, finds: int = 0, looked: bool = False) -> RobotState:
        """Return the robot at a pose; the same object for the same values."""
        key = pose, found, finds, looked
        robot = self._robots.get(key)
        if robot is None:
            robot = self._robots[key] = RobotState(self, *key)
        return robot

    def is_over(self, found: int, finds: int) -> bool:
        """Tell whether the search ends: all found, or no find left."""
        return found == self.all_found or finds >= self.max_finds

    def view(self, pose: int) -> frozenset[int]:
        """Return the cells seen from a pose, as flat indices."""
        view = self._views.get(pose)
        if view is None:
            row, col, heading = self.decode(pose)
            view = self._views[pose] = frozenset(
                (row + dr) * self.n_cols + col + dc
                for dr, dc in self.fans[heading]
                if 0 <= row + dr < self.n_rows
                and 0 <= col + dc < self.n_cols
                and not (self._opaque and self._blocked(self._opaque, row, col, dr, dc))
            )
        return view

    def _blocked(self, closed: frozenset[int], row: int, col: int, dr: int, dc: int) -> bool:
        """Tell whether closed cells stand between a cell and another one."""
        return any(
            all((row + r) * self.n_cols + col + c in closed for r, c in choices)
            for choices in cells_between(dr, dc)
        )

    def view_mask(self, pose: int) -> NDArray[np.bool_]:
        """Return the cells seen from a pose as True, shape (H, W)."""
        mask = np.zeros(self.n_cells, dtype=bool)
        mask[list(self.view(pose))] = True
        return mask.reshape(self.shape)

    def next_pose(self, index: int, pose: int) -> int:
        """Return the pose after a move (0 forward, 1 left, 2 right); a blocked step leaves it."""
        row, col, heading = self.decode(pose)
        if index == 0:
            row, col = row + self.steps[heading][0], col + self.steps[heading][1]
            inside = 0 <= row < self.n_rows and 0 <= col < self.n_cols
            return self.encode(row, col, heading) if inside and not self.collides(pose) else pose
        turn = self._turn if index == 1 else -self._turn
        return self.encode(row, col, (heading + turn) % HEADINGS)

    def collides(self, pose: int) -> bool:
        """Tell whether a step forward would hit a no-fly building, without leaving the map."""
        if not self.no_fly:
            return False
        row, col, heading = self.decode(pose)
        dr, dc = self.steps[heading]
        if not (0 <= row + dr < self.n_rows and 0 <= col + dc < self.n_cols):
            return False
        end = (row + dr) * self.n_cols + col + dc
        return end in self.no_fly or self._blocked(self.no_fly, row, col, dr, dc)

    def preferences(self, pose: int) -> tuple[bytes, int, int]:
        """Return how `preferred_moves` is looked up: table, offset of the pose, allowed moves."""
        row, col, heading = self.decode(pose)
        table = _preferences(self.shape, heading, self.steps[heading], self._turn)
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
        return SearchSpace, (self.shape, self.target_ids, self.config, self.tall)


def _actions(target_ids: tuple[str, ...], find_each: bool) -> tuple[SearchAction, ...]:
    moves = [SearchAction(name, i) for i, name in enumerate(("forward", "left", "right"))]
    if find_each:
        finds = [SearchAction(f"find({t})", 3 + i, 1 << i) for i, t in enumerate(target_ids)]
    else:
        finds = [SearchAction("find", 3, (1 << len(target_ids)) - 1)]
    return tuple(moves + finds)


def _step(heading: int, step_cells: int) -> tuple[int, int]:
    """Return the rows north and columns east of a step, each rounded to whole cells."""
    angle = heading * 2 * math.pi / HEADINGS
    return round(step_cells * math.sin(angle)), round(step_cells * math.cos(angle))


@lru_cache(maxsize=64)
def _preferences(shape: tuple[int, int], heading: int, step: tuple[int, int], turn: int) -> bytes:
    """Return the preferred moves by offset of the target, rows then columns, as bit masks."""
    row, col = np.mgrid[-(shape[0] - 1) : shape[0], -(shape[1] - 1) : shape[1]]
    nearer = (row - step[0]) ** 2 + (col - step[1]) ** 2 < row**2 + col**2
    bearing = np.arctan2(row, col) - heading * 2 * np.pi / HEADINGS
    angle = turn * 2 * np.pi / HEADINGS

    def off(by: float) -> NDArray[np.float64]:
        wrapped: NDArray[np.float64] = np.abs((bearing - by + np.pi) % (2 * np.pi) - np.pi)
        return wrapped

    here = (row == 0) & (col == 0)
    left = ~here & (off(angle) < off(0.0) - 1e-9)
    right = ~here & (off(-angle) < off(0.0) - 1e-9)
    return bytes((nearer | left << 1 | right << 2).astype(np.uint8).ravel())
