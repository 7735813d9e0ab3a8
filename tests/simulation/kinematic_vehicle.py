"""A vehicle without physics: it flies straight lines through boxes, and a pinhole camera sees."""

from __future__ import annotations

import math

import numpy as np

from sloop_ppl.simulation import CameraImage, VehiclePose

STEP_S = 0.02


class Box:
    """An upright box on the ground: west, south, east, north and height, metres."""

    def __init__(self, west, south, east, north, height):
        self.low = np.array([west, south, 0.0])
        self.high = np.array([east, north, height])

    def holds(self, point):
        return bool((point >= self.low).all() and (point <= self.high).all())

    def distance(self, origin, rays):
        """Return how far along each ray the box begins, infinite where it is missed."""
        with np.errstate(divide="ignore", invalid="ignore"):
            near, far = (self.low - origin) / rays, (self.high - origin) / rays
        begins = np.nanmax(np.minimum(near, far), axis=-1)
        ends = np.nanmin(np.maximum(near, far), axis=-1)
        return np.where((ends >= begins) & (ends > 0), np.maximum(begins, 0.0), np.inf)


class KinematicVehicle:
    """Flies at the speed asked for, stops in front of what it hits, and knows where it is.

    `bias` is what the estimate is off by: east and north in metres, yaw in radians.
    """

    def __init__(self, boxes=(), start=(0.0, 0.0, 0.0, 0.0), bias=(0.0, 0.0, 0.0),
                 size=(160, 120), pitch_rad=-0.87, fov_deg=90.0, wait=None):  # fmt: skip
        self.boxes, self.pose = dict(boxes), VehiclePose(*start)
        self.bias, self.collision, self.wait = bias, None, wait
        self.size, self.pitch_rad, self.fov_deg = size, pitch_rad, fov_deg
        self.threads, self.flown = set(), []

    @property
    def estimated_pose(self):
        x, y, z, yaw = self.pose
        return VehiclePose(x + self.bias[0], y + self.bias[1], z, yaw + self.bias[2])

    def take_off(self, stop=None):
        return self._fly((*self.pose[:2], 3.0), 2.0, stop)

    def land(self, stop=None):
        return self._fly((*self.pose[:2], 0.0), 2.0, stop)

    def hover(self, stop=None):
        return True

    def move_to(self, x_m, y_m, z_m, speed_m_s, stop=None):
        # It steers by what it believes.
        return self._fly((x_m - self.bias[0], y_m - self.bias[1], z_m), speed_m_s, stop)

    def yaw_to(self, yaw_rad, stop=None):
        self.collision = None
        left = math.remainder(yaw_rad - self.bias[2] - self.pose.yaw_rad, 2 * math.pi)
        while left:
            if self._step(stop):
                return False
            turn = math.copysign(min(abs(left), STEP_S * 1.5), left)
            left -= turn
            self.pose = self.pose._replace(yaw_rad=(self.pose.yaw_rad + turn) % (2 * math.pi))
        return True

    def camera_image(self, kind):
        self._note_thread()
        width, height = self.size
        focal = width / 2 / math.tan(math.radians(self.fov_deg) / 2)
        right = (np.arange(width) + 0.5 - width / 2) / focal
        down = (np.arange(height) + 0.5 - height / 2) / focal
        yaw, pitch = self.pose.yaw_rad, self.pitch_rad
        forward = np.array([math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch),
                            math.sin(pitch)])  # fmt: skip
        to_right = np.array([math.sin(yaw), -math.cos(yaw), 0.0])
        rays = (forward + right[None, :, None] * to_right
                + down[:, None, None] * np.cross(forward, to_right))  # fmt: skip
        origin = np.array(self.pose[:3])
        nearest, seen = np.full((height, width), np.inf), np.zeros((height, width), dtype=np.int64)
        for number, box in enumerate(self.boxes.values(), start=1):
            distance = box.distance(origin, rays)
            seen[distance < nearest] = number
            nearest = np.minimum(nearest, distance)
        pixels = seen if kind == "segmentation" else np.repeat(
            (seen[..., None] * 40 % 256).astype(np.uint8), 3, axis=2)  # fmt: skip
        return CameraImage(pixels, self.pose, pitch, self.fov_deg)

    def objects(self):
        return list(self.boxes)

    def object_pose(self, name):
        box = self.boxes[name]
        return VehiclePose(*((box.low + box.high) / 2), 0.0)

    def _fly(self, goal, speed, stop):
        self.collision = None
        self.flown.append(tuple(round(v, 6) for v in goal))
        goal = np.array(goal, dtype=float)
        while True:
            here = np.array(self.pose[:3])
            left = float(np.linalg.norm(goal - here))
            if left < 1e-9:
                return True
            if self._step(stop):
                return False
            there = here + (goal - here) * min(1.0, STEP_S * speed / left)
            for name, box in self.boxes.items():
                if box.holds(there):
                    self.collision = name
                    while not self._step(stop):
                        pass
                    return False
            self.pose = VehiclePose(*there.tolist(), self.pose.yaw_rad)

    def _step(self, stop):
        self._note_thread()
        if self.wait is not None:
            self.wait()
        return stop is not None and stop()

    def _note_thread(self):
        import threading

        self.threads.add(threading.get_ident())
