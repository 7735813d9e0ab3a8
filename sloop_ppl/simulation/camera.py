"""The drone's camera: pictures of the world, and where on the ground a pixel lies."""

from __future__ import annotations

import math
from types import TracebackType
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.simulation._airframe import SEEN_GROUP
from sloop_ppl.simulation._mujoco import GL_PACKAGES, mujoco, rendering_fault
from sloop_ppl.simulation.drone import Drone
from sloop_ppl.simulation.vehicle import CameraImage, ImageKind, VehiclePose
from sloop_ppl.simulation.world import World

__all__ = ["Camera", "Pinhole"]

_BELOW_M = 0.12
"""How far under the middle of the drone the camera hangs, metres."""


class Pinhole:
    """Where a pixel looks, and at which pixel a point is seen.

    Parameters
    ----------
    width, height
        Size of the picture, pixels.
    fov_deg
        Vertical opening, degrees.
    pitch_deg
        How far the optical axis is above the horizon, degrees; negative looks down.
    """

    def __init__(self, width: int, height: int, fov_deg: float, pitch_deg: float) -> None:
        self.width, self.height = width, height
        self.fov_deg, self.pitch_rad = fov_deg, math.radians(pitch_deg)
        self.focal_px = height / 2 / math.tan(math.radians(fov_deg) / 2)

    @property
    def horizontal_fov_deg(self) -> float:
        """Horizontal opening, degrees."""
        return math.degrees(2 * math.atan(self.width / 2 / self.focal_px))

    def axes(self, yaw_rad: float) -> NDArray[np.float64]:
        """Return what is right, up and back of the camera in the world, as columns."""
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        cp, sp = math.cos(self.pitch_rad), math.sin(self.pitch_rad)
        right, forward = (s, -c, 0.0), (c * cp, s * cp, sp)
        up = (-c * sp, -s * sp, cp)
        return np.column_stack([right, up, [-f for f in forward]])

    def project(self, points: NDArray[np.float64], pose: VehiclePose) -> NDArray[np.float64]:
        """Return column and row of points seen from the pose of the camera.

        Parameters
        ----------
        points
            Metres, shape (N, 3).

        Returns
        -------
        numpy.ndarray
            Shape (N, 2), row 0 on top; nan for what is behind the camera.
        """
        right, up, back = ((points - np.array(pose[:3])) @ self.axes(pose.yaw_rad)).T
        depth = np.where(back < -1e-6, -back, np.nan)
        return np.column_stack(
            [
                self.width / 2 + self.focal_px * right / depth,
                self.height / 2 - self.focal_px * up / depth,
            ]
        )

    def ground_point(
        self, column: float, row: float, pose: VehiclePose, z_m: float = 0.0
    ) -> tuple[float, float, float] | None:
        """Return where a pixel's line of sight meets a level plane, and how far away that is.

        Parameters
        ----------
        column, row
            The pixel, as `project` counts them.
        pose
            Where the camera is taken to be.
        z_m
            Height of the plane, metres.

        Returns
        -------
        tuple or None
            x, y and distance in metres; None where it looks above the horizon.
        """
        along = self.axes(pose.yaw_rad) @ np.array(
            [
                (column - self.width / 2) / self.focal_px,
                (self.height / 2 - row) / self.focal_px,
                -1.0,
            ]
        )
        if along[2] > -1e-6:
            return None
        reach = (z_m - pose.z_m) / along[2]
        x, y = pose.x_m + reach * along[0], pose.y_m + reach * along[1]
        return float(x), float(y), float(reach * np.linalg.norm(along))

    def pixel_area_m2(self, column: float, row: float, distance_m: float) -> float:
        """Return the area across the line of sight that a pixel covers at a distance.

        Notes
        -----
        A pixel off the axis by the angle t sees a solid angle of cos(t)^3 / f^2: towards the border
        of a picture the same thing takes more pixels.

        Examples
        --------
        >>> lens = Pinhole(480, 360, 90.0, 0.0)
        >>> middle, corner = (lens.pixel_area_m2(*at, 10.0) for at in ((240, 180), (480, 360)))
        >>> round(middle / corner, 2)
        7.34
        """
        u, v = (column - self.width / 2) / self.focal_px, (row - self.height / 2) / self.focal_px
        cosine = 1 / math.sqrt(1 + u * u + v * v)
        return (distance_m / self.focal_px) ** 2 * cosine**3


