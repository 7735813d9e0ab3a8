"""The controller, the wind and the position estimate of the quadrotor, as machine code.

Legend: in `memory`, see the indices; vectors have 3 numbers; R is the rotation from body to world.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sloop_ppl.planning._compile import inlined, jit
from sloop_ppl.simulation._airframe import (
    ARM_M,
    GRAVITY_M_S2,
    INERTIA_KG_M2,
    MASS_KG,
    MOST_THRUST_N,
    SPIN,
    TORQUE_M,
)

__all__ = ["CONTROL_S", "DRIFT", "ESTIMATE", "MEMORY", "NOISES", "autopilot_step", "no_memory"]

CONTROL_S = 0.01
"""Time between two steps of the controller, seconds."""

INTEGRAL, DRIFT, GUST, ESTIMATE, NOISE = 0, 3, 7, 10, 14
MEMORY = 18
"""Numbers that the autopilot keeps: integral, drift (x y z yaw), gust, estimate (x y z yaw),
noise."""

NOISES = 11
"""Standard normal numbers that a step uses: drift 4, noise 4, gust 3."""

# Gains of a critically damped position loop and of an attitude loop five times as quick.
_KP, _KV, _KI = 4.5, 3.6, 1.2
_WN, _ZETA = 16.0, 0.9
_MOST_INTEGRAL = 2.0
_MOST_SIDE = 5.0
_MOST_CLIMB = 4.0
_DRAG = 0.30
"""Newtons for each metre a second of air speed."""

_GUST_S, _DRIFT_S = 1.5, 20.0
_MASS, _GRAVITY, _ARM, _TORQUE, _MOST = MASS_KG, GRAVITY_M_S2, ARM_M, TORQUE_M, MOST_THRUST_N
_IX, _IY, _IZ = INERTIA_KG_M2
_SPIN0, _SPIN1, _SPIN2, _SPIN3 = SPIN


@inlined
def _clip(value: float, most: float) -> float:
    return max(-most, min(most, value))


@jit
def autopilot_step(
    qpos: Any,
    qvel: Any,
    goal: Any,
    memory: Any,
    noise: Any,
    air: Any,
    thrust: Any,
    force: Any,
) -> None:
    """Work out thrusts and the force of the air for one step of `CONTROL_S`.

    Parameters
    ----------
    qpos, qvel
        State of the free joint as MuJoCo has it: position and quaternion; linear velocity in the
        world and angular velocity in the body.
    goal
        Place, velocity, acceleration (3 each), yaw and yaw rate that are wanted now, shape (11,).
    memory
        What is kept from step to step, shape (`MEMORY`,); changed.
    noise
        Standard normal numbers, shape (`NOISES`,).
    air
        Mean wind (2), standard deviation of its gusts, and those of drift of the position, of its
        noise and of drift of the yaw, shape (6,).
    thrust, force
        Where the four thrusts (N) and the force of the air (3, N) are written.

    Notes
    -----
    Geometric tracking control of Lee, Leok and McClamroch (2010) on SE(3), with an integral term
    against steady wind. Gusts and drift are Ornstein-Uhlenbeck processes.
    """
    dt = CONTROL_S
    # What the drone believes: truth, slow drift, and noise that is filtered to a tenth of a second.
    keep = math.exp(-dt / _DRIFT_S)
    fresh = math.sqrt(1.0 - keep * keep)
    for i in range(4):
        sd = air[3] if i < 3 else air[5]
        memory[DRIFT + i] = keep * memory[DRIFT + i] + fresh * sd * noise[i]
    soft = math.exp(-dt / 0.1)
    for i in range(4):
        sd = air[4] if i < 3 else 0.1 * air[5]
        memory[NOISE + i] = (
            soft * memory[NOISE + i] + math.sqrt(1.0 - soft * soft) * sd * noise[4 + i]
        )
    w, x, y, z = qpos[3], qpos[4], qpos[5], qpos[6]
    r00, r01, r02 = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    r10, r11, r12 = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    r20, r21, r22 = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    for i in range(3):
        memory[ESTIMATE + i] = qpos[i] + memory[DRIFT + i] + memory[NOISE + i]
    memory[ESTIMATE + 3] = math.atan2(r10, r00) + memory[DRIFT + 3] + memory[NOISE + 3]

    # The acceleration that is wanted, with the weight held up.
    ex, ey, ez = (
        goal[0] - memory[ESTIMATE],
        goal[1] - memory[ESTIMATE + 1],
        goal[2] - memory[ESTIMATE + 2],
    )
    memory[INTEGRAL] = _clip(memory[INTEGRAL] + ex * dt, _MOST_INTEGRAL)
    memory[INTEGRAL + 1] = _clip(memory[INTEGRAL + 1] + ey * dt, _MOST_INTEGRAL)
    memory[INTEGRAL + 2] = _clip(memory[INTEGRAL + 2] + ez * dt, _MOST_INTEGRAL)
    ax = _KP * ex + _KV * (goal[3] - qvel[0]) + _KI * memory[INTEGRAL] + goal[6]
    ay = _KP * ey + _KV * (goal[4] - qvel[1]) + _KI * memory[INTEGRAL + 1] + goal[7]
    az = _KP * ez + _KV * (goal[5] - qvel[2]) + _KI * memory[INTEGRAL + 2] + goal[8]
    side = math.sqrt(ax * ax + ay * ay)
    if side > _MOST_SIDE:
        ax, ay = ax * _MOST_SIDE / side, ay * _MOST_SIDE / side
    az = _clip(az, _MOST_CLIMB) + _GRAVITY
    total = _MASS * (ax * r02 + ay * r12 + az * r22)

    # The attitude that points the thrust there and the nose along the yaw that is wanted, which
    # the drone knows up to its drift.
    size = math.sqrt(ax * ax + ay * ay + az * az)
    d02, d12, d22 = ax / size, ay / size, az / size
    yaw = goal[9] - memory[DRIFT + 3]
    cx, cy = math.cos(yaw), math.sin(yaw)
    d01, d11, d21 = d12 * 0.0 - d22 * cy, d22 * cx - d02 * 0.0, d02 * cy - d12 * cx
    size = math.sqrt(d01 * d01 + d11 * d11 + d21 * d21)
    d01, d11, d21 = d01 / size, d11 / size, d21 / size
    d00, d10, d20 = d11 * d22 - d21 * d12, d21 * d02 - d01 * d22, d01 * d12 - d11 * d02
    # e_R = vee(Rd^T R - R^T Rd) / 2, by columns of both.
    col = (
        d02 * r01 + d12 * r11 + d22 * r21,
        d01 * r02 + d11 * r12 + d21 * r22,
        d00 * r02 + d10 * r12 + d20 * r22,
        d02 * r00 + d12 * r10 + d22 * r20,
        d01 * r00 + d11 * r10 + d21 * r20,
        d00 * r01 + d10 * r11 + d20 * r21,
    )
    err0, err1, err2 = (col[0] - col[1]) / 2, (col[2] - col[3]) / 2, (col[4] - col[5]) / 2
    wx, wy, wz = qvel[3], qvel[4], qvel[5]
    # The rate of the yaw that is wanted, seen from the body.
    gx, gy, gz = wx - goal[10] * r20, wy - goal[10] * r21, wz - goal[10] * r22
    kr, kw = _WN * _WN, 2.0 * _ZETA * _WN
    mx = -_IX * (kr * err0 + kw * gx) + (_IZ - _IY) * wy * wz
    my = -_IY * (kr * err1 + kw * gy) + (_IX - _IZ) * wz * wx
    mz = -_IZ * (0.25 * kr * err2 + 0.5 * kw * gz) + (_IY - _IX) * wx * wy
    mz = _clip(mz, 0.1)

    # Rotors stand at (a, a), (-a, a), (-a, -a), (a, -a) and turn by turns.
    base, roll, pitch = total / 4, mx / (4 * _ARM), my / (4 * _ARM)
    turn = mz / (4 * _TORQUE)
    thrust[0] = max(0.0, min(_MOST, base + roll - pitch + _SPIN0 * turn))
    thrust[1] = max(0.0, min(_MOST, base + roll + pitch + _SPIN1 * turn))
    thrust[2] = max(0.0, min(_MOST, base - roll + pitch + _SPIN2 * turn))
    thrust[3] = max(0.0, min(_MOST, base - roll - pitch + _SPIN3 * turn))

    # The air: mean wind and gusts; drag grows with the speed against it.
    keep = math.exp(-dt / _GUST_S)
    fresh = math.sqrt(1.0 - keep * keep)
    for i in range(3):
        part = 1.0 if i < 2 else 0.3
        memory[GUST + i] = keep * memory[GUST + i] + fresh * air[2] * part * noise[8 + i]
    force[0] = _DRAG * (air[0] + memory[GUST] - qvel[0])
    force[1] = _DRAG * (air[1] + memory[GUST + 1] - qvel[1])
    force[2] = _DRAG * (memory[GUST + 2] - qvel[2])


def no_memory() -> Any:
    """Return the memory of an autopilot that has just been switched on."""
    return np.zeros(MEMORY)
