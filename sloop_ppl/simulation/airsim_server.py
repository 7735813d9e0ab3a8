"""Serve a vehicle to AirSim's clients: the calls that `AirSimEnvironment` needs, no more."""

from __future__ import annotations

import asyncio
import contextlib
import io
import math
import queue
import re
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any

from sloop_ppl.errors import InputError
from sloop_ppl.simulation._airsim_colours import MAX_OBJECTS, object_colours
from sloop_ppl.simulation._msgpack_rpc import RpcServer
from sloop_ppl.simulation._ned import NedFrame, map_yaw_rad, quaternion
from sloop_ppl.simulation.vehicle import CameraImage, Vehicle, VehiclePose

__all__ = ["AIRSIM_PORT", "AirSimServer", "serve"]

AIRSIM_PORT = 41451
"""Where AirSim listens unless its settings say otherwise."""

_API_VERSION = 4
"""Version of the calls, as the client of Cosys-AirSim 3 counts them."""

_IMAGE_KINDS = {0: "scene", 5: "segmentation"}

_Call = Callable[..., Any]


class AirSimServer:
    """Answers AirSim's clients with a vehicle.

    The network has a thread of its own. The vehicle's commands and pictures run in the thread that
    calls `run`, one after the other, because physics must not wait for the network and a renderer
    belongs to one thread; poses and collisions are read while a command runs. A new command, or
    ``cancelLastTask``, stops the one that runs.

    Parameters
    ----------
    vehicle
        What is flown.
    port
        Where to listen; 0 for any free port.
    host
        The address to listen on; by default this machine alone can connect.
    origin_m
        Where the origin of the clients' north, east and down lies: x, y and z on the map.

    Attributes
    ----------
    port
        Where it listens, once it does.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        port: int = AIRSIM_PORT,
        host: str = "127.0.0.1",
        *,
        origin_m: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        if not isinstance(vehicle, Vehicle):
            raise InputError(
                f"The vehicle is a {type(vehicle).__name__}; expected an object with the "
                "attributes and methods of sloop_ppl.simulation.Vehicle"
            )
        self.port, self._host, self._vehicle = port, host, vehicle
        self._frame = NedFrame(*origin_m)
        self._names = list(vehicle.objects())
        if len(self._names) > MAX_OBJECTS:
            raise InputError(
                f"The world has {len(self._names)} objects; expected at most {MAX_OBJECTS}"
            )
        self._jobs: queue.SimpleQueue[tuple[Future[Any], Callable[[], Any]] | None]
        self._jobs = queue.SimpleQueue()
        self._stop_flight = threading.Event()
        self._collision_stamp = 0
        self._calls: Mapping[str, _Call] = {**self._quick_calls(), **self._vehicle_calls()}
        self._listening: Future[int] = Future()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._closed: asyncio.Event | None = None
        self._thread = threading.Thread(target=self._network, name="airsim", daemon=True)

    def start(self) -> None:
        """Listen; calls wait until `run` is called.

        Raises
        ------
        InputError
            When the address cannot be had.
        """
        self._thread.start()
        self.port = self._listening.result()

    def run(self) -> None:
        """Carry out commands in this thread until `close` is called."""
        while (job := self._jobs.get()) is not None:
            future, work = job
            if future.set_running_or_notify_cancel():
                try:
                    result = work()
                except BaseException as error:
                    future.set_exception(error)
                    if not isinstance(error, Exception):
                        raise
                else:  # Ctrl-C in here finds a future that has its result
                    future.set_result(result)

    def close(self) -> None:
        """Stop the flight and the network; may be called from any thread, and again."""
        self._stop_flight.set()
        self._jobs.put(None)
        if self._loop is not None and self._closed is not None:
            with contextlib.suppress(RuntimeError):  # another thread has closed it already
                self._loop.call_soon_threadsafe(self._closed.set)
            self._thread.join()

    def _network(self) -> None:
        asyncio.run(self._listen())

    async def _listen(self) -> None:
        self._loop, self._closed = asyncio.get_running_loop(), asyncio.Event()
        server = RpcServer(self._handle)
        try:
            await server.listen(self.port, self._host)
        except InputError as error:
            self._listening.set_exception(error)
            return
        self._listening.set_result(server.port)
        await self._closed.wait()
        await server.close()

    async def _handle(self, name: str, arguments: list[Any]) -> Any:
        """Carry out one call; arguments that clients leave out have AirSim's defaults."""
        if name not in self._calls:
            raise InputError(f"'{name}' is not served; expected one of: {', '.join(self._calls)}")
        try:
            result = self._calls[name](*arguments)
        except (TypeError, ValueError, re.error) as error:
            raise InputError(f"{name} was called with {arguments!r}: {error}") from None
        return await asyncio.wrap_future(result) if isinstance(result, Future) else result

    # What the network's thread answers by itself.

    def _quick_calls(self) -> dict[str, _Call]:
        return {
            "ping": lambda: True,
            "getServerVersion": lambda: _API_VERSION,
            "getMinRequiredClientVersion": lambda: _API_VERSION,
            "enableApiControl": lambda _enable, _vehicle="": None,
            "armDisarm": lambda _arm, _vehicle="": True,
            "cancelLastTask": lambda _vehicle="": self._stop_flight.set(),
            "simGetVehiclePose": lambda _vehicle="": self._pose(self._vehicle.pose),
            "getMultirotorState": lambda _vehicle="": self._state(),
            "simGetCollisionInfo": lambda _vehicle="": self._collision(),
            "simListSceneObjects": lambda pattern=".*": [
                name for name in self._names if re.fullmatch(pattern, name)
            ],
            "simGetObjectPose": lambda name, _ned=True: self._object_pose(name),
            "simGetSegmentationObjectID": lambda name: (
                self._names.index(name) if name in self._names else -1
            ),
        }

    def _pose(self, pose: VehiclePose, pitch_rad: float = 0.0) -> dict[str, Any]:
        north, east, down = self._frame.to_ned(pose.x_m, pose.y_m, pose.z_m)
        return {
            "position": _named((north, east, down)),
            "orientation": _quaternion(pose.yaw_rad, pitch_rad),
        }

    def _object_pose(self, name: str) -> dict[str, Any]:
        if name in self._names:
            return self._pose(self._vehicle.object_pose(name))
        # As AirSim answers for what it does not have.
        nan = dict.fromkeys(("x_val", "y_val", "z_val"), math.nan)
        return {"position": nan, "orientation": {**nan, "w_val": math.nan}}

    def _state(self) -> dict[str, Any]:
        estimated = self._vehicle.estimated_pose
        return {
            "collision": self._collision(),
            "kinematics_estimated": self._pose(estimated),
            "landed_state": int(estimated.z_m > 0.5),
            "ready": True,
            "can_arm": True,
            "timestamp": time.time_ns(),
        }

    def _collision(self) -> dict[str, Any]:
        name = self._vehicle.collision
        north, east, down = self._frame.to_ned(*self._vehicle.pose[:3])
        return {
            "has_collided": name is not None,
            "object_name": name or "",
            "position": _named((north, east, down)),
            "time_stamp": self._collision_stamp,
        }

    # What the vehicle's thread does.

    def _vehicle_calls(self) -> dict[str, _Call]:
        vehicle = self._vehicle
        return {
            "takeoff": lambda timeout_sec=20.0, _vehicle="": self._fly(
                timeout_sec, vehicle.take_off
            ),
            "land": lambda timeout_sec=60.0, _vehicle="": self._fly(timeout_sec, vehicle.land),
            "hover": lambda _vehicle="": self._fly(60.0, vehicle.hover),
            "moveToPosition": self._move_to_position,
            "rotateToYaw": lambda yaw, timeout_sec=3e38, _margin=5.0, _vehicle="": self._fly(
                timeout_sec, vehicle.yaw_to, map_yaw_rad(_finite(yaw))
            ),
            "simGetImages": lambda requests, _vehicle="": self._later(
                lambda: [self._image(request) for request in requests]
            ),
            "simGetCameraInfo": lambda _camera, _vehicle="": self._later(self._camera_info),
        }

    def _move_to_position(
        self,
        x: float,
        y: float,
        z: float,
        velocity: float,
        timeout_sec: float = 3e38,
        *_how: Any,
    ) -> Future[Any]:
        # How the vehicle is to look while it flies is not heard: its yaw stays.
        place = self._frame.to_map(_finite(x), _finite(y), _finite(z))
        return self._fly(timeout_sec, self._vehicle.move_to, *place, _finite(velocity))

    def _later(self, work: Callable[[], Any]) -> Future[Any]:
        """Have something done by the vehicle's thread."""
        future: Future[Any] = Future()
        self._jobs.put((future, work))
        return future

    def _fly(
        self, timeout_s: float, command: Callable[..., bool], *arguments: float
    ) -> Future[Any]:
        """Stop the command that runs, then have another one carried out."""
        self._stop_flight.set()
        self._stop_flight = stopped = threading.Event()
        ends = time.monotonic() + min(_finite(timeout_s), 3600.0)
        collided = False

        def stop() -> bool:
            nonlocal collided
            # One stamp a command, by which clients tell a collision from the one before.
            if not collided and self._vehicle.collision is not None:
                collided, self._collision_stamp = True, time.time_ns()
            return stopped.is_set() or time.monotonic() > ends

        def work() -> bool:
            if stopped.is_set():
                return False
            done = bool(command(*arguments, stop=stop))
            stop()  # it may have hit something in its last step
            return done

        return self._later(work)

    def _image(self, request: Mapping[str, Any]) -> dict[str, Any]:
        number = request.get("image_type")
        if number not in _IMAGE_KINDS:
            raise InputError(
                f"Pictures of type {number} are not served; expected 0 (scene) or 5 (segmentation)"
            )
        taken = self._vehicle.camera_image(_IMAGE_KINDS[number])  # type: ignore[arg-type]
        pixels = taken.pixels
        if number == 5:
            import numpy as np

            black = np.zeros((1, 3), dtype=np.uint8)
            pixels = np.concatenate([black, object_colours()])[pixels]
        height, width = pixels.shape[:2]
        pose = self._pose(taken.pose, taken.pitch_rad)
        compress = bool(request.get("compress", True))
        return {
            "image_data_uint8": _png(pixels) if compress else pixels.tobytes(),
            "image_data_float": [],
            "camera_position": pose["position"],
            "camera_orientation": pose["orientation"],
            "time_stamp": time.time_ns(),
            "message": "",
            "pixels_as_float": False,
            "compress": compress,
            "width": width,
            "height": height,
            "image_type": number,
        }

    def _camera_info(self) -> dict[str, Any]:
        taken: CameraImage = self._vehicle.camera_image("segmentation")
        return {"pose": self._pose(taken.pose, taken.pitch_rad), "fov": taken.fov_deg}


