"""How moves change the pose: the protocol, the paper's exact moves, and moves that slip.

A motion knows nothing of the map: a move off the map or into a building is stopped by whoever
knows it. Legend: A = 3 moves; O outcomes of a move.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.planning.pose import HEADINGS, Pose, as_pose

__all__ = [
    "MOVES",
    "ExactMotion",
    "FiniteMotion",
    "Motion",
    "MoveTable",
    "SlippingMotion",
    "move_table",
]

MOVES = ("forward", "left", "right")
"""Names of the moves, in the order of their numbers."""

EIGHTH = 2 * math.pi / HEADINGS
"""Angle between neighbouring headings of the planners, radians."""

DRAWS = 1000
"""Draws per move and heading from which the outcomes of a motion that only draws are estimated."""

_SLACK = 1e-6


@runtime_checkable
class Motion(Protocol):
    """What a search asks of a motion; poses are continuous, moves are named as in `MOVES`."""

    def sample(self, pose: Pose, action: str, rng: Any) -> Pose:
        """Return the pose after a move, drawn with ``rng.random()`` or more."""
        ...

    def log_probability(self, next_pose: Pose, pose: Pose, action: str) -> float:
        """Return log p(next pose | pose, move)."""
        ...


class FiniteMotion(ABC):
    """A motion whose moves have few outcomes, which move and turn with the robot."""

    @abstractmethod
    def outcomes(self, pose: Pose, action: str) -> tuple[tuple[float, Pose], ...]:
        """Return probability and pose of each outcome of a move; the probabilities sum to one."""

    def sample(self, pose: Pose, action: str, rng: Any) -> Pose:
        """Return one of the outcomes; nothing is drawn where there is one alone."""
        outcomes = self.outcomes(pose, action)
        if len(outcomes) == 1:
            return outcomes[0][1]
        # Inverse of the cumulative probabilities; rounding may leave the last one a little short.
        rest = rng.random()
        for chance, after in outcomes:
            rest -= chance
            if rest < 0.0:
                return after
        return outcomes[-1][1]

    def log_probability(self, next_pose: Pose, pose: Pose, action: str) -> float:
        """Return log p(next pose | pose, move); outcomes that coincide are added up."""
        total = math.fsum(
            chance
            for chance, after in self.outcomes(pose, action)
            if math.dist(after[:2], next_pose[:2]) < _SLACK
            and abs(math.remainder(after[2] - next_pose[2], 2 * math.pi)) < _SLACK
        )
        return math.log(total) if total > 0 else -math.inf


class ExactMotion(FiniteMotion):
    """The paper's moves without error: some cells forward, a turn left, a turn right.

    Parameters
    ----------
    cell_m
        Side of a cell, metres.
    step_cells
        Length of a forward move, cells; on the diagonals each axis is rounded to whole cells.
    turn_deg
        How far a turn goes, degrees.

    Notes
    -----
    Source: SLOOP sec. VI. Between two of the eight headings a step is that of the nearer one,
    turned by the difference.

    Examples
    --------
    >>> from sloop_ppl.planning import Pose
    >>> ExactMotion(cell_m=5.0).outcomes(Pose(2.5, 2.5, 0.0), "forward")
    ((1.0, Pose(x_m=17.5, y_m=2.5, heading_rad=0.0)),)
    """

    def __init__(self, cell_m: float = 5.0, step_cells: int = 3, turn_deg: float = 45.0) -> None:
        self.cell_m, self.step_cells, self.turn_deg = cell_m, step_cells, turn_deg

    def outcomes(self, pose: Pose, action: str) -> tuple[tuple[float, Pose], ...]:
        """Return the one outcome."""
        return ((1.0, self._moved(pose, action, self.step_cells, 1.0)),)

    def _moved(self, pose: Pose, action: str, step_cells: int, turns: float) -> Pose:
        """Return the pose after a step of so many cells, or so many turns."""
        x, y, heading = pose
        if action == "forward":
            # Rounded per axis, as the published code does: 3 cells diagonally are 2 north and 2
            # east.
            eighths = round(heading / EIGHTH)
            angle = eighths * EIGHTH
            north = round(step_cells * math.sin(angle)) * self.cell_m
            east = round(step_cells * math.cos(angle)) * self.cell_m
            # A heading between two eighths turns the step of the nearer one by what is left.
            off = heading - angle
            if abs(off) > _SLACK:
                east, north = (
                    east * math.cos(off) - north * math.sin(off),
                    east * math.sin(off) + north * math.cos(off),
                )
            return Pose(x + east, y + north, heading)
        if action not in MOVES:
            raise InputError(f"'{action}' is no move; expected one of: {', '.join(MOVES)}")
        turn = math.radians(self.turn_deg) * turns * (1 if action == "left" else -1)
        return Pose(x, y, (heading + turn) % (2 * math.pi))


class SlippingMotion(ExactMotion):
    """The paper's moves with errors: they stay, overshoot, or turn too far.

    Parameters
    ----------
    cell_m, step_cells, turn_deg
        As in `ExactMotion`.
    stay_rate
        Probability that a move or turn does nothing.
    overshoot_rate
        Probability that a step goes one cell further.
    overturn_rate
        Probability that a turn goes twice as far.

    Raises
    ------
    InputError
        When rates are no probabilities, or leave nothing for the move itself.

    Notes
    -----
    Source: SLOOP sec. III-A, "possibly stochastic" moves; the paper's experiments have exact ones.
    """

    def __init__(
        self,
        cell_m: float = 5.0,
        step_cells: int = 3,
        turn_deg: float = 45.0,
        *,
        stay_rate: float = 0.0,
        overshoot_rate: float = 0.0,
        overturn_rate: float = 0.0,
    ) -> None:
        super().__init__(cell_m, step_cells, turn_deg)
        for name, rate in {
            "overshoot_rate": overshoot_rate,
            "overturn_rate": overturn_rate,
        }.items():
            if not (0 <= stay_rate < 1 and 0 <= rate < 1 and stay_rate + rate < 1):
                raise InputError(
                    f"{name} is {rate:g} and stay_rate {stay_rate:g}; expected numbers in [0, 1) "
                    "that sum to less than 1"
                )
        self.stay_rate = stay_rate
        self.overshoot_rate, self.overturn_rate = overshoot_rate, overturn_rate

    def outcomes(self, pose: Pose, action: str) -> tuple[tuple[float, Pose], ...]:
        """Return the move itself, no move, and too much of it, where they can happen."""
        too_far = self.overshoot_rate if action == "forward" else self.overturn_rate
        further = (self.step_cells + 1, 2.0)
        all_of_them = (
            (1.0 - self.stay_rate - too_far, self._moved(pose, action, self.step_cells, 1.0)),
            (self.stay_rate, pose),
            (too_far, self._moved(pose, action, *further)),
        )
        return tuple((chance, after) for chance, after in all_of_them if chance > 0)


class MoveTable(NamedTuple):
    """The outcomes of each move by heading, on the planners' grid.

    Attributes
    ----------
    offsets
        Rows north, columns east and eighths of a turn, int64, shape (A, 8, O, 3).
    chance
        Probability of each outcome, the most probable first, shape (A, 8, O); sums to one over O.
    exact
        False where it was estimated from draws.
    """

    offsets: NDArray[np.int64]
    chance: NDArray[np.float64]
    exact: bool

    @property
    def stochastic(self) -> bool:
        """Whether some move has more than one outcome."""
        return bool(self.offsets.shape[2] > 1)


def _pairs(outcomes: Any, action: str) -> list[tuple[float, Any]]:
    """Return the outcomes of a move as pairs of probability and pose, or refuse them."""
    try:
        pairs = [(float(chance), after) for chance, after in outcomes]
    except (TypeError, ValueError):
        raise InputError(
            f"The outcomes of '{action}' are {outcomes!r}; expected pairs of probability and pose"
        ) from None
    for chance, _ in pairs:
        if not 0 <= chance <= 1 + _SLACK:
            raise InputError(
                f"An outcome of '{action}' has probability {chance:g}; expected a number in [0, 1]"
            )
    return pairs


def move_table(motion: Motion | FiniteMotion, cell_m: float) -> MoveTable:
    """Return the outcomes of each move from the middle of a cell, snapped to cells and eighths.

    Parameters
    ----------
    motion
        The motion. One that has no `outcomes` is estimated from `DRAWS` draws of a fixed seed.
    cell_m
        Side of a cell, metres.

    Raises
    ------
    InputError
        When it is no motion, a pose is none, or the probabilities do not sum to one.
    """
    exact = callable(getattr(motion, "outcomes", None))
    if isinstance(motion, type) or not isinstance(motion, Motion):
        raise InputError(
            f"The motion is a {type(motion).__name__}; expected an object with the methods "
            "sample(pose, action, rng) and log_probability(next_pose, pose, action), such as a "
            "SlippingMotion"
        )
    # A fixed seed: the planners of one motion have one table in every process.
    rng = np.random.default_rng(0)
    rows: dict[tuple[int, int], list[tuple[tuple[int, int, int], float]]] = {}
    for number, action in enumerate(MOVES):
        for heading in range(HEADINGS):
            pose = Pose(0.0, 0.0, heading * EIGHTH)
            if exact:
                outcomes = _pairs(motion.outcomes(pose, action), action)  # type: ignore[attr-defined]
            else:
                draws = (motion.sample(pose, action, rng) for _ in range(DRAWS))
                outcomes = [(1.0 / DRAWS, after) for after in draws]
            found: dict[tuple[int, int, int], float] = {}
            for p, after in outcomes:
                x, y, angle = as_pose(after, f"The pose after '{action}'")
                turn = round((angle - pose.heading_rad) / EIGHTH) % HEADINGS
                # From the origin: rows north, columns east and eighths turned are the offsets
                # themselves.
                key = round(y / cell_m), round(x / cell_m), turn
                found[key] = found.get(key, 0.0) + p
            if abs(math.fsum(found.values()) - 1.0) > 1e-6:
                raise InputError(
                    f"The outcomes of '{action}' have probabilities that sum to "
                    f"{math.fsum(found.values()):g}; expected 1"
                )
            # The most probable first, because the planners that count one outcome take index 0.
            rows[number, heading] = sorted(found.items(), key=lambda item: -item[1])
    most = max(len(found) for found in rows.values())
    offsets = np.zeros((len(MOVES), HEADINGS, most, 3), dtype=np.int64)
    chance = np.zeros((len(MOVES), HEADINGS, most))
    for (number, heading), outcomes_of in rows.items():
        for place, (offset, p) in enumerate(outcomes_of):
            offsets[number, heading, place], chance[number, heading, place] = offset, p
    return MoveTable(offsets, chance, exact)
