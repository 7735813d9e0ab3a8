"""A named or nameless thing on the map that a speaker can refer to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from shapely.geometry.base import BaseGeometry

__all__ = ["KINDS", "PATH_KINDS", "Landmark"]

KINDS = (
    "building",
    "street",
    "service",
    "pedestrian",
    "parking",
    "park",
    "water",
    "square",
    "poi",
)
"""The kinds of landmark a map file may hold."""

PATH_KINDS = frozenset({"street", "service", "pedestrian"})
"""Kinds one travels along; the nearest of them tells which way a building faces."""


@dataclass(frozen=True)
class Landmark:
    """One landmark, in the map's local frame (metres, x east, y north).

    Parameters
    ----------
    id
        CamelCase symbol, unique within its map.
    kind
        One of `KINDS`.
    geometry
        Shapely point, line or polygon (or several), metres.
    name
        What people call it; None when it has no name.
    aliases
        Other names.
    within
        Id of the building a poi stands in.
    width_m
        Width of a line, metres.
    properties
        Everything else the map file says about it.
    members
        Members of its GeoJSON feature beside type, properties and geometry.
    """

    id: str
    kind: str
    geometry: BaseGeometry
    name: str | None = None
    aliases: tuple[str, ...] = ()
    within: str | None = None
    width_m: float | None = None
    properties: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}), hash=False)
    members: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}), hash=False)

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"properties": dict(self.properties), "members": dict(self.members)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            object.__setattr__(self, name, value)
        for name in ("properties", "members"):
            object.__setattr__(self, name, MappingProxyType(state[name]))

    @property
    def label(self) -> str:
        """Its name, or its id when it has none."""
        return self.name or self.id
