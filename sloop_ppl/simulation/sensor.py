"""The planner's model of the drone's camera: the fan, less what buildings hide at their height.

Legend: H, W grid; R the reach of the fan, cells.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from sloop_ppl.maps import CityMap
from sloop_ppl.planning.obstacles import Offsets, height_m
from sloop_ppl.planning.pose import HEADINGS, Pose
from sloop_ppl.planning.sensors import FanSensor, MaskSensor

__all__ = ["FlightSensor", "SensorRates", "open_share"]

_SLACK_CELLS, _SLACK_DEG = 0.1, 6.0
_TARGET_M = 0.8
_PIXEL_M = 1.0
_LEAST_VISIBLE = 0.5
"""Share of a cell that must be visible for the cell to count as in view."""


@dataclass(frozen=True)
class SensorRates:
    """How often a detector errs, as the planner's sensor model has it.

    Parameters
    ----------
    true_positive
        Probability that a target in view is reported.
    false_positive
        Probability of a report where no target was detected.
    position_noise_cells
        Sigma of the reported cell, cells.
    """

    true_positive: float
    false_positive: float
    position_noise_cells: float


class FlightSensor(MaskSensor):
    """The paper's fan as a camera in the air has it: roofs and walls hide what is behind them.

    Parameters
    ----------
    city
        The map, with heights of its buildings.
    altitude_m
        How high the camera is, metres.
    rates
        How often the detector errs.
    range_cells, min_range_cells, fov_deg
        The fan, as in `sloop_ppl.planning.FanSensor`.

    Notes
    -----
    A cell is in view when the line of sight to half of its points, 0.8 m above the ground, passes
    over every building between; of a cell that is all built on, its roof counts. The fan has a
    tolerance of half a metre and a few degrees, which takes in no further cell from the middle of a
    cell and loses none from beside it.
    """

    def __init__(
        self,
        city: CityMap,
        altitude_m: float,
        rates: SensorRates,
        *,
        range_cells: float = 3.0,
        min_range_cells: float = 1.0,
        fov_deg: float = 90.0,
    ) -> None:
        super().__init__(
            city.grid,
            true_positive_rate=rates.true_positive,
            false_positive_rate=rates.false_positive,
            position_noise_cells=rates.position_noise_cells,
        )
        self.altitude_m, self.rates = altitude_m, rates
        self._fan = FanSensor(
            city.grid,
            range_cells + _SLACK_CELLS,
            max(min_range_cells - _SLACK_CELLS, 0.0),
            min(fov_deg + _SLACK_DEG, 360.0),
        )
        self._reach = math.ceil(range_cells + _SLACK_CELLS)
        self._visible = _visible_cells(city, altitude_m, self._reach)
        side = 2 * self._reach + 1
        self._windows = np.zeros((HEADINGS, side, side), dtype=bool)
        for heading, fan in enumerate(self._fan.offsets()):
            for dr, dc in fan:
                self._windows[heading, dr + self._reach, dc + self._reach] = True

    def view(self, pose: Pose) -> NDArray[np.bool_]:
        """Return the cells in view, True where seen, shape (H, W)."""
        grid, reach = self.grid, self._reach
        row, col = grid.cell_covering(pose[0], pose[1])
        # The window of the table that lies on the map.
        top, left = max(row - reach, 0), max(col - reach, 0)
        end, right = min(row + reach + 1, grid.n_rows), min(col + reach + 1, grid.n_cols)
        part = np.s_[
            top - row + reach : end - row + reach, left - col + reach : right - col + reach
        ]
        eighths = pose[2] / (2 * math.pi / HEADINGS)
        off = abs(pose[0] - grid.x_m[col]) + abs(pose[1] - grid.y_m[row])
        if off + abs(eighths - round(eighths)) < 1e-6:
            # From the middle of a cell, as planners ask a hundred thousand times.
            fan = self._windows[round(eighths) % HEADINGS][part]
        else:
            fan = self._fan.view(pose)[top:end, left:right]
        seen = np.zeros(grid.shape, dtype=bool)
        seen[top:end, left:right] = fan & self._visible[row, col][part]
        return seen

    def offsets(self) -> tuple[Offsets, ...]:
        """Return the fan by heading; buildings may hide some of it."""
        return self._fan.offsets()

    @property
    def hides(self) -> bool:
        """Whether less than the fan may be in view; always True."""
        return True


def open_share(city: CityMap) -> NDArray[np.float64]:
    """Return how much of each cell no building covers, in [0, 1], shape (H, W)."""
    grid = city.grid
    x, y = np.meshgrid(grid.x_m, grid.y_m)
    half = grid.cell_m / 2
    cells = shapely.box(x - half, y - half, x + half, y + half)
    built = shapely.union_all([b.geometry for b in city.of_kind("building")])
    shapely.prepare(built)
    covered = shapely.area(shapely.intersection(cells, built)) / grid.cell_m**2
    share: NDArray[np.float64] = np.clip(1.0 - covered, 0.0, 1.0)
    return share


def _visible_cells(city: CityMap, altitude_m: float, reach: int) -> NDArray[np.bool_]:
    """Return which cells around each cell are visible, shape (H, W, 2 R + 1, 2 R + 1)."""
    grid = city.grid
    n_rows, n_cols = grid.shape
    heights, west, south = _height_raster(city, reach * grid.cell_m + grid.cell_m)
    x, y = np.meshgrid(grid.x_m, grid.y_m)
    visible = np.zeros((n_rows, n_cols, 2 * reach + 1, 2 * reach + 1), dtype=bool)
    third = grid.cell_m / 3

    def height_at(at_x: NDArray[np.float64], at_y: NDArray[np.float64]) -> NDArray[np.float64]:
        rows = ((at_y - south) / _PIXEL_M).astype(np.intp)
        cols = ((at_x - west) / _PIXEL_M).astype(np.intp)
        found: NDArray[np.float64] = heights[rows, cols]
        return found

    for dr in range(-reach, reach + 1):
        for dc in range(-reach, reach + 1):
            if math.hypot(dr, dc) > reach + 0.5:
                continue
            # On the ground and, for cells that are all roof, on roofs.
            free, points = np.zeros((2, *grid.shape)), np.zeros((2, *grid.shape))
            for u in (-third, 0.0, third):
                for v in (-third, 0.0, third):
                    end_x, end_y = x + dc * grid.cell_m + u, y + dr * grid.cell_m + v
                    roof = height_at(end_x, end_y)
                    counted = roof < altitude_m - 0.5
                    floor = np.maximum(roof + 0.05, _TARGET_M)
                    clear = counted.copy()
                    length = math.hypot(dc * grid.cell_m + u, dr * grid.cell_m + v)
                    for t in np.arange(0.5, length, _PIXEL_M) / max(length, _PIXEL_M):
                        line = altitude_m + t * (floor - altitude_m)
                        clear &= height_at(x + t * (end_x - x), y + t * (end_y - y)) <= line
                    for k, kind in enumerate((roof <= 0, roof > 0)):
                        free[k] += clear & kind
                        points[k] += counted & kind
            seen, of = (np.where(points[0] > 0, a[0], a[1]) for a in (free, points))
            visible[:, :, dr + reach, dc + reach] = (of > 0) & (seen >= _LEAST_VISIBLE * of)
    return visible


def _height_raster(city: CityMap, margin_m: float) -> tuple[NDArray[np.float64], float, float]:
    """Return how high buildings are at points a metre apart, and where the first of them is."""
    west, south, east, north = city.grid.cells_extent_m
    west, south = west - margin_m, south - margin_m
    xs = west + _PIXEL_M * (np.arange(math.ceil((east + margin_m - west) / _PIXEL_M)) + 0.5)
    ys = south + _PIXEL_M * (np.arange(math.ceil((north + margin_m - south) / _PIXEL_M)) + 0.5)
    heights = np.zeros((len(ys), len(xs)))
    for building in city.of_kind("building"):
        low_x, low_y, high_x, high_y = building.geometry.bounds
        cols = np.flatnonzero((xs >= low_x) & (xs <= high_x))
        rows = np.flatnonzero((ys >= low_y) & (ys <= high_y))
        if not len(cols) or not len(rows):
            continue
        x, y = np.meshgrid(xs[cols], ys[rows])
        shapely.prepare(building.geometry)
        inside = shapely.contains_xy(building.geometry, x, y)
        part = heights[np.ix_(rows, cols)]
        heights[np.ix_(rows, cols)] = np.where(inside, np.maximum(part, height_m(building)), part)
    return heights, west, south
