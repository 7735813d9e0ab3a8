"""A drone in a city in three dimensions: the world, flight, camera, the search flown in it; AirSim.

Names load on first use; the simulator and the server need ``sloop-ppl[sim]``, the client of AirSim
``sloop-ppl[airsim]``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from sloop_ppl._rooms import load_later

if TYPE_CHECKING:
    from sloop_ppl.simulation.airsim_client import AirSimEnvironment
    from sloop_ppl.simulation.airsim_connection import connect
    from sloop_ppl.simulation.airsim_server import AIRSIM_PORT, AirSimServer, serve
    from sloop_ppl.simulation.camera import Camera, Pinhole
    from sloop_ppl.simulation.detectors import (
        DETECTORS,
        ColourDetector,
        Detection,
        Detector,
        OracleDetector,
        RayDetector,
        SegmentationDetector,
        make_detector,
    )
    from sloop_ppl.simulation.drone import Drone
    from sloop_ppl.simulation.environment import FlightLog, MujocoEnvironment
    from sloop_ppl.simulation.film import Film, camera_panel, check_film_path
    from sloop_ppl.simulation.free_places import nearest_free
    from sloop_ppl.simulation.looks import COLOURS, KIND_SIZES, Look, look_of
    from sloop_ppl.simulation.sensor import FlightSensor, SensorRates, open_share
    from sloop_ppl.simulation.served_drone import ServedDrone
    from sloop_ppl.simulation.settings import (
        CLEARANCE_M,
        flight_plan,
        measured_rates,
        need_simulator,
        read_altitudes,
    )
    from sloop_ppl.simulation.vehicle import CameraImage, ImageKind, Stop, Vehicle, VehiclePose
    from sloop_ppl.simulation.world import World

__all__ = [
    "AIRSIM_PORT",
    "CLEARANCE_M",
    "COLOURS",
    "DETECTORS",
    "KIND_SIZES",
    "AirSimEnvironment",
    "AirSimServer",
    "Camera",
    "CameraImage",
    "ColourDetector",
    "Detection",
    "Detector",
    "Drone",
    "Film",
    "FlightLog",
    "FlightSensor",
    "ImageKind",
    "Look",
    "MujocoEnvironment",
    "OracleDetector",
    "Pinhole",
    "RayDetector",
    "SegmentationDetector",
    "SensorRates",
    "ServedDrone",
    "Stop",
    "Vehicle",
    "VehiclePose",
    "World",
    "camera_panel",
    "check_film_path",
    "connect",
    "flight_plan",
    "look_of",
    "make_detector",
    "measured_rates",
    "nearest_free",
    "need_simulator",
    "open_share",
    "read_altitudes",
    "serve",
]

_HOMES = {
    "airsim_client": ("AirSimEnvironment",),
    "airsim_connection": ("connect",),
    "airsim_server": ("AIRSIM_PORT", "AirSimServer", "serve"),
    "camera": ("Camera", "Pinhole"),
    "detectors": (
        "DETECTORS",
        "ColourDetector",
        "Detection",
        "Detector",
        "OracleDetector",
        "RayDetector",
        "SegmentationDetector",
        "make_detector",
    ),
    "drone": ("Drone",),
    "environment": ("FlightLog", "MujocoEnvironment"),
    "film": ("Film", "camera_panel", "check_film_path"),
    "free_places": ("nearest_free",),
    "looks": ("COLOURS", "KIND_SIZES", "Look", "look_of"),
    "sensor": ("FlightSensor", "SensorRates", "open_share"),
    "served_drone": ("ServedDrone",),
    "settings": (
        "CLEARANCE_M",
        "flight_plan",
        "measured_rates",
        "need_simulator",
        "read_altitudes",
    ),
    "vehicle": ("CameraImage", "ImageKind", "Stop", "Vehicle", "VehiclePose"),
    "world": ("World",),
}
__getattr__ = load_later(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted(__all__)
