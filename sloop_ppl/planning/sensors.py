"""What a robot senses from a pose: the protocol, sensors that see a mask, and the paper's fan.

Legend: H, W grid; K cells in view.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError, OutsideMap
from sloop_ppl.maps import CityMap, Grid
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.obstacles import Offsets, is_blocked
from sloop_ppl.planning.pose import HEADINGS, Pose
from sloop_ppl.user_file import load_from_file

__all__ = [
    "CellLikelihood",
    "FanSensor",
    "MaskSensor",
    "Sensor",
    "check_sensor",
    "checked_reports",
    "fan_offsets",
    "is_hashable",
    "load_sensor",
]

Place = tuple[float, float]

# Takes rounding out of comparisons between distances (cells) and angles (radians).
_SLACK = 1e-9


@runtime_checkable
class Sensor(Protocol):
    """What a search asks of a sensor.

    Notes
    -----
    A report is what the sensor says of one target after a move; None says that it did not detect
    it. The tree searches branch on reports, so they must be hashable, and a number must be rounded
    to few values.
    """

    def view(self, pose: Pose) -> NDArray[np.bool_]:
        """Return the cells in which a find marks a target, True where it does, shape (H, W)."""
        ...

    def log_likelihood(self, pose: Pose, report: Any) -> NDArray[np.float64]:
        """Return log p(report | target's cell, pose), shape (H, W); minus infinity allowed."""
        ...

    def sample(self, pose: Pose, places: Mapping[str, Place], rng: Any) -> Mapping[str, Any]:
        """Return a report of each target, drawn given its place (x and y in metres)."""
        ...


class CellLikelihood(NamedTuple):
    """Probability of what was observed of one target, given its cell.

    Attributes
    ----------
    cells
        The cells in view, flat indices, shape (K,).
    inside
        Probability at each of them, shape (K,).
    outside
        Probability at every other cell.
    """

    cells: NDArray[np.intp]
    inside: NDArray[np.float64]
    outside: float

    def log_table(self, shape: tuple[int, int]) -> NDArray[np.float64]:
        """Return the natural log as a table over the grid, shape (H, W); minus infinity allowed."""
        table = np.full(shape[0] * shape[1], self.outside)
        table[self.cells] = self.inside
        with np.errstate(divide="ignore"):
            log: NDArray[np.float64] = np.log(table)
        return log.reshape(shape)


class MaskSensor(ABC):
    """A sensor that reports at which place it detects what is in its view.

    A subclass says what is in view. A target in view is detected with the true positive rate; the
    reported cell is drawn among the cells in view with weights ``exp(-d ** 2 / (2 sigma ** 2))``
    of the distance d in cells from its own. Where nothing was detected, any cell in view is
    reported with the false positive rate.

    Parameters
    ----------
    grid
        The map's cells, or the map.
    true_positive_rate
        Probability of detecting a target in view, in [0, 1].
    false_positive_rate
        Probability of a report where nothing was detected, in [0, 1).
    position_noise_cells
        Sigma of the reported cell, cells, >= 0.

    Raises
    ------
    InputError
        When a rate or the noise is out of its range.

    Attributes
    ----------
    relative
        True where the view moves and turns with the robot, depends on nothing else, and fits into
        the map around its centre cell: the tables of the planners are then made from eight views
        instead of one per pose.
    """

    relative: bool = False

    def __init__(
        self,
        grid: Grid | CityMap,
        *,
        true_positive_rate: float = 1.0,
        false_positive_rate: float = 0.0,
        position_noise_cells: float = 0.0,
    ) -> None:
        self.grid = grid.grid if isinstance(grid, CityMap) else grid
        # Checked by the settings' own rules, so that both refuse alike.
        SearchConfig(
            true_positive_rate=true_positive_rate,
            false_positive_rate=false_positive_rate,
            position_noise_cells=position_noise_cells,
        )  # says which of them is out of its range
        self.true_positive_rate = true_positive_rate
        self.false_positive_rate = false_positive_rate
        self.position_noise_cells = position_noise_cells

    @abstractmethod
    def view(self, pose: Pose) -> NDArray[np.bool_]:
        """Return the cells in view, True where seen, shape (H, W)."""

    def log_likelihood(self, pose: Pose, report: Place | None) -> NDArray[np.float64]:
        """Return log p(report | target's cell, pose), shape (H, W)."""
        return self.likelihood(pose, report).log_table(self.grid.shape)

    def likelihood(self, pose: Pose, report: Place | None) -> CellLikelihood:
        """Return p(report | target's cell, pose) on the cells in view and elsewhere."""
        cells = np.flatnonzero(self.view(pose))
        return self.cell_likelihood(cells, self.cell_of(report))

    def sample(self, pose: Pose, places: Mapping[str, Place], rng: Any) -> dict[str, Place | None]:
        """Return where each target is reported: the centre of a cell in metres, or None.

        Parameters
        ----------
        pose
            The robot's pose.
        places
            Target -> x and y, metres.
        rng
            Has a method `random`.
        """
        cells = np.flatnonzero(self.view(pose))
        in_view = frozenset(cells.tolist())
        reports: dict[str, Place | None] = {}
        for target, place in places.items():
            seen = self.sample_cell(cells, in_view, self.cell_of(place), rng)
            row, col = divmod(seen, self.grid.n_cols)
            reports[target] = None if seen < 0 else self.grid.centre_of(row, col)
        return reports

    def cell_of(self, report: Place | None) -> int:
        """Return the flat index of the cell that holds a place; -1 for None.

        Raises
        ------
        InputError
            When it is no place on the map.
        """
        if report is None:
            return -1
        try:
            x, y = (float(v) for v in report)
            row, col = self.grid.cell_covering(x, y)
        except OutsideMap:
            raise
        except (TypeError, ValueError):
            raise InputError(
                f"The report {report!r} is no place; expected (x_m, y_m) or None"
            ) from None
        return row * self.grid.n_cols + col

    @property
    def exact(self) -> bool:
        """Whether the sensor never errs."""
        certain = self.true_positive_rate == 1 and self.position_noise_cells == 0
        return certain and self.false_positive_rate == 0

    def offsets(self) -> tuple[Offsets, ...] | None:
        """Return ``(rows north, columns east)`` of what can be in view, by heading.

        Returns
        -------
        tuple or None
            One tuple of offsets for each of the eight headings; None where the view depends on
            the place, so that it must be asked for at every pose.
        """
        if not self.relative:
            return None
        # One view a heading from the middle of the map; a relative view is the same anywhere else.
        row, col = self.grid.n_rows // 2, self.grid.n_cols // 2
        centre = self.grid.centre_of(row, col)
        fans = []
        for heading in range(HEADINGS):
            mask = np.asarray(self.view(Pose(*centre, heading * 2 * math.pi / HEADINGS)))
            if mask.shape != self.grid.shape:
                return None  # whoever asks for a view says so
            fans.append(tuple((int(r) - row, int(c) - col) for r, c in np.argwhere(mask)))
        reach = max((max(abs(r), abs(c)) for fan in fans for r, c in fan), default=0)
        # A view that touches the border of the map may have been cut off there.
        return tuple(fans) if reach < min(row, col) else None

    @property
    def hides(self) -> bool:
        """Whether less than the offsets may be in view from some pose, the map's border aside."""
        return self.offsets() is None

    def sample_cell(
        self, cells: NDArray[np.intp], in_view: frozenset[int], cell: int, rng: Any
    ) -> int:
        """Return the cell at which a target in `cell` is reported, or -1.

        Parameters
        ----------
        cells, in_view
            The cells in view, flat indices, as an ordered array and as a set.
        cell
            The target's cell.
        rng
            Has a method `random`.
        """
        if cell in in_view and (self.exact or rng.random() < self.true_positive_rate):
            if not self.position_noise_cells:
                return cell
            weights = self._spread(cells, cell)
            # Inverse of the cumulative weights; sum * u, because they need not sum to exactly one.
            return int(cells[np.searchsorted(np.cumsum(weights), rng.random() * weights.sum())])
        false = self.false_positive_rate
        if false and len(cells) and rng.random() < false:
            return int(cells[int(rng.random() * len(cells))])
        return -1

    def cell_likelihood(self, cells: NDArray[np.intp], seen: int) -> CellLikelihood:
        """Return the probability of a report by the target's cell.

        Parameters
        ----------
        cells
            The cells in view, flat indices in order, shape (K,).
        seen
            The reported cell, or -1.
        """
        n, hit = len(cells), self.true_positive_rate
        false = self.false_positive_rate if n else 0.0
        if seen < 0:
            # Not reported: in view, missed and no false report; out of view, no false report.
            missed = (1.0 - hit) * (1.0 - false)
            return CellLikelihood(cells, np.full(n, missed), 1.0 - false)
        at = cells == seen
        if not at.any():
            return CellLikelihood(cells, np.zeros(n), 0.0)
        if self.position_noise_cells:
            reported = np.array([self._spread(cells, int(c))[at][0] for c in cells])
        else:
            reported = at.astype(np.float64)
        # p(seen | cell) = h * spread(seen | cell) + (1 - h) * f / K in view, and f / K elsewhere.
        inside = hit * reported + (1.0 - hit) * false / n
        return CellLikelihood(cells, inside, false / n)

    def _spread(self, cells: NDArray[np.intp], cell: int) -> NDArray[np.float64]:
        """Return the probabilities with which the cells in view are reported, shape (K,)."""
        row, col = divmod(cell, self.grid.n_cols)
        rows, cols = np.divmod(cells, self.grid.n_cols)
        square = (rows - row) ** 2 + (cols - col) ** 2
        # Truncated to the view, so normalised over it: a cell near its border spreads inwards.
        weights = np.exp(-square / (2 * self.position_noise_cells**2))
        spread: NDArray[np.float64] = weights / math.fsum(weights)
        return spread


class FanSensor(MaskSensor):
    """The paper's sensor: a fan before the robot; occluded where tall cells are given.

    Parameters
    ----------
    grid
        The map's cells.
    range_cells, min_range_cells
        Distances from the robot to the centres that are seen, cells, closed.
    fov_deg
        Opening of the fan, degrees, in (0, 360]; its borders are seen.
    tall
        Cells that hide what is behind them, True where they do, shape (H, W); none when None.
    **rates
        As in `MaskSensor`.

    Raises
    ------
    InputError
        When the sensor sees further than the map is wide.

    Notes
    -----
    Source: SLOOP's published code (90 degrees; the text has 45). A cell is seen past tall ones when
    none stands strictly between; where the line from the robot's cell runs along the border of
    two cells, both must be tall to hide it.

    Examples
    --------
    >>> from sloop_ppl.maps import load_map
    >>> from sloop_ppl.planning import Pose
    >>> sensor = FanSensor(load_map("cleveland").grid)
    >>> int(sensor.view(Pose(2.5, 2.5, 0.0)).sum())  # cells in view, looking east
    9
    """

    def __init__(
        self,
        grid: Grid,
        range_cells: float = 3.0,
        min_range_cells: float = 1.0,
        fov_deg: float = 90.0,
        tall: NDArray[np.bool_] | None = None,
        **rates: float,
    ) -> None:
        super().__init__(grid, **rates)
        if range_cells > max(grid.shape):
            raise InputError(
                f"sensor_range_cells is {range_cells:g}, more than the map, which is "
                f"{grid.n_rows} x {grid.n_cols} cells; expected at most {max(grid.shape)}"
            )
        self.range_cells, self.min_range_cells = range_cells, min_range_cells
        self.fov_deg = fov_deg
        self._tall = frozenset() if tall is None else frozenset(np.flatnonzero(tall).tolist())

    def view(self, pose: Pose) -> NDArray[np.bool_]:
        """Return the cells in view, True where seen, shape (H, W)."""
        # Only cells within reach are tested, one more for a pose between cells.
        grid, reach = self.grid, self.range_cells + 1.0
        col = (pose.x_m - grid.x_m[0]) / grid.cell_m
        row = (pose.y_m - grid.y_m[0]) / grid.cell_m
        rows = slice(max(math.ceil(row - reach), 0), max(math.floor(row + reach) + 1, 0))
        cols = slice(max(math.ceil(col - reach), 0), max(math.floor(col + reach) + 1, 0))
        north = (grid.y_m[rows, None] - pose.y_m) / grid.cell_m
        east = (grid.x_m[None, cols] - pose.x_m) / grid.cell_m
        mask = np.zeros(grid.shape, dtype=bool)
        mask[rows, cols] = _in_fan(
            north, east, pose.heading_rad, self.range_cells, self.min_range_cells, self.fov_deg
        )
        if self._tall:
            self._hide(mask, round(row), round(col))
        return mask

    def offsets(self) -> tuple[Offsets, ...]:
        """Return the fan by heading; tall cells may hide some of it."""
        return tuple(
            fan_offsets(h, self.range_cells, self.min_range_cells, self.fov_deg)
            for h in range(HEADINGS)
        )

    @property
    def hides(self) -> bool:
        """Whether tall cells may hide some of the fan."""
        return bool(self._tall)

    def _hide(self, mask: NDArray[np.bool_], row: int, col: int) -> None:
        """Take out of a mask what tall cells hide from a cell."""
        n_cols = self.grid.n_cols
        for r, c in np.argwhere(mask).tolist():
            if is_blocked(self._tall, n_cols, row, col, r - row, c - col):
                mask[r, c] = False


def fan_offsets(
    heading: int, range_cells: float, min_range_cells: float = 1.0, fov_deg: float = 90.0
) -> Offsets:
    """Return the cells in a fan, relative to the robot's cell.

    Parameters
    ----------
    heading
        Direction of the fan's axis in eighths of a turn, anticlockwise from east.
    range_cells, min_range_cells
        Distances between cell centres that are seen, cells, closed.
    fov_deg
        Opening of the fan, degrees, in (0, 360]; its borders are seen.

    Returns
    -------
    tuple
        ``(rows north, columns east)`` of each cell seen, ordered by row, then column.

    Examples
    --------
    >>> fan_offsets(0, range_cells=1)
    ((0, 1),)
    >>> fan_offsets(1, range_cells=1)
    ((0, 1), (1, 0))
    """
    reach = math.floor(range_cells + _SLACK)
    # _SLACK: a range of 3 must still see cells at a distance of exactly 3.
    along = np.arange(-reach, reach + 1)
    axis = heading * 2 * math.pi / HEADINGS
    seen = _in_fan(along[:, None], along[None, :], axis, range_cells, min_range_cells, fov_deg)
    return tuple((int(r) - reach, int(c) - reach) for r, c in np.argwhere(seen))


def _in_fan(
    north: NDArray[Any],
    east: NDArray[Any],
    axis_rad: float,
    range_cells: float,
    min_range_cells: float,
    fov_deg: float,
) -> NDArray[np.bool_]:
    """Tell which points, given in cells from the robot, lie in a fan; shapes broadcast."""
    distance = np.hypot(north, east)
    off_axis = np.arctan2(north, east) - axis_rad
    # Wrapped to [-pi, pi): the fan may straddle the direction west.
    off_axis = np.abs((off_axis + math.pi) % (2 * math.pi) - math.pi)
    near = (min_range_cells - _SLACK <= distance) & (distance <= range_cells + _SLACK)
    seen: NDArray[np.bool_] = near & (
        (distance < _SLACK) | (off_axis <= math.radians(fov_deg) / 2 + _SLACK)
    )
    return seen


def is_hashable(value: object) -> bool:
    """Tell whether the tree searches can branch on a report."""
    try:
        hash(value)
    except TypeError:
        return False
    return True


def checked_reports(sensor: object, reports: Any) -> dict[str, Any]:
    """Return what a sensor's `sample` gave, or say what is wrong with it.

    Raises
    ------
    InputError
        When it is no mapping, or a report cannot be hashed.
    """
    kind = type(sensor).__name__
    if not isinstance(reports, Mapping):
        raise InputError(
            f"The sample of sensor {kind} is {reports!r}; expected a mapping from target to report"
        )
    for name, report in reports.items():
        if not is_hashable(report):
            raise InputError(
                f"The report of '{name}' by sensor {kind} is a {type(report).__name__}, which "
                "cannot be hashed; expected a number, a tuple or None"
            )
    return dict(reports)


def check_sensor(sensor: object) -> None:
    """Refuse what is no sensor: a class, or what lacks one of the methods."""
    if isinstance(sensor, type) or not isinstance(sensor, Sensor):
        raise InputError(f"The sensor is a {type(sensor).__name__}; expected {_WANTED}")


_WANTED = (
    "an object with the methods view(pose), log_likelihood(pose, report) and "
    "sample(pose, places, rng), such as a MaskSensor"
)


def load_sensor(spec: str, city: CityMap) -> Sensor:
    """Return the sensor that a file holds.

    Parameters
    ----------
    spec
        ``FILE.py:NAME`` of a sensor, or of a class or function that makes one of a map.

    Raises
    ------
    UnknownName
        When the file has nothing of that name.
    InputError
        When the file does not exist or fails, or NAME is something else.
    """
    methods = ("view", "log_likelihood", "sample")
    file = load_from_file(
        spec,
        "Sensor",
        _WANTED,
        lambda value: isinstance(value, Sensor),
        (city,),
    )
    sensor: Sensor = file.guard(file.value, methods)
    return sensor
