"""Models of the targets, made of boxes, cylinders and capsules."""

from __future__ import annotations

import math
from typing import Any

from sloop_ppl.simulation._mujoco import mujoco
from sloop_ppl.simulation.looks import COLOURS, Look

__all__ = ["add_target_model"]

_GLASS = (0.16, 0.19, 0.23, 1.0)
_TYRE = (0.07, 0.07, 0.07, 1.0)
_SKIN = (0.72, 0.53, 0.42, 1.0)
_CLOTH = (0.16, 0.17, 0.22, 1.0)


def add_target_model(
    spec: Any, name: str, look: Look, at: tuple[float, float], heading_rad: float
) -> None:
    """Add a body that stands on the ground, with a heading.

    Parameters
    ----------
    spec
        The ``MjSpec`` of the world.
    name
        Name of the body; its parts are called ``name/part``.
    at
        x and y of its middle, metres.
    """
    half = heading_rad / 2
    body = spec.worldbody.add_body(
        name=name, pos=[at[0], at[1], 0.0], quat=[math.cos(half), 0.0, 0.0, math.sin(half)]
    )
    paint = (*COLOURS[look.colour], 1.0)
    {"car": _car, "van": _van, "bike": _bike, "person": _person}[look.kind](body, name, paint)


def _box(body: Any, name: str, pos: tuple[float, ...], size: tuple[float, ...], rgba: Any) -> None:
    kind = mujoco().mjtGeom.mjGEOM_BOX
    # MuJoCo counts half sizes.
    half = [s / 2 for s in size]
    body.add_geom(name=name, type=kind, pos=list(pos), size=half, rgba=list(rgba))


def _wheel(body: Any, name: str, pos: tuple[float, ...], radius: float, width: float) -> None:
    # A cylinder's axis is z; turned about x it lies along y.
    body.add_geom(
        name=name, type=mujoco().mjtGeom.mjGEOM_CYLINDER, pos=list(pos),
        size=[radius, width / 2, 0.0], quat=[math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0],
        rgba=list(_TYRE),
    )  # fmt: skip


def _bar(
    body: Any, name: str, start: tuple[float, ...], end: tuple[float, ...], radius: float, rgba: Any
) -> None:
    body.add_geom(
        name=name, type=mujoco().mjtGeom.mjGEOM_CAPSULE, fromto=[*start, *end],
        size=[radius, 0.0, 0.0], rgba=list(rgba),
    )  # fmt: skip


def _car(body: Any, name: str, paint: Any) -> None:
    _box(body, f"{name}/body", (0, 0, 0.62), (4.3, 1.8, 0.62), paint)
    _box(body, f"{name}/windows", (-0.25, 0, 1.10), (2.2, 1.58, 0.36), _GLASS)
    _box(body, f"{name}/roof", (-0.25, 0, 1.36), (1.9, 1.52, 0.16), paint)
    for i, (x, y) in enumerate(((1.3, 0.8), (1.3, -0.8), (-1.3, 0.8), (-1.3, -0.8))):
        _wheel(body, f"{name}/wheel{i}", (x, y, 0.33), 0.33, 0.24)


def _van(body: Any, name: str, paint: Any) -> None:
    _box(body, f"{name}/body", (-0.3, 0, 1.38), (4.8, 2.0, 2.04), paint)
    _box(body, f"{name}/bonnet", (2.35, 0, 0.85), (0.7, 1.9, 0.98), paint)
    _box(body, f"{name}/windscreen", (2.12, 0, 1.72), (0.2, 1.8, 0.7), _GLASS)
    for i, (x, y) in enumerate(((1.7, 0.9), (1.7, -0.9), (-1.7, 0.9), (-1.7, -0.9))):
        _wheel(body, f"{name}/wheel{i}", (x, y, 0.38), 0.38, 0.26)


def _bike(body: Any, name: str, paint: Any) -> None:
    for i, x in enumerate((0.55, -0.55)):
        _wheel(body, f"{name}/wheel{i}", (x, 0, 0.34), 0.34, 0.06)
    joints = {
        "crank": (-0.05, 0.0, 0.35), "saddle": (-0.22, 0.0, 0.90), "head": (0.38, 0.0, 0.85),
        "front": (0.55, 0.0, 0.34), "rear": (-0.55, 0.0, 0.34),
    }  # fmt: skip
    bars = ("crank saddle", "crank head", "saddle head", "head front", "crank rear", "saddle rear")
    for i, pair in enumerate(bars):
        start, end = (joints[j] for j in pair.split())
        _bar(body, f"{name}/bar{i}", start, end, 0.07, paint)
    _box(body, f"{name}/seat", (-0.24, 0, 0.96), (0.30, 0.16, 0.08), _CLOTH)
    _bar(body, f"{name}/handles", (0.36, -0.30, 1.0), (0.36, 0.30, 1.0), 0.05, paint)
    _box(body, f"{name}/basket", (0.62, 0, 0.92), (0.36, 0.40, 0.26), paint)
    _box(body, f"{name}/rack", (-0.55, 0, 0.76), (0.44, 0.36, 0.22), paint)


def _person(body: Any, name: str, paint: Any) -> None:
    for i, y in enumerate((0.11, -0.11)):
        _bar(body, f"{name}/leg{i}", (0, y, 0.08), (0, y, 0.80), 0.09, _CLOTH)
    _bar(body, f"{name}/trunk", (0, 0, 0.92), (0, 0, 1.32), 0.22, paint)
    for i, y in enumerate((0.30, -0.30)):
        _bar(body, f"{name}/arm{i}", (0, y, 1.36), (0.05, y, 0.86), 0.075, paint)
    body.add_geom(
        name=f"{name}/head", type=mujoco().mjtGeom.mjGEOM_SPHERE, pos=[0.0, 0.0, 1.63],
        size=[0.12, 0.0, 0.0], rgba=list(_SKIN),
    )  # fmt: skip
    # A hat in the colour of the coat: from above a person is hat and shoulders.
    body.add_geom(
        name=f"{name}/hat", type=mujoco().mjtGeom.mjGEOM_CYLINDER, pos=[0.0, 0.0, 1.72],
        size=[0.19, 0.03, 0.0], rgba=list(paint),
    )  # fmt: skip
