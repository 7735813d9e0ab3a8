"""Simulators to search in: an environment on AirSim's clients, and a server that speaks to them.

Names load on first use; the client needs ``sloop-ppl[airsim]``, the server ``sloop-ppl[sim]``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from sloop_ppl._rooms import load_later

if TYPE_CHECKING:
    from sloop_ppl.simulation.airsim_client import AirSimEnvironment, connect
    from sloop_ppl.simulation.airsim_server import AIRSIM_PORT, AirSimServer, serve
    from sloop_ppl.simulation.served_drone import ServedDrone
    from sloop_ppl.simulation.vehicle import CameraImage, Vehicle, VehiclePose

__all__ = [
    "AIRSIM_PORT",
    "AirSimEnvironment",
    "AirSimServer",
    "CameraImage",
    "ServedDrone",
    "Vehicle",
    "VehiclePose",
    "connect",
    "serve",
]

_HOMES = {
    "airsim_client": ("AirSimEnvironment", "connect"),
    "airsim_server": ("AIRSIM_PORT", "AirSimServer", "serve"),
    "served_drone": ("ServedDrone",),
    "vehicle": ("CameraImage", "Vehicle", "VehiclePose"),
}
__getattr__ = load_later(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted(__all__)