def serve(
    vehicle: Vehicle,
    port: int = AIRSIM_PORT,
    host: str = "127.0.0.1",
    *,
    origin_m: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ready: Callable[[AirSimServer], None] | None = None,
) -> None:
    """Serve a vehicle to AirSim's clients, in this thread, until it is closed or interrupted.

    Parameters
    ----------
    vehicle, port, host, origin_m
        As in `AirSimServer`.
    ready
        Called with the server once it listens; its `close`, from another thread, ends the serving.

    Raises
    ------
    InputError
        When msgpack is missing or the address cannot be had.
    """
    server = AirSimServer(vehicle, port, host, origin_m=origin_m)
    server.start()
    try:
        if ready is not None:
            ready(server)
        server.run()
    finally:
        server.close()


def _named(vector: tuple[float, float, float]) -> dict[str, float]:
    return dict(zip(("x_val", "y_val", "z_val"), vector, strict=True))


def _quaternion(yaw_rad: float, pitch_rad: float) -> dict[str, float]:
    names = ("w_val", "x_val", "y_val", "z_val")
    return dict(zip(names, quaternion(yaw_rad, pitch_rad), strict=True))


def _finite(number: Any) -> float:
    value = float(number)
    if not math.isfinite(value):
        raise ValueError(f"{value} is no number to fly by")
    return value


def _png(pixels: Any) -> bytes:
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "PNG", compress_level=1)
    return file.getvalue()
