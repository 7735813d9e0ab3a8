"""Settings of a search, with the paper's values as defaults."""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Integral

from sloop_ppl.errors import InputError, UnknownName

__all__ = ["ROLLOUTS", "SearchConfig"]

ROLLOUTS = ("published", "random", "informed")
"""Rollout policies of the tree search; ``informed`` is for the planner ``fast`` alone."""

COUNTS = ("sims", "depth", "step_cells", "max_steps", "max_finds", "tree_depth")
REWARDS = ("move_reward", "right_find_reward", "wrong_find_reward", "collision_reward")


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
    occlusion : tall buildings hide what is behind them.
    true_positive_rate : probability of detecting a target in view, in [0, 1].
    false_positive_rate : probability of reporting, where no detection was made, any cell in view,
        in [0, 1).
    position_noise_cells : standard deviation of the reported cell of a detection, cells, >= 0;
        the report stays within the view.
    no_fly : tall buildings cannot be flown over.
    flight_height_m : buildings at least this tall are tall, metres.
    move_reward, right_find_reward, wrong_find_reward : rewards of a move or turn, of a find that
        marks a new target, and of one that marks none.
    collision_reward : reward of a step forward into a no-fly building, which leaves the pose.
    recovery_weight : share of the initial belief that is mixed in when an observation is
        impossible under the present one, in [0, 1); with 0 it raises `BeliefCollapse`.
    find_each : one find action per target (the paper's ``Find(i)``) instead of one for all.
    max_finds : finds after which the search ends; the number of targets when None.
    max_steps : steps after which the search ends.
    sims : simulations per step, > 0.
    depth : how many steps a simulation looks ahead, > 0.
    discount : discount factor per step, in (0, 1].
    exploration : weight of the exploration bonus in UCB1, >= 0.
    tree_depth : levels of the search tree that are kept in `PlanInfo`, for those who ask why.
    rollout : one of `ROLLOUTS`; None takes the planner's own: ``published`` for ``pouct`` and
        ``pomcp``, ``informed`` for ``fast``.
    hedge : share of the belief that the planner ``fast`` with rollout ``informed`` replaces by the
        belief's eighth power before it plans, in [0, 1]: beliefs from language are often less sure
        than they could be. 0 takes the belief at its word. Other planners do so always.

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
    occlusion: bool = False
    true_positive_rate: float = 1.0
    false_positive_rate: float = 0.0
    position_noise_cells: float = 0.0
    no_fly: bool = False
    flight_height_m: float = 10.0
    move_reward: float = -10.0
    right_find_reward: float = 1000.0
    wrong_find_reward: float = -1000.0
    collision_reward: float = -1000.0
    recovery_weight: float = 0.0
    find_each: bool = False
    max_finds: int | None = None
    max_steps: int = 200
    sims: int = 1000
    depth: int = 30
    discount: float = 0.95
    exploration: float = 1000.0
    tree_depth: int = 0
    rollout: str | None = None
    hedge: float = 0.3

    def __post_init__(self) -> None:
        for name in COUNTS:
            self._make_whole(name)
        for name in REWARDS:
            if not math.isfinite(getattr(self, name)):
                raise InputError(f"{name} is {getattr(self, name)}; expected a finite number")
        if self.turn_deg not in (45, 90):
            raise InputError(f"turn_deg is {self.turn_deg}; expected 45 or 90")
        object.__setattr__(self, "turn_deg", int(self.turn_deg))
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
        for name in ("true_positive_rate", "hedge"):
            if not 0 <= getattr(self, name) <= 1:
                raise InputError(f"{name} is {getattr(self, name)}; expected a number in [0, 1]")
        for name in ("false_positive_rate", "recovery_weight"):
            if not 0 <= getattr(self, name) < 1:
                raise InputError(f"{name} is {getattr(self, name)}; expected a number in [0, 1)")
        for name in ("position_noise_cells", "flight_height_m"):
            if not 0 <= getattr(self, name) < math.inf:
                raise InputError(f"{name} is {getattr(self, name)}; expected a number >= 0")
        if self.rollout is not None and self.rollout not in ROLLOUTS:
            raise UnknownName("rollout", self.rollout, ROLLOUTS)

    def _make_whole(self, name: str) -> None:
        """Turn a count of another type of whole number, such as numpy's, into an int."""
        value, least = getattr(self, name), 0 if name == "tree_depth" else 1
        if value is None and name == "max_finds":
            return
        if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
            raise InputError(f"{name} is {value}; expected a whole number of at least {least}")
        object.__setattr__(self, name, int(value))

    @property
    def noisy(self) -> bool:
        """Whether the sensor errs."""
        exact = self.true_positive_rate == 1 and self.position_noise_cells == 0
        return not exact or self.false_positive_rate > 0
