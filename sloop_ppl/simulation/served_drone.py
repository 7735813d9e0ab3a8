"""The drone of the MuJoCo world with its camera, as one vehicle that AirSim's clients can fly."""

from __future__ import annotations

from typing import Any

from sloop_ppl.simulation.vehicle import CameraImage, ImageKind, Stop, VehiclePose

__all__ = ["ServedDrone"]


class ServedDrone:
    """A drone and the camera that it carries.

    Parameters
    ----------
    camera
        A `Camera` of the simulation; it knows its drone and its world.

    Examples
    --------
    ::

        world = World.from_map(city, {"RedCar": (-17.5, 52.5)})
        drone = Drone(world, (0.0, 0.0), altitude_m=0, rng=rng)
        with Camera(world, drone) as camera:
            serve(ServedDrone(camera), 41451)
    """

    def __init__(self, camera: Any) -> None:
        self._camera, self._drone, self._world = camera, camera.drone, camera.world

    @property
    def pose(self) -> VehiclePose:
        """Where it is in truth."""
        return VehiclePose(*self._drone.pose)

    @property
    def estimated_pose(self) -> VehiclePose:
        """Where it believes to be."""
        return VehiclePose(*self._drone.estimated_pose)

    @property
    def collision(self) -> str | None:
        """Name of what it ran into since the last command began."""
        name: str | None = self._drone.collision
        return name

    def take_off(self, stop: Stop | None = None) -> bool:
        """Leave the ground."""
        return bool(self._drone.take_off(stop))

    def land(self, stop: Stop | None = None) -> bool:
        """Come down where it is."""
        return bool(self._drone.land(stop))

    def hover(self, stop: Stop | None = None) -> bool:
        """Come to rest where it is."""
        return bool(self._drone.hover(stop))

    def move_to(
        self, x_m: float, y_m: float, z_m: float, speed_m_s: float, stop: Stop | None = None
    ) -> bool:
        """Fly straight to a place; the yaw stays."""
        return bool(self._drone.move_to(x_m, y_m, z_m, speed_m_s, stop))

    def yaw_to(self, yaw_rad: float, stop: Stop | None = None) -> bool:
        """Turn on the spot, the shorter way round."""
        return bool(self._drone.yaw_to(yaw_rad, stop))

    def camera_image(self, kind: ImageKind) -> CameraImage:
        """Take a picture."""
        return CameraImage(*self._camera.image(kind))

    def objects(self) -> tuple[str, ...]:
        """Return the names of targets, parked cars and buildings."""
        return tuple(self._world.object_names())

    def object_pose(self, name: str) -> VehiclePose:
        """Return where an object stands on the ground, and where it heads; buildings head east."""
        world = self._world
        x, y = world.places.get(name) or world.parked.get(name) or world.city.centroid(name)
        return VehiclePose(x, y, 0.0, world.headings_rad.get(name, 0.0))