class Camera:
    """A camera under the drone, level by its gimbal, that looks forward and down.

    Parameters
    ----------
    world
        What it sees.
    drone
        What carries it.
    width, height
        Size of its pictures, pixels.
    fov_deg
        Vertical opening, degrees.
    pitch_deg
        How far the optical axis is above the horizon, degrees.

    Raises
    ------
    InputError
        When a number is out of its range. That no pictures can be made here is said when the first
        one is asked for: rays need none.

    Notes
    -----
    In a picture of 5 to 3 and 76 degrees that looks 55 degrees down, all of a fan of 90 degrees
    from 2.5 to 17.5 m before the drone is seen from 10 m up, and all of 98 of 100 targets that
    stand anywhere in the cells of the fan, whichever way they face. There are no shadows and no
    multisampling, which take nine tenths of the time in software. Close it, or use it in a ``with``
    statement: the memory of the pictures is not Python's.
    """

    def __init__(
        self,
        world: World,
        drone: Drone,
        *,
        width: int = 600,
        height: int = 360,
        fov_deg: float = 76.0,
        pitch_deg: float = -55.0,
    ) -> None:
        if not (8 <= width <= 1280 and 8 <= height <= 960):
            raise InputError(f"The picture is {width} x {height}; expected 8 to 1280 x 960 pixels")
        if not (1 <= fov_deg <= 150 and -90 <= pitch_deg < 90):
            raise InputError(
                f"fov_deg is {fov_deg} and pitch_deg {pitch_deg}; expected [1, 150] and [-90, 90)"
            )
        self.world, self.drone = world, drone
        self.lens = Pinhole(width, height, fov_deg, pitch_deg)
        self._renderers: dict[tuple[int, int], Any] = {}
        self._eye = world.model.camera("eye").id
        self._hidden = mujoco().MjvOption()
        self._hidden.geomgroup[SEEN_GROUP] = 0

    def __enter__(self) -> Camera:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Free the memory of the pictures; a picture asked for later takes it again."""
        for renderer in self._renderers.values():
            renderer.close()
        self._renderers.clear()

    @property
    def pose(self) -> VehiclePose:
        """Where it is in truth; its yaw is the drone's."""
        return self._under(self.drone.pose)

    @property
    def estimated_pose(self) -> VehiclePose:
        """Where the drone believes it to be."""
        return self._under(self.drone.estimated_pose)

    def picture(self) -> NDArray[np.uint8]:
        """Return what it sees: red, green and blue, shape (height, width, 3)."""
        return self._render(self.lens.width, self.lens.height, "scene")

    def segmentation(self) -> NDArray[np.int32]:
        """Return which geom each pixel shows, -1 for the sky, shape (height, width)."""
        seen = self._render(self.lens.width, self.lens.height, "segmentation")
        geoms: NDArray[np.int32] = np.where(
            seen[..., 1] == int(mujoco().mjtObj.mjOBJ_GEOM), seen[..., 0], -1
        ).astype(np.int32)
        return geoms

    def image(self, kind: ImageKind) -> CameraImage:
        """Return a picture with the camera that took it, as a `Vehicle` gives it."""
        if kind == "scene":
            pixels: NDArray[Any] = self.picture()
        else:
            names = {n: i + 1 for i, n in enumerate(self.world.object_names())}
            table = np.array([names.get(o, 0) for o in (*self.world.geom_owners, "")])
            pixels = table[self.segmentation()]
        return CameraImage(pixels, self.pose, self.lens.pitch_rad, self.lens.horizontal_fov_deg)

    def chase(
        self,
        width: int = 640,
        height: int = 480,
        *,
        distance_m: float = 16.0,
        elevation_deg: float = -32.0,
    ) -> NDArray[np.uint8]:
        """Return the drone and the city from behind it, shape (height, width, 3)."""
        mj, pose = mujoco(), self.drone.pose
        view = mj.MjvCamera()
        ahead = 4.0
        view.lookat[:] = (
            pose.x_m + ahead * math.cos(pose.yaw_rad),
            pose.y_m + ahead * math.sin(pose.yaw_rad),
            pose.z_m - 2.0,
        )
        view.distance, view.elevation = distance_m, elevation_deg
        view.azimuth = math.degrees(pose.yaw_rad)
        return self._render(width, height, "scene", view)

    def overview(
        self,
        at: tuple[float, float],
        width: int = 800,
        height: int = 600,
        *,
        distance_m: float = 150.0,
        azimuth_deg: float = 60.0,
        elevation_deg: float = -45.0,
    ) -> NDArray[np.uint8]:
        """Return the city around a place, with the drone in it, shape (height, width, 3)."""
        view = mujoco().MjvCamera()
        view.lookat[:] = (*at, 0.0)
        view.distance, view.azimuth, view.elevation = distance_m, azimuth_deg, elevation_deg
        return self._render(width, height, "scene", view)

    def _under(self, pose: VehiclePose) -> VehiclePose:
        return pose._replace(z_m=pose.z_m - _BELOW_M)

    def _render(
        self, width: int, height: int, kind: Literal["scene", "segmentation"], view: Any = None
    ) -> NDArray[Any]:
        renderer, data, model = self._renderer(width, height), self.drone.data, self.world.model
        if kind == "segmentation":
            renderer.enable_segmentation_rendering()
        try:
            if view is None:
                # A camera of the world that is carried along by hand.
                data.cam_xpos[self._eye] = self.pose[:3]
                data.cam_xmat[self._eye] = self.lens.axes(self.pose.yaw_rad).ravel()
                model.cam_fovy[self._eye] = self.lens.fov_deg
                renderer.update_scene(data, self._eye, self._hidden)
            else:
                renderer.update_scene(data, view)
            pixels: NDArray[Any] = renderer.render()
        finally:
            renderer.disable_segmentation_rendering()
        return pixels

    def _renderer(self, width: int, height: int) -> Any:
        if (width, height) not in self._renderers:
            fault = rendering_fault()
            made = None
            if not fault:
                try:
                    made = mujoco().Renderer(self.world.model, height, width)
                except Exception as error:  # the ways in which a driver can fail are many
                    fault = f"{type(error).__name__}: {error}".partition("\n")[0]
            if made is None:
                raise InputError(
                    f"No pictures can be made here ({fault}); install what is missing, as with "
                    f"{GL_PACKAGES}, or sense with rays, which need none"
                )
            self._renderers[width, height] = made
        return self._renderers[width, height]
