"""Settings of a search, with the paper's values as defaults."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sloop_ppl.errors import InputError, UnknownName

__all__ = ["ROLLOUTS", "SearchConfig"]

ROLLOUTS = ("published", "random")
"""Rollout policies of the tree search."""


@dataclass(frozen=True)
class SearchConfig:
    """Settings of one search; agent and environment share them all.

    Parameters
    ----------
    sensor_range_cells : how far the sensor sees, cells, >= `sensor_min_range_cells`.
    sensor_min_range_cells : how near the sensor sees, cells; 1 leaves out the robot's own cell.
    fov_deg : opening of the fan, degrees, in (0, 360].
    step_cells : length of a forward move, cells; on the diagonals each axis is rounded.
    turn_deg : how far a turn goes, degrees, 45 or 90.
    move_reward, right_find_reward, wrong_find_reward : rewards of a move or turn, of a find that
        marks a new target, and of one that marks none.
    find_each : one find action per target (the paper's ``Find(i)``) instead of one for all.
    max_finds : finds after which the search ends; the number of targets when None.
    max_steps : steps after which the search ends.
    sims : simulations per step, > 0.
    depth : how many steps a simulation looks ahead, > 0.
    discount : discount factor per step, in (0, 1].
    exploration : weight of the exploration bonus in UCB1, >= 0.
    rollout : one of `ROLLOUTS`.

    Raises
    ------
    InputError : when a value is out of its range; the message names it.

    Notes
    -----
    Source: SLOOP sec. VI (moves, rewards) and its published code (fan of 90 degrees; the text
    has 45). The published agent plans at -2 a move while its environment charges 11; here both
    charge the paper's 10.
    """

    sensor_range_cells: float = 3.0
    sensor_min_range_cells: float = 1.0
    fov_deg: float = 90.0
    step_cells: int = 3
    turn_deg: int = 45
    move_reward: float = -10.0
    right_find_reward: float = 1000.0
    wrong_find_reward: float = -1000.0
    find_each: bool = False
    max_finds: int | None = None
    max_steps: int = 200
    sims: int = 1000
    depth: int = 30
    discount: float = 0.95
    exploration: float = 1000.0
    rollout: str = "published"

    def __post_init__(self) -> None:
        for name in ("sims", "depth", "step_cells", "max_steps"):
            _check_count(name, getattr(self, name))
        if self.max_finds is not None:
            _check_count("max_finds", self.max_finds)
        for name in ("move_reward", "right_find_reward", "wrong_find_reward"):
            if not math.isfinite(getattr(self, name)):
                raise InputError(f"{name} is {getattr(self, name)}; expected a finite number")
        if self.turn_deg not in (45, 90):
            raise InputError(f"turn_deg is {self.turn_deg}; expected 45 or 90")
        if not 0 < self.fov_deg <= 360:
            raise InputError(f"fov_deg is {self.fov_deg}; expected a number in (0, 360]")
        if not 0 <= self.sensor_min_range_cells <= self.sensor_range_cells < math.inf:
            raise InputError(
                f"sensor_range_cells is {self.sensor_range_cells}; expected a finite number of "
                f"at least sensor_min_range_cells, {self.sensor_min_range_cells}"
            )
        if not 0 < self.discount <= 1:
            raise InputError(f"discount is {self.discount}; expected a number in (0, 1]")
        if not 0 <= self.exploration < math.inf:
            raise InputError(f"exploration is {self.exploration}; expected a number >= 0")
        if self.rollout not in ROLLOUTS:
            raise UnknownName("rollout", self.rollout, ROLLOUTS)


def _check_count(name: str, value: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise InputError(f"{name} is {value}; expected a whole number of at least 1")
