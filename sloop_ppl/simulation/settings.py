"""How a search is planned that is flown: what the planner takes camera and flight to be."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.simulation._mujoco import mujoco
from sloop_ppl.simulation.sensor import FlightSensor, SensorRates

__all__ = ["CLEARANCE_M", "flight_plan", "measured_rates", "need_simulator", "read_altitudes"]

CLEARANCE_M = 1.6
"""How far planned flights keep from walls, metres: the hull, and five deviations of the drift."""

_LOWEST_M, _HIGHEST_M = 4.0, 40.0

# Set from `sloop eval camera --poses 45 --seed 1` on the five bundled maps at 14 and 10 m: detected
# .93, wrong cells .06. docs/simulation.md has the sweep of another seed, which they must fit.
_MEASURED = {
    "camera": SensorRates(0.92, 0.001, 0.35),
    "segmentation": SensorRates(0.92, 0.001, 0.35),
    "rays": SensorRates(0.92, 0.001, 0.35),
    "oracle": SensorRates(0.97, 0.001, 0.25),
}


def measured_rates(detector: str) -> SensorRates:
    """Return the rates of a detector, as they were measured on the bundled maps.

    Parameters
    ----------
    detector
        Name of one of `DETECTORS`; another one is taken to be as good as ``camera``.
    """
    return _MEASURED.get(detector, _MEASURED["camera"])


def need_simulator() -> None:
    """Say which extra is missing, where it is.

    Raises
    ------
    InputError
        When mujoco is not installed.
    """
    mujoco()


def read_altitudes(typed: str) -> tuple[float, ...]:
    """Return altitudes typed as ``14,10``.

    Raises
    ------
    InputError
        When one is no number.
    """
    try:
        altitudes = tuple(float(part) for part in typed.split(",") if part.strip())
    except ValueError:
        altitudes = ()
    if not altitudes:
        raise InputError(f"Altitudes '{typed}' are malformed; expected numbers such as 14,10")
    return altitudes


def flight_plan(
    city: CityMap,
    config: SearchConfig,
    altitude_m: float,
    detector: str,
    rates: SensorRates | None = None,
) -> tuple[SearchConfig, FlightSensor]:
    """Return settings and sensor with which a search is planned at an altitude.

    Parameters
    ----------
    city
        The map, with heights of its buildings, as `World.city` has them.
    config
        The settings of a search on the grid; range and opening of the fan go to the sensor.
    altitude_m
        How high the drone flies, metres.
    detector
        Name of the detector, whose rates the sensor gets.
    rates
        Other rates than those that were measured.

    Returns
    -------
    tuple
        Settings under which buildings as tall as the flight is high close it, and flights keep
        `CLEARANCE_M` from them; and the sensor, which sees past and over what is lower.

    Raises
    ------
    InputError
        When the altitude is out of [4, 40] metres, or the settings have rates of their own.
    """
    if not (math.isfinite(altitude_m) and _LOWEST_M <= altitude_m <= _HIGHEST_M):
        raise InputError(
            f"The altitude is {altitude_m:g} m; expected {_LOWEST_M:g} to {_HIGHEST_M:g} m: lower "
            "the drone is among cars, higher its camera sees too little"
        )
    plain = SearchConfig()
    fan: dict[str, Any] = {
        "sensor_range_cells": 3.0,
        "sensor_min_range_cells": 1.0,
        "fov_deg": 90.0,
    }
    replace(config, **fan).refuse_settings_of("sensor", "camera of a drone")
    sensor = FlightSensor(
        city,
        altitude_m,
        measured_rates(detector) if rates is None else rates,
        range_cells=config.sensor_range_cells,
        min_range_cells=config.sensor_min_range_cells,
        fov_deg=config.fov_deg,
    )
    planned = replace(
        config,
        **{name: getattr(plain, name) for name in fan},
        no_fly=True,
        flight_height_m=altitude_m - 0.5,  # a roof half a metre below is too near
        clearance_m=CLEARANCE_M,
        recovery_weight=config.recovery_weight or 0.01,
    )
    return planned, sensor
