"""A quadrotor that flies in a world: rotors, wind, an estimate of where it is, and commands."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.rng import child
from sloop_ppl.simulation._airframe import BODY, GRAVITY_M_S2, MASS_KG
from sloop_ppl.simulation._autopilot import (
    CONTROL_S,
    DRIFT,
    ESTIMATE,
    NOISES,
    autopilot_step,
    no_memory,
)
from sloop_ppl.simulation._mujoco import mujoco
from sloop_ppl.simulation._paths import Ramp, line_time, turn_time
from sloop_ppl.simulation.vehicle import Stop, VehiclePose
from sloop_ppl.simulation.world import World

__all__ = ["Drone"]

_BATCH = 512
_ARRIVED_M, _ARRIVED_RAD, _ARRIVED_M_S = 0.25, math.radians(1.5), 0.25
_REST_M = 0.1
_ON_GROUND_M = 0.07


class Drone:
    """A quadrotor with four rotors in a world.

    Parameters
    ----------
    world
        Where it flies.
    start
        x and y in metres and, if given, the yaw in radians anticlockwise from east.
    altitude_m
        How high it hangs in the air at first, metres; on the ground when 0.
    wind_m_s
        Speed of the mean wind, from a direction of the seed, metres a second.
    gust_m_s
        Standard deviation of the gusts, metres a second; a third of the wind when None.
    drift_m
        Standard deviation of the slow drift of the position that the drone believes, per axis,
        metres.
    noise_m
        That of its quick noise.
    yaw_drift_rad
        That of the slow drift of the yaw, radians.
    battery_steps
        How many steps of a search the battery lasts; for ever when None.
    speed_m_s
        Speed of the moves of a search.
    rng
        Where wind, drift and noise are drawn from.

    Attributes
    ----------
    data
        The ``MjData`` of the world, as it is now.
    time_s
        Simulated time since it was made, seconds.
    steps_left
        Steps of the battery that are left; None where it lasts for ever.

    Raises
    ------
    InputError
        When the start is inside a building or no start, or a number is out of its range.

    Notes
    -----
    Rotors follow what they are told with a lag of 40 ms. The controller runs 100 times a second, in
    machine code, and steers by the estimate; it is told the true velocity and tilt, as an inertial
    unit measures them. All randomness comes from `rng`: the same seed flies the same way.
    """

    def __init__(
        self,
        world: World,
        start: tuple[float, ...] = (0.0, 0.0),
        *,
        altitude_m: float = 14.0,
        wind_m_s: float = 0.0,
        gust_m_s: float | None = None,
        drift_m: float = 0.15,
        noise_m: float = 0.02,
        yaw_drift_rad: float = math.radians(0.5),
        battery_steps: int | None = None,
        speed_m_s: float = 6.0,
        rng: np.random.Generator,
    ) -> None:
        gusts = wind_m_s / 3 if gust_m_s is None else gust_m_s
        _check_numbers(
            altitude_m=altitude_m, wind_m_s=wind_m_s, gust_m_s=gusts, drift_m=drift_m,
            noise_m=noise_m, yaw_drift_rad=yaw_drift_rad,
        )  # fmt: skip
        if not 0 < speed_m_s <= 15:
            raise InputError(f"speed_m_s is {speed_m_s}; expected a number in (0, 15]")
        mj = mujoco()
        self.world, self.speed_m_s, self.steps_left = world, float(speed_m_s), battery_steps
        x, y, yaw = _checked_start(world, start, altitude_m)
        self.data = mj.MjData(world.model)
        self._step: Callable[..., None] = mj.mj_step
        body = world.model.body(BODY).id
        joint = world.model.joint(BODY)
        self._qpos = self.data.qpos[joint.qposadr[0] : joint.qposadr[0] + 7]
        self._qvel = self.data.qvel[joint.dofadr[0] : joint.dofadr[0] + 6]
        self._force = self.data.xfrc_applied[body, :3]
        self._thrust = self.data.ctrl[:4]
        self._substeps = round(CONTROL_S / world.model.opt.timestep)
        self._rng = child(rng, "drone")
        self._noise, self._row = self._rng.standard_normal((_BATCH, NOISES)), 0
        self._memory = no_memory()
        self._deviations = np.array([drift_m] * 3 + [yaw_drift_rad])
        towards = float(child(rng, "wind").uniform(0, 2 * math.pi))
        self._air = np.array(
            [
                wind_m_s * math.cos(towards), wind_m_s * math.sin(towards), gusts,
                drift_m, noise_m, yaw_drift_rad,
            ]
        )  # fmt: skip
        self._goal = np.zeros(11)
        self._watchers: list[tuple[Callable[[Drone], None], int]] = []
        self._ticks = 0
        self._collision: str | None = None
        self._leaving: set[str] = set()
        self._hull = world.model.geom(f"{BODY}/hull").id
        self._flying = altitude_m > 0
        self.put(x, y, altitude_m or _ON_GROUND_M, yaw)

    @property
    def time_s(self) -> float:
        """Simulated time, seconds."""
        return self._ticks * CONTROL_S

    @property
    def pose(self) -> VehiclePose:
        """Where it is in truth."""
        return self._pose

    @property
    def estimated_pose(self) -> VehiclePose:
        """Where it believes to be."""
        return self._estimated

    @property
    def velocity_m_s(self) -> tuple[float, float, float]:
        """True velocity, east, north and up."""
        vx, vy, vz = self._qvel[:3].tolist()
        return vx, vy, vz

    @property
    def collision(self) -> str | None:
        """Name of what it ran into since the last command began: a building or the ground."""
        return self._collision

    @property
    def is_upright(self) -> bool:
        """Whether it flies the right way up and above the ground."""
        _, x, y, _ = self._qpos[3:].tolist()
        return self._pose.z_m > 0.5 and 1.0 - 2.0 * (x * x + y * y) > 0.0

    def put(self, x_m: float, y_m: float, z_m: float, yaw_rad: float = 0.0) -> None:
        """Put it somewhere at rest, with a new error of its estimate; time goes on."""
        drift = self._deviations * self._rng.standard_normal(4)
        if z_m <= _ON_GROUND_M:
            drift[2] = 0.0
        self._qpos[:] = x_m, y_m, z_m, math.cos(yaw_rad / 2), 0.0, 0.0, math.sin(yaw_rad / 2)
        self._qvel[:] = 0.0
        self._memory[:] = 0.0
        self._memory[DRIFT : DRIFT + 4] = drift
        self._memory[ESTIMATE : ESTIMATE + 4] = np.array([x_m, y_m, z_m, yaw_rad]) + drift
        self._goal[:] = 0.0
        self._goal[:3] = self._memory[ESTIMATE : ESTIMATE + 3]
        self._goal[9] = self._memory[ESTIMATE + 3]
        self._collision = None
        if self._flying:
            self.data.act[:4] = MASS_KG * GRAVITY_M_S2 / 4
        mujoco().mj_forward(self.world.model, self.data)
        self._settle_poses()

    def watch(self, callback: Callable[[Drone], None], every_s: float) -> None:
        """Call back with the drone again and again while it flies, such as to film it.

        Parameters
        ----------
        every_s
            Simulated time between two calls, seconds, at least 0.01.
        """
        self._watchers.append((callback, max(1, round(every_s / CONTROL_S))))

    def take_off(self, stop: Stop | None = None, *, altitude_m: float = 3.0) -> bool:
        """Leave the ground, straight up; a drone that flies already is there."""
        self._collision = None
        if self._flying and self._estimated.z_m >= altitude_m - _ARRIVED_M:
            return True
        self._flying = True
        return self._fly_line((*self._goal[:2].tolist(), altitude_m), 2.0, stop)

    def land(self, stop: Stop | None = None) -> bool:
        """Come down where it is and switch the rotors off."""
        self._collision = None
        x, y = self._goal[:2].tolist()
        if not self._flying:
            return True
        for z, speed in ((2.0, 3.0), (-0.3, 0.6)):
            if self._pose.z_m > z and not self._fly_line((x, y, z), speed, stop, to_ground=z < 0):
                return False
        self._flying, self._collision = False, None
        self._memory[:3] = 0.0
        self._thrust[:] = 0.0
        for _ in range(50):
            self._tick()
        return True

    def hover(self, stop: Stop | None = None, *, seconds: float = 0.0) -> bool:
        """Come to rest where it is, and stay so long."""
        self._collision = None
        e = self._estimated
        self._goal[:] = e.x_m, e.y_m, e.z_m, 0, 0, 0, 0, 0, 0, e.yaw_rad, 0
        return self._settle(stop, _REST_M) and self._wait(seconds, stop)

    def move_to(
        self,
        x_m: float,
        y_m: float,
        z_m: float,
        speed_m_s: float | None = None,
        stop: Stop | None = None,
    ) -> bool:
        """Fly straight to a place, by its own estimate; the yaw stays.

        Parameters
        ----------
        speed_m_s
            Most speed on the way; that of the drone when None.

        Returns
        -------
        bool
            Whether it got there: False after a collision, when stopped, or when it is held up.

        Raises
        ------
        InputError
            When a number is not finite, or the speed not in (0, 15].
        """
        speed = self.speed_m_s if speed_m_s is None else speed_m_s
        if not all(math.isfinite(v) for v in (x_m, y_m, z_m, speed)):
            raise InputError(
                f"The place to fly to is ({x_m}, {y_m}, {z_m}) at {speed} m/s; expected finite "
                "numbers"
            )
        if not 0 < speed <= 15:
            raise InputError(f"speed_m_s is {speed}; expected a number in (0, 15]")
        self._collision, self._flying = None, True
        return self._fly_line((x_m, y_m, z_m), speed, stop)

    def yaw_to(self, yaw_rad: float, stop: Stop | None = None) -> bool:
        """Turn on the spot, the shorter way round, radians anticlockwise from east."""
        if not math.isfinite(yaw_rad):
            raise InputError(f"The yaw is {yaw_rad}; expected a finite number of radians")
        self._collision, self._flying = None, True
        start = float(self._goal[9])
        turn = math.remainder(yaw_rad - start, 2 * math.pi)
        ramp = Ramp(turn_time(abs(turn)))
        for k in range(ramp.ticks(CONTROL_S)):
            share, rate, _ = ramp.at((k + 1) * CONTROL_S)
            self._goal[9], self._goal[10] = start + turn * share, turn * rate
            if not self._tick() or (stop is not None and stop()):
                return self._end_here()
        self._goal[9], self._goal[10] = yaw_rad, 0.0
        return self._settle(stop, _ARRIVED_M)

    def _fly_line(
        self,
        to: tuple[float, float, float],
        speed: float,
        stop: Stop | None,
        *,
        to_ground: bool = False,
    ) -> bool:
        # What it touches now, such as the ground that it takes off from, is no new collision.
        self._leaving = self._touched() | ({"Ground"} if self._pose.z_m < 0.3 else set())
        start = self._goal[:3].copy()
        way = np.array(to) - start
        length = float(np.sqrt(way @ way))
        ramp = Ramp(line_time(length, speed))
        for k in range(ramp.ticks(CONTROL_S)):
            share, rate, curve = ramp.at((k + 1) * CONTROL_S)
            self._goal[:3] = start + way * share
            self._goal[3:6], self._goal[6:9] = way * rate, way * curve
            if not self._tick():
                return (to_ground and self._collision == "Ground") or self._end_here()
            if stop is not None and stop():
                return self._end_here()
        self._goal[:3], self._goal[3:9] = to, 0.0
        return self._settle(stop, _ARRIVED_M)

    def _settle(self, stop: Stop | None, within_m: float, most_s: float = 4.0) -> bool:
        """Wait until it is near the goal and slow; False when it does not get there."""
        for _ in range(round(most_s / CONTROL_S)):
            e, goal = self._estimated, self._goal
            off = math.dist((e.x_m, e.y_m, e.z_m), goal[:3].tolist())
            turn = abs(math.remainder(e.yaw_rad - float(goal[9]), 2 * math.pi))
            speed = math.dist(self._qvel[:3].tolist(), (0.0, 0.0, 0.0))
            if off < within_m and turn < _ARRIVED_RAD and speed < _ARRIVED_M_S:
                return True
            if not self._tick() or (stop is not None and stop()):
                return self._end_here()
        # Gusts may keep it from being slow; near enough is there.
        return off < 3 * within_m

    def _wait(self, seconds: float, stop: Stop | None) -> bool:
        for _ in range(round(seconds / CONTROL_S)):
            if not self._tick() or (stop is not None and stop()):
                return self._end_here()
        return True

    def _end_here(self) -> bool:
        """Hold the place where a command ended before its time; always False."""
        e = self._estimated
        self._goal[:] = e.x_m, e.y_m, e.z_m, 0, 0, 0, 0, 0, 0, e.yaw_rad, 0
        self._memory[:3] = 0.0
        return False

    def _tick(self) -> bool:
        """Fly on for `CONTROL_S`; False when it ran into something."""
        if self._row == _BATCH:
            self._noise, self._row = self._rng.standard_normal((_BATCH, NOISES)), 0
        autopilot_step(
            self._qpos, self._qvel, self._goal, self._memory, self._noise[self._row], self._air,
            self._thrust, self._force,
        )  # fmt: skip
        self._row += 1
        if not self._flying:
            self._thrust[:] = 0.0
        self._step(self.world.model, self.data, self._substeps)
        self._ticks += 1
        self._settle_poses()
        for callback, every in self._watchers:
            if self._ticks % every == 0:
                callback(self)
        touched = self._touched() if self.data.ncon else set()
        if self._leaving:
            self._leaving &= touched if self._pose.z_m > 0.3 else touched | {"Ground"}
        if self._flying and touched - self._leaving:
            self._collision = min(touched - self._leaving)
        return self._collision is None

    def _touched(self) -> set[str]:
        """Return the names of what the hull is in contact with."""
        pairs = self.data.contact.geom.tolist()
        others = (b if a == self._hull else a for a, b in pairs if self._hull in (a, b))
        return {self.world.geom_owners[geom] for geom in others}

    def _settle_poses(self) -> None:
        x, y, z, a, b, c, d = self._qpos.tolist()
        yaw = math.atan2(2 * (b * c + a * d), 1 - 2 * (c * c + d * d))
        self._pose = VehiclePose(x, y, z, yaw)
        ex, ey, ez, turn = self._memory[ESTIMATE : ESTIMATE + 4].tolist()
        self._estimated = VehiclePose(ex, ey, ez, math.remainder(turn, 2 * math.pi))


def _check_numbers(**numbers: float) -> None:
    for name, value in numbers.items():
        if not (math.isfinite(value) and value >= 0):
            raise InputError(f"{name} is {value}; expected a finite number of at least 0")


def _checked_start(
    world: World, start: tuple[float, ...], altitude_m: float
) -> tuple[float, float, float]:
    try:
        numbers = [float(v) for v in start]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) not in (2, 3) or not all(math.isfinite(v) for v in numbers):
        raise InputError(
            f"The start is {start!r}; expected x and y in metres and, if wanted, a yaw in radians"
        )
    x, y, yaw = (*numbers, 0.0)[:3]
    inside = world.building_at((x, y))
    if inside is not None and world.heights_m[inside] >= altitude_m - 0.5:
        label = world.city.landmark(inside).label
        raise InputError(
            f"The start ({x:g}, {y:g}) at {altitude_m:g} m is inside {label}, which is "
            f"{world.heights_m[inside]:g} m tall; start elsewhere, or fly higher"
        )
    return x, y, yaw
