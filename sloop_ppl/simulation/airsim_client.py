"""Search in AirSim: an environment that flies a drone through the official client."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError, OutsideMap, UnknownName
from sloop_ppl.planning import Outcome, Pose, Report, SearchAction, SearchSpace
from sloop_ppl.simulation._airsim_vision import Camera, ground_point, middle_of, pixels_of
from sloop_ppl.simulation._ned import NedFrame, ned_yaw_deg, rotation, yaw_pitch
from sloop_ppl.simulation.airsim_connection import asked, refuse_running_loop
from sloop_ppl.simulation.vehicle import VehiclePose

__all__ = ["AirSimEnvironment"]

T = TypeVar("T")

_SEGMENTATION = 5
_POLL_S = 0.02
"""Time between two looks at the collision sensor during a flight."""

_KEEP_YAW, _MARGIN_DEG = 0, 2.0

_INSIDE_M = 1e-3
"""The east and south borders of the last cells are outside; this far from them is inside."""


class AirSimEnvironment:
    """A drone in AirSim, or in whatever speaks its calls, as the environment of a search.

    It takes off when it is made. A planned move is flown from the middle of the cell that the
    drone believes to be in, so that errors do not add up; a picture is taken after it, and what it
    shows of the targets is projected to the ground with the pose that the drone believes in.

    Parameters
    ----------
    client
        A client of the official package, such as `connect` returns.
    space
        The search space: cells, moves, what the planner takes to be in view, and the targets.
    objects
        Target -> name of its object in the simulator; the target's own name where left out.
    start
        Where to fly before the search begins; None for where the drone takes off.
    altitude_m
        How high to fly, metres above the ground.
    speed_m_s
        How fast.
    origin_m
        Where the origin of AirSim's coordinates lies: x, y and z on the map.
    camera
        Name of the camera.
    target_height_m
        Height of the middle of a target above the ground, metres.
    min_pixels
        Fewer pixels of a target are not seen.

    Attributes
    ----------
    pose
        Where the drone believes to be; it follows what is flown.

    Raises
    ------
    InputError
        When a target has no object, the drone does not take off, or the simulator does not answer.

    Notes
    -----
    A find marks the targets that are in the planner's view from the cell and the eighth of a turn
    in which the drone is in truth, by ``simGetObjectPose`` and ``simGetVehiclePose``.
    What the camera sees beyond the planner's view is not reported: the planner's model gives it no
    probability. A move off the map is not flown.
    """

    def __init__(
        self,
        client: Any,
        space: SearchSpace,
        objects: Mapping[str, str] | None = None,
        *,
        start: Pose | None = None,
        altitude_m: float = 14.0,
        speed_m_s: float = 5.0,
        origin_m: tuple[float, float, float] = (0.0, 0.0, 0.0),
        camera: str = "front_center",
        target_height_m: float = 0.75,
        min_pixels: int = 4,
    ) -> None:
        for name, value in {"altitude_m": altitude_m, "speed_m_s": speed_m_s}.items():
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"{name} is {value:g}; expected a positive number")
        refuse_running_loop()
        if start is not None:
            space.snap(start)  # refuses what is off the map
        self._client, self._space, self._frame = client, space, NedFrame(*origin_m)
        self._altitude_m, self._speed_m_s = altitude_m, speed_m_s
        self._camera, self._target_height_m = camera, target_height_m
        self._min_pixels, self._looked, self._found = min_pixels, False, set[str]()
        self._objects = {t: (objects or {}).get(t, t) for t in space.target_ids}
        self._colours = self._known_objects()
        self._fov_deg = float(self._call(lambda: client.simGetCameraInfo(camera).fov))
        self._take_off(start)
        self.pose = self._believed()

    def execute(self, action: SearchAction) -> Outcome:
        """Fly a move and look, or find, and return what came of it.

        Raises
        ------
        InputError
            When the simulator does not answer.
        """
        if action.index >= 3:
            return Outcome(self.pose, Report(found=self._find(action)))
        collision = self._move(action)
        self._looked = True
        self.pose = self._believed()
        return Outcome(self.pose, Report(self._look()), collision)

    def land(self) -> None:
        """Come down and give the drone back."""
        self._call(lambda: self._client.landAsync().join())
        self._call(lambda: self._client.armDisarm(False))
        self._call(lambda: self._client.enableApiControl(False))

    # Flight

    def _take_off(self, start: Pose | None) -> None:
        client = self._client
        self._call(lambda: client.enableApiControl(True))
        self._call(lambda: client.armDisarm(True))
        if self._call(lambda: client.takeoffAsync().get()) is False:
            raise InputError(
                "The drone did not take off; expected a multirotor that stands free and is not "
                "controlled by somebody else"
            )
        here = self._pose_of_state()
        # Up first, since nothing is known of what stands around.
        self._fly_to(here.x_m, here.y_m)
        if start is not None:
            self._fly_to(start.x_m, start.y_m)
            self._turn_to(start.heading_rad)

    def _move(self, action: SearchAction) -> bool:
        """Fly a move and tell whether something was hit; a move off the map is not flown."""
        space = self._space
        row, col, heading = space.decode(space.snap(self.pose))
        # The most probable outcome: what slips, slips by itself here.
        rows, cols, turn = space.move_table.offsets[action.index, heading, 0].tolist()
        try:
            goal = space.pose_at(space.encode(row + rows, col + cols, heading + turn))
        except OutsideMap:
            return False
        # A turn is on the spot: the middle of the cell may lie in a house that was run into.
        collision = bool(rows or cols) and self._fly_to(goal.x_m, goal.y_m)
        return self._turn_to(goal.heading_rad) or collision

    def _fly_to(self, x_m: float, y_m: float) -> bool:
        here = self._pose_of_state()
        away = math.dist((here.x_m, here.y_m, here.z_m), (x_m, y_m, self._altitude_m))
        # Three times as long as it should take: a drone that is stuck must not hang the search.
        limit_s = 10.0 + 3.0 * away / self._speed_m_s
        north, east, down = self._frame.to_ned(x_m, y_m, self._altitude_m)
        yaw_mode = {"is_rate": False, "yaw_or_rate": ned_yaw_deg(here.yaw_rad)}
        return self._flown(
            lambda: self._client.moveToPositionAsync(
                north, east, down, self._speed_m_s, limit_s, _KEEP_YAW, yaw_mode
            ),
            limit_s,
        )

    def _turn_to(self, yaw_rad: float) -> bool:
        return self._flown(
            lambda: self._client.rotateToYawAsync(ned_yaw_deg(yaw_rad), 20.0, _MARGIN_DEG), 20.0
        )

    def _flown(self, command: Callable[[], Any], limit_s: float) -> bool:
        """Wait for a command, come to rest, and tell whether something was hit."""
        client = self._client
        before = self._call(client.simGetCollisionInfo).time_stamp
        future = self._call(command)
        ends = time.monotonic() + limit_s
        collided = False
        while future.result is None and future.error is None and not collided:
            # By its time: the flag is up only while the drone touches something.
            collided = self._call(client.simGetCollisionInfo).time_stamp != before
            if time.monotonic() > ends:
                break
            time.sleep(_POLL_S)
        if collided or future.result is None:
            self._call(client.cancelLastTask)
        self._call(lambda: client.hoverAsync().join())
        return collided or self._call(client.simGetCollisionInfo).time_stamp != before

    # Poses

    def _pose_of_state(self) -> VehiclePose:
        state = self._call(self._client.getMultirotorState).kinematics_estimated
        return self._map_pose(state.position, state.orientation)

    def _believed(self) -> Pose:
        """Return where the drone believes to be; the map's border if it believes to be off it."""
        x, y, _, yaw = self._pose_of_state()
        west, south, east, north = self._space.grid.cells_extent_m
        x = min(max(x, west), east - _INSIDE_M)
        return Pose(x, min(max(y, south + _INSIDE_M), north), yaw)

    def _map_pose(self, position: Any, orientation: Any) -> VehiclePose:
        place = self._frame.to_map(position.x_val, position.y_val, position.z_val)
        return VehiclePose(*place, yaw_pitch(_quaternion(orientation))[0])

    # What is seen and found

    def _look(self) -> dict[str, tuple[float, float] | None]:
        """Return where the picture shows each target that is not found yet."""
        request = {
            "camera_name": self._camera,
            "image_type": _SEGMENTATION,
            "pixels_as_float": False,
            # A PNG says itself which channel is red; raw pixels differ between versions of AirSim.
            "compress": True,
            "annotation_name": "",
        }
        (taken,) = self._call(lambda: self._client.simGetImages([request]))
        pixels = pixels_of(taken.image_data_uint8)
        view = self._space.view_mask(self.pose)
        truth = self._true_pose()
        camera = Camera(
            self._frame.to_map(*_vector(taken.camera_position)),
            rotation(_quaternion(taken.camera_orientation)),
            self._fov_deg,
            *reversed(pixels.shape[:2]),
        )
        seen: dict[str, tuple[float, float] | None] = {}
        for target, colour in self._colours.items():
            if target in self._found:
                continue
            at = middle_of(pixels, colour, self._min_pixels)
            place = at and ground_point(camera, *at, self._target_height_m)
            seen[target] = place and self._in_view(_as_believed(place, truth, self.pose), view)
        return seen

    def _in_view(
        self, place: tuple[float, float], view: NDArray[np.bool_]
    ) -> tuple[float, float] | None:
        """Return the place if the planner holds it to be in view."""
        try:
            cell = self._space.grid.cell_covering(*place)
        except OutsideMap:
            return None
        return place if view[cell] else None

    def _find(self, action: SearchAction) -> tuple[str, ...]:
        if not self._looked:
            return ()
        try:
            # From the middle of the cell, as the planner has it: a degree of yaw more or less does
            # not decide about what stands on the border of the fan.
            view = self._space.view_mask(self._space.snap(self._true_pose()))
        except OutsideMap:
            return ()
        marked = []
        for i, target in enumerate(self._space.target_ids):
            if action.marks >> i & 1 and target not in self._found:
                x, y, _, _ = self._object_pose(target)
                if self._in_view((x, y), view) is not None:
                    marked.append(target)
        self._found.update(marked)
        return tuple(marked)

    def _true_pose(self) -> Pose:
        pose = self._call(self._client.simGetVehiclePose)
        x, y, _, yaw = self._map_pose(pose.position, pose.orientation)
        return Pose(x, y, yaw)

    def _object_pose(self, target: str) -> VehiclePose:
        pose = self._call(lambda: self._client.simGetObjectPose(self._objects[target]))
        found = self._map_pose(pose.position, pose.orientation)
        if not all(map(math.isfinite, found[:2])):
            raise InputError(
                f"AirSim knows no place of object '{self._objects[target]}' of target '{target}'; "
                "expected the name of one that simListSceneObjects lists"
            )
        return found

    def _known_objects(self) -> dict[str, tuple[int, int, int]]:
        """Return the colour of each target's object in a segmentation."""
        client = self._client
        there = self._call(client.simListSceneObjects)
        for target, name in self._objects.items():
            if name not in there:
                raise UnknownName(f"object of target {target} in AirSim", name, there)
        numbers = {
            target: self._call(partial(client.simGetSegmentationObjectID, name))
            for target, name in self._objects.items()
        }
        colours = client.simGetSegmentationColorMap()
        known = {}
        for target, number in numbers.items():
            if not 0 <= number < len(colours):
                raise InputError(
                    f"Object '{self._objects[target]}' of target '{target}' has number {number} in "
                    "AirSim's segmentation; expected an object that the segmentation shows"
                )
            red, green, blue = (int(v) for v in colours[number])
            known[target] = red, green, blue
        return known

    def _call(self, call: Callable[[], T]) -> T:
        """Make a call, and say in one line what went wrong."""
        refuse_running_loop()
        return asked(call)


def _as_believed(place: tuple[float, float], truth: Pose, believed: Pose) -> tuple[float, float]:
    """Return a place as it lies to the drone, laid out from where the drone believes to be.

    AirSim tells where its camera is in truth; a drone that is wrong about its own pose is as wrong
    about what it sees.
    """
    east, north = place[0] - truth.x_m, place[1] - truth.y_m
    turn = believed.heading_rad - truth.heading_rad
    c, s = math.cos(turn), math.sin(turn)
    return believed.x_m + c * east - s * north, believed.y_m + s * east + c * north


def _quaternion(orientation: Any) -> tuple[float, float, float, float]:
    return orientation.w_val, orientation.x_val, orientation.y_val, orientation.z_val


def _vector(position: Any) -> tuple[float, float, float]:
    return position.x_val, position.y_val, position.z_val
