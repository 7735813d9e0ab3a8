"""The quadrotor's airframe: mass, arms and rotors, as numbers and as a body of MuJoCo."""

from __future__ import annotations

from typing import Any

from sloop_ppl.simulation._mujoco import mujoco

__all__ = [
    "ARM_M",
    "BODY",
    "GRAVITY_M_S2",
    "INERTIA_KG_M2",
    "MASS_KG",
    "MOST_THRUST_N",
    "MOTOR_LAG_S",
    "RADIUS_M",
    "SEEN_GROUP",
    "SPIN",
    "TORQUE_M",
    "add_airframe",
]

BODY = "drone"
MASS_KG = 1.5
INERTIA_KG_M2 = (0.020, 0.020, 0.035)
ARM_M = 0.16
"""Offset of each rotor from the middle along x and along y, metres."""

MOST_THRUST_N = 8.0
"""Most thrust of a rotor; four of them lift twice the weight."""

TORQUE_M = 0.016
"""Torque of a rotor about its axis for each newton of thrust, metres."""

SPIN = (1.0, -1.0, 1.0, -1.0)
MOTOR_LAG_S = 0.04
GRAVITY_M_S2 = 9.81
RADIUS_M = 0.33
"""How far rotors and guards reach from the middle, metres."""

SEEN_GROUP = 1
"""Group of the drone's geoms, so that its own camera and rays can leave them out."""

_PLACES = ((ARM_M, ARM_M), (-ARM_M, ARM_M), (-ARM_M, -ARM_M), (ARM_M, -ARM_M))


def add_airframe(spec: Any) -> None:
    """Add the drone to a world, with a rotor at each of its four thrust sites."""
    mj = mujoco()
    body = spec.worldbody.add_body(name=BODY, pos=[0.0, 0.0, 50.0])
    body.add_freejoint(name=BODY)
    body.mass, body.inertia, body.explicitinertial = MASS_KG, list(INERTIA_KG_M2), True
    body.ipos = [0.0, 0.0, 0.0]  # else its weight would lie where the body is put at first
    ring = {"contype": 1, "conaffinity": 1, "group": SEEN_GROUP, "mass": 0.0}
    body.add_geom(
        name=f"{BODY}/hull", type=mj.mjtGeom.mjGEOM_CYLINDER, size=[RADIUS_M, 0.06, 0.0],
        rgba=[0.0, 0.0, 0.0, 0.0], **ring,
    )  # fmt: skip
    shown = {"contype": 0, "conaffinity": 0, "group": SEEN_GROUP, "mass": 0.0}
    body.add_geom(
        name=f"{BODY}/core", type=mj.mjtGeom.mjGEOM_BOX, size=[0.13, 0.08, 0.05],
        rgba=[0.93, 0.93, 0.95, 1.0], **shown,
    )  # fmt: skip
    body.add_geom(
        name=f"{BODY}/nose", type=mj.mjtGeom.mjGEOM_BOX, pos=[0.13, 0.0, 0.0],
        size=[0.03, 0.06, 0.04], rgba=[0.95, 0.55, 0.10, 1.0], **shown,
    )  # fmt: skip
    for i, (x, y) in enumerate(_PLACES):
        body.add_site(name=f"{BODY}/rotor{i}", pos=[x, y, 0.0])
        body.add_geom(
            name=f"{BODY}/arm{i}", type=mj.mjtGeom.mjGEOM_CAPSULE,
            fromto=[0.0, 0.0, 0.0, x, y, 0.0], size=[0.015, 0.0, 0.0],
            rgba=[0.15, 0.15, 0.17, 1.0], **shown,
        )  # fmt: skip
        body.add_geom(
            name=f"{BODY}/disc{i}", type=mj.mjtGeom.mjGEOM_CYLINDER, pos=[x, y, 0.035],
            size=[0.14, 0.006, 0.0], rgba=[0.20, 0.21, 0.24, 0.75], **shown,
        )  # fmt: skip
        motor = spec.add_actuator(
            name=f"{BODY}/rotor{i}", target=f"{BODY}/rotor{i}",
            trntype=mj.mjtTrn.mjTRN_SITE, dyntype=mj.mjtDyn.mjDYN_FILTER,
            gear=[0.0, 0.0, 1.0, 0.0, 0.0, TORQUE_M * SPIN[i]],
            ctrllimited=True, ctrlrange=[0.0, MOST_THRUST_N],
        )  # fmt: skip
        motor.dynprm[0] = MOTOR_LAG_S
