"""Settings of a search, with the paper's values as defaults."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from numbers import Integral

from sloop_ppl.errors import InputError, UnknownName

__all__ = ["ROLLOUTS", "SearchConfig"]

ROLLOUTS = ("published", "random", "informed")
"""Rollout policies of the tree search; ``informed`` is for the planner ``fast`` alone."""

# 200 m in cells of 5 m, floor(200 / 5) + 1; SLOOP sec. V.
PAPER_SIDE_CELLS = 41
"""Side of the paper's maps, cells; steps and horizon grow with maps that are larger."""

COUNTS = ("sims", "depth", "step_cells", "max_steps", "max_finds", "tree_depth")
SLIPS = ("stay_rate", "overshoot_rate", "overturn_rate")
REWARDS = ("move_reward", "right_find_reward", "wrong_find_reward", "collision_reward")


_SETTINGS_OF = {
    "sensor": (
        "sensor_range_cells", "sensor_min_range_cells", "fov_deg", "occlusion",
        "true_positive_rate", "false_positive_rate", "position_noise_cells",
    ),
    "motion": ("step_cells", "turn_deg", *SLIPS),
}  # fmt: skip


@dataclass(frozen=True)
class SearchConfig:
    """Settings of one search; agent and environment share them all.

    Parameters
    ----------
    sensor_range_cells
        How far the sensor sees, cells, >= `sensor_min_range_cells`.
    sensor_min_range_cells
        How near the sensor sees, cells; 1 leaves out the robot's own cell.
    fov_deg
        Opening of the fan, degrees, in (0, 360].
    step_cells
        Length of a forward move, cells; on the diagonals each axis is rounded.
    turn_deg
        How far a turn goes, degrees, 45 or 90.
    occlusion
        Tall buildings hide what is behind them.
    true_positive_rate
        Probability of detecting a target in view, in [0, 1].
    false_positive_rate
        Probability of reporting, where no detection was made, any cell in view, in [0, 1).
    position_noise_cells
        Standard deviation of the reported cell of a detection, cells, >= 0; the report stays within
        the view.
    no_fly
        Tall buildings cannot be flown over.
    flight_height_m
        Buildings at least this tall are tall, metres.
    clearance_m
        With `no_fly`, how far a straight flight keeps from tall buildings, metres, >= 0; with 0
        cells alone count, whose centre is in a building or not.
    move_reward, right_find_reward, wrong_find_reward
        Rewards of a move or turn, of a find that marks a new target, and of one that marks none.
    collision_reward
        Reward of a step forward into a no-fly building, which leaves the pose.
    recovery_weight
        Share of the initial belief that is mixed in when an observation is impossible under the
        present one, in [0, 1); with 0 it raises `BeliefCollapse`.
    find_each
        One find action per target (the paper's ``Find(i)``) instead of one for all.
    max_finds
        Finds after which the search ends; the number of targets when None.
    max_steps
        Steps after which the search ends; None for 200, more on a map of more than 41 cells a side.
    stay_rate, overshoot_rate, overturn_rate
        Probabilities that a move or turn does nothing, that a step goes one cell further, that a
        turn goes twice as far, in [0, 1).
    sims
        Simulations per step, > 0.
    depth
        How many steps a simulation looks ahead, > 0; None for 30, more on a larger map, as far as
        the discount leaves something to be looked for.
    discount
        Discount factor per step, in (0, 1].
    exploration
        Weight of the exploration bonus in UCB1, >= 0.
    tree_depth
        Levels of the search tree that are kept in `PlanInfo`, for those who ask why.
    rollout
        One of `ROLLOUTS`; None takes the planner's own: ``published`` for ``pouct`` and ``pomcp``,
        ``informed`` for ``fast``.
    hedge
        Share of the belief that the planner ``fast`` with rollout ``informed`` replaces by the
        belief's eighth power before it plans, in [0, 1]: beliefs from language are often less sure
        than they could be. 0 takes the belief at its word. Other planners do so always.

    Raises
    ------
    InputError
        When a value is out of its range; the message names it.

    Notes
    -----
    Source: SLOOP sec. VI (moves, rewards) and its published code (fan of 90 degrees; the text
    has 45). The published agent plans at -2 a move while its environment charges 11; here both
    charge the paper's 10.

    Examples
    --------
    >>> from dataclasses import replace
    >>> far = replace(SearchConfig(), sensor_range_cells=5)
    >>> far.sensor_range_cells, far.discount
    (5, 0.95)
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
    clearance_m: float = 0.0
    move_reward: float = -10.0
    right_find_reward: float = 1000.0
    wrong_find_reward: float = -1000.0
    collision_reward: float = -1000.0
    recovery_weight: float = 0.0
    find_each: bool = False
    max_finds: int | None = None
    max_steps: int | None = None
    sims: int = 1000
    depth: int | None = None
    discount: float = 0.95
    exploration: float = 1000.0
    tree_depth: int = 0
    rollout: str | None = None
    hedge: float = 0.3
    stay_rate: float = 0.0
    overshoot_rate: float = 0.0
    overturn_rate: float = 0.0

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
        for name in ("false_positive_rate", "recovery_weight", *SLIPS):
            if not 0 <= getattr(self, name) < 1:
                raise InputError(f"{name} is {getattr(self, name)}; expected a number in [0, 1)")
        for name in ("position_noise_cells", "flight_height_m", "clearance_m"):
            if not 0 <= getattr(self, name) < math.inf:
                raise InputError(f"{name} is {getattr(self, name)}; expected a number >= 0")
        if self.rollout is not None and self.rollout not in ROLLOUTS:
            raise UnknownName("rollout", self.rollout, ROLLOUTS)

    def _make_whole(self, name: str) -> None:
        """Turn a count of another type of whole number, such as numpy's, into an int."""
        value, least = getattr(self, name), 0 if name == "tree_depth" else 1
        if value is None and name in ("max_finds", "max_steps", "depth"):
            return
        if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
            raise InputError(f"{name} is {value}; expected a whole number of at least {least}")
        object.__setattr__(self, name, int(value))

    def filled_in(self, shape: tuple[int, int]) -> SearchConfig:
        """Return the settings with steps and horizon for a map of so many cells.

        Parameters
        ----------
        shape
            ``(n_rows, n_cols)`` of the map.

        Notes
        -----
        Both grow with the side of the map: 200 and 30 are the paper's, for 41 cells. The horizon
        ends where ``discount ** depth`` falls below a hundredth.
        """
        if self.max_steps is not None and self.depth is not None:
            return self
        # Ways grow with the side of the map, so steps and horizon grow as it does.
        scale = max(1.0, max(shape) / PAPER_SIDE_CELLS)
        # g ** depth < 0.01: what lies beyond changes no decision; without discount there is no such
        # end.
        most = math.inf if self.discount == 1 else math.log(0.01) / math.log(self.discount)
        depth = max(30, math.ceil(min(30 * scale, most)))
        return replace(
            self,
            max_steps=self.max_steps or math.ceil(200 * scale),
            depth=self.depth or depth,
        )

    def size_notes(self, given: SearchConfig) -> tuple[str, ...]:
        """Say which steps and horizon the size of the map has set, if not the paper's.

        Parameters
        ----------
        given
            The settings before `filled_in`.
        """
        lines = []
        if given.max_steps is None and self.max_steps != 200:
            lines.append(f"{self.max_steps} steps at most (max_steps)")
        if given.depth is None and self.depth != 30:
            lines.append(f"a horizon of {self.depth} steps (depth)")
        return (f"set by the size of the map: {', '.join(lines)}",) if lines else ()

    def refuse_settings_of(self, what: str, kind: str) -> None:
        """Refuse settings of the fan, or of the moves, where another takes its place.

        Parameters
        ----------
        what
            ``"sensor"`` or ``"motion"``.
        kind
            What takes its place, for the message.

        Raises
        ------
        InputError
            When one is not at its default; the message names it.
        """
        defaults = {f.name: f.default for f in fields(self)}
        for name in _SETTINGS_OF[what]:
            if getattr(self, name) != defaults[name]:
                raise InputError(
                    f"{name} is {getattr(self, name)}, but the {what} is a {kind}, which has its "
                    f"own; leave {name} out, or the {what}"
                )

    @property
    def horizon(self) -> int:
        """How many steps are looked ahead; 30 where the map has not filled it in."""
        return self.depth or 30

    @property
    def step_limit(self) -> int:
        """After how many steps a search ends; 200 where the map has not filled it in."""
        return self.max_steps or 200
