"""A search flown in the simulator: each planned move is a flight, each look a picture."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from sloop_ppl.errors import InputError, OutsideMap
from sloop_ppl.maps import touched_cells
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.environment import Outcome, Report, SearchEnded
from sloop_ppl.planning.pose import Pose
from sloop_ppl.planning.sensors import Sensor
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import SearchAction
from sloop_ppl.simulation.camera import Camera
from sloop_ppl.simulation.detectors import Detection, Detector, make_detector
from sloop_ppl.simulation.drone import Drone
from sloop_ppl.simulation.world import World

__all__ = ["FlightLog", "MujocoEnvironment"]

_LOST_M = 3.0
"""How far the drone may be from where it was sent before it counts as stuck."""


@dataclass(frozen=True)
class FlightLog:
    """What a flown search did beside its episode.

    Parameters
    ----------
    collisions
        Number of the step, from 0, and name of what was hit.
    detections
        What the detector saw after each step, whether or not the planner could use it.
    in_view
        Targets that the planner's model has in view after each move, by the true pose.
    """

    collisions: list[tuple[int, str]]
    detections: list[tuple[Detection, ...]]
    in_view: list[tuple[str, ...]]


class MujocoEnvironment:
    """An environment for `sloop_ppl.planning.run_search` whose moves are flown.

    Parameters
    ----------
    world
        The city with its targets.
    drone
        Who flies; where it is when this is made is where the search starts.
    camera
        What it sees with.
    detector
        Name of one of `DETECTORS`, or a detector.
    config
        The settings of the search, as `flight_plan` makes them; the planner must be given the same.
    sensor
        The planner's model of the camera, as `flight_plan` makes it; the fan of the settings when
        None.

    Attributes
    ----------
    pose
        Where the drone believes to be.
    log
        What happened.

    Raises
    ------
    InputError
        When the world has no target, the start is off the middle of a cell by a metre or more, or
        the detector cannot see a target.

    Notes
    -----
    A move is flown to the middle of the cell that the planner means, by the drone's own estimate;
    one that would leave the map is not flown. A find marks a target of which any part stands in a
    cell that the planner's model has in view from where the drone truly is: a car is as long as a
    cell, and the planner's word for its place is one cell. After a collision the
    drone goes back to where the move began. A drone that is upside down, on the ground or far from
    where it was sent ends the search, and so does an empty battery.
    """

    def __init__(
        self,
        world: World,
        drone: Drone,
        camera: Camera,
        *,
        detector: str | Detector = "camera",
        config: SearchConfig = SearchConfig(),  # noqa: B008 - frozen
        sensor: Sensor | None = None,
    ) -> None:
        if not world.places:
            raise InputError("The world has no target; give World.from_map the places of some")
        self.world, self.drone, self.camera = world, drone, camera
        self.detector = make_detector(detector, camera) if isinstance(detector, str) else detector
        self.space = SearchSpace.of_city(world.city, tuple(world.places), config, sensor=sensor)
        self.log = FlightLog([], [], [])
        self._altitude = drone.estimated_pose.z_m
        grid = world.city.grid
        self._cells = {t: grid.cell_at(*place) for t, place in world.places.items()}
        self._stands = {t: touched_cells(grid, world.outline(t)) for t in world.places}
        self._found: set[str] = set()
        self._looked = False
        self.pose = self._believed()
        # Where the planner believes the robot to be: the middle of a cell and an eighth of a turn.
        self._at = self.space.pose_at(self.space.snap(self.pose))
        off = math.dist(self._at[:2], self.pose[:2])
        if off >= 1.0:
            raise InputError(
                f"The drone starts {off:.1f} m off the middle of a cell; expected less than 1 m: "
                f"start it at ({self._at.x_m:g}, {self._at.y_m:g})"
            )

    def _believed(self) -> Pose:
        """Return where the drone believes to be."""
        believed = self.drone.estimated_pose
        return Pose(believed.x_m, believed.y_m, believed.yaw_rad % (2 * math.pi))

    def execute(self, action: SearchAction) -> Outcome:
        """Fly a move and look, or carry out a find.

        Raises
        ------
        SearchEnded
            When the drone is lost or its battery empty.
        """
        if self.drone.steps_left is not None:
            if self.drone.steps_left <= 0:
                self.drone.land()
                raise SearchEnded("The battery is empty: the drone has landed")
            self.drone.steps_left -= 1
        if action.index >= 3:
            self.log.detections.append(())
            self.log.in_view.append(())
            return Outcome(self.pose, Report(found=self._find(action)))
        collided = self._move(action.name)
        self.pose = self._believed()
        self._looked = True
        detections = self.detector.detect()
        self.log.detections.append(detections)
        self.log.in_view.append(self._in_view())
        return Outcome(self.pose, Report(self._usable(detections)), collided)

    def _move(self, action: str) -> bool:
        """Fly a move and tell whether something was hit."""
        space, drone = self.space, self.drone
        before = self._at
        after = space.motion.sample(before, action, None)
        try:
            after = space.pose_at(space.snap(after))
        except OutsideMap:
            drone.hover(seconds=0.5)
            return False
        if action == "forward":
            arrived = drone.move_to(after.x_m, after.y_m, self._altitude)
        else:
            arrived = drone.yaw_to(after.heading_rad)
        hit = drone.collision
        if hit is not None:
            self.log.collisions.append((len(self.log.detections), hit))
            arrived = self._retreat(before)
            after = before
        self._at = after
        off = math.dist(drone.pose[:2], after[:2])
        if not drone.is_upright or (not arrived and off > _LOST_M):
            raise SearchEnded(
                f"The drone is lost: it {'hit ' + hit if hit else 'was held up'} and is "
                f"{off:.1f} m from where it should be"
            )
        return hit is not None

    def _retreat(self, to: Pose) -> bool:
        """Go back to where a move began; a second try is made when the first one is held up."""
        drone = self.drone
        if not drone.is_upright:
            return False
        drone.hover(seconds=0.5)
        for _ in range(2):
            if drone.move_to(to.x_m, to.y_m, self._altitude, 2.0) and drone.yaw_to(to.heading_rad):
                return True
        return False

    def _usable(self, detections: tuple[Detection, ...]) -> Mapping[str, tuple[float, float]]:
        """Return what the planner's model can explain: reports from cells in its view."""
        view, grid = self.space.view_mask(self.pose), self.world.city.grid
        seen = {}
        for found in detections:
            if found.target in self._found or not grid.contains(*found.place):
                continue
            if view[grid.cell_at(*found.place)]:
                seen[found.target] = found.place
        return MappingProxyType(seen)

    def _true_pose(self) -> Pose:
        pose = self.drone.pose
        return Pose(pose.x_m, pose.y_m, pose.yaw_rad % (2 * math.pi))

    def _in_view(self) -> tuple[str, ...]:
        view = self.space.view_mask(self._true_pose())
        return tuple(t for t, cell in self._cells.items() if view[cell])

    def _find(self, action: SearchAction) -> tuple[str, ...]:
        if not self._looked:
            return ()
        view = self.space.view_mask(self._true_pose())
        new = tuple(
            name
            for i, name in enumerate(self.space.target_ids)
            if name not in self._found
            and action.marks >> i & 1
            and bool((view & self._stands[name]).any())
        )
        self._found.update(new)
        return new
