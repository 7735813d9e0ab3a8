"""Say which way real buildings face, by their address or their main entrance."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import shapely

from sloop_ppl.maps import CityMap

__all__ = ["FrameLabel", "address_labels", "entrance_labels"]

_WITHIN_M = 60.0


@dataclass(frozen=True)
class FrameLabel:
    """Which way a building faces.

    Parameters
    ----------
    building : id of the building.
    front_rad : the direction, radians anticlockwise from east.
    """

    building: str
    front_rad: float


def address_labels(city: CityMap, buildings: Iterable[str] | None = None) -> list[FrameLabel]:
    """Return the front of each building that tells the street of its address.

    Parameters
    ----------
    city : the map.
    buildings : ids of those to look at; all buildings when None.

    Notes
    -----
    The rule: a building faces the nearest point, from its centroid, of the street or square that
    `addr:street` names. An address whose street is more than 60 m from the building's wall tells
    nothing of its front, nor does one whose street is not on the map.
    """
    labels = []
    for building in _ids(city, buildings):
        facing = city.frontage(building).by_address
        if facing is None:
            continue
        if shapely.Point(facing.point_m).distance(city.footprint(building)) <= _WITHIN_M:
            labels.append(FrameLabel(building, facing.bearing_rad))
    return labels


def entrance_labels(city: CityMap, buildings: Iterable[str] | None = None) -> list[FrameLabel]:
    """Return the front of each building whose main entrance is known: out of its wall."""
    found = ((b, city.frontage(b).by_entrance) for b in _ids(city, buildings))
    return [FrameLabel(b, facing.bearing_rad) for b, facing in found if facing is not None]


def _ids(city: CityMap, buildings: Iterable[str] | None) -> Iterable[str]:
    return (b.id for b in city.of_kind("building")) if buildings is None else buildings
