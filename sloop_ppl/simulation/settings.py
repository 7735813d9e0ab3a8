"""The settings of a search that is flown: what the planner takes camera and flight to be."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from sloop_ppl.errors import InputError
from sloop_ppl.planning.config import SearchConfig

__all__ = ["CLEARANCE_M", "SensorRates", "flight_settings", "measured_rates"]

CLEARANCE_M = 1.6
"""How far planned flights keep from walls, metres: the hull, and five deviations of the drift."""

_SLACK_CELLS, _SLACK_DEG = 0.1, 6.0

HIGHEST_M = 40.0
"""Altitude above which the camera sees too little, metres."""

LOWEST_M = 4.0


@dataclass(frozen=True)
class SensorRates:
    """How often a detector errs, as the planner's sensor model has it.

    Parameters
    ----------
    true_positive
        Probability that a target in view is reported.
    false_positive
        Probability of a report where no target is in view.
    position_noise_cells
        Sigma of the reported cell, cells.
    """

    true_positive: float
    false_positive: float
    position_noise_cells: float


# Measured by `sloop eval camera` on the five bundled maps; docs/simulation.md has the table.
_MEASURED = {
    "camera": SensorRates(0.95, 0.002, 0.3),
    "segmentation": SensorRates(0.95, 0.002, 0.3),
    "rays": SensorRates(0.95, 0.002, 0.3),
    "oracle": SensorRates(0.99, 0.001, 0.2),
}


def measured_rates(detector: str) -> SensorRates:
    """Return the rates of a detector, as they were measured on the bundled maps."""
    return _MEASURED.get(detector, _MEASURED["camera"])


def flight_settings(
    config: SearchConfig, altitude_m: float, detector: str, rates: SensorRates | None = None
) -> SearchConfig:
    """Return the settings of a search as it is to be planned and flown at an altitude.

    Parameters
    ----------
    config
        The settings of a search on the grid.
    altitude_m
        How high the drone flies, metres.
    detector
        Name of the detector, whose rates the sensor model gets.
    rates
        Other rates than those that were measured.

    Returns
    -------
    SearchConfig
        Buildings at least as tall as the flight is high close flight and sight; flights keep
        `CLEARANCE_M` from them. The fan sees the same cells from the middle of a cell, with a
        tolerance of half a metre and a few degrees for a drone that hangs a little beside it.

    Raises
    ------
    InputError
        When the altitude is out of [4, 40] metres.
    """
    if not (math.isfinite(altitude_m) and LOWEST_M <= altitude_m <= HIGHEST_M):
        raise InputError(
            f"The altitude is {altitude_m:g} m; expected {LOWEST_M:g} to {HIGHEST_M:g} m: lower "
            "the drone is among cars, higher its camera sees too little"
        )
    known = measured_rates(detector) if rates is None else rates
    return replace(
        config,
        no_fly=True,
        occlusion=True,
        flight_height_m=altitude_m - 0.5,  # a roof half a metre below is too near
        clearance_m=CLEARANCE_M,
        sensor_range_cells=config.sensor_range_cells + _SLACK_CELLS,
        sensor_min_range_cells=max(config.sensor_min_range_cells - _SLACK_CELLS, 0.0),
        fov_deg=min(config.fov_deg + _SLACK_DEG, 360.0),
        true_positive_rate=known.true_positive,
        false_positive_rate=known.false_positive,
        position_noise_cells=known.position_noise_cells,
        recovery_weight=config.recovery_weight or 0.01,
    )
