"""Cut a square piece out of a map."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, ClassVar, Protocol, TypeVar

import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.errors import InputError
from sloop_ppl.maps._shapes import clip
from sloop_ppl.maps.grid import Grid
from sloop_ppl.maps.landmark import Landmark

__all__ = ["window"]


class _City(Protocol):
    """What is asked of a `CityMap`, which imports this module."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def grid(self) -> Grid: ...
    @property
    def landmarks(self) -> tuple[Landmark, ...]: ...
    def reaching_into(self, area: BaseGeometry, /) -> list[int]: ...


C = TypeVar("C", bound=_City)


def window(city: C, center: tuple[float, float], side_m: float) -> C:
    """Return a square piece of a map as a map of its own.

    Parameters
    ----------
    city
        The map.
    center
        x and y of the middle of the piece, metres.
    side_m
        Its side, metres, > 0. Where it reaches over the map's border it is cut there.

    Returns
    -------
    CityMap
        The landmarks that reach into the piece, cut at its border. Frame, cell size and ids are
        those of `city`: a place has the same coordinates on both. A poi keeps its `within` when
        that building is in the piece too.

    Raises
    ------
    InputError
        When `side_m` is not a positive number.
    OutsideMap
        When the centre is not on the map.

    Examples
    --------
    >>> from sloop_ppl.maps import load_map
    >>> load_map("cleveland").window((0, 0), 50).grid.shape
    (11, 11)
    """
    x, y = center
    if not (math.isfinite(side_m) and side_m > 0):
        raise InputError(f"side_m is {side_m}; expected a positive number of metres")
    grid = city.grid
    grid.cell_at(x, y)
    half = side_m / 2
    extent = (
        max(x - half, grid.west_m),
        max(y - half, grid.south_m),
        min(x + half, grid.east_m),
        min(y + half, grid.north_m),
    )
    inside: list[Landmark] = []
    for i in city.reaching_into(shapely.box(*extent)):
        landmark = city.landmarks[i]
        geometry = clip(landmark.geometry, extent)
        if geometry is not None:
            inside.append(replace(landmark, geometry=geometry))
    ids = {m.id for m in inside}
    return replace(
        city,
        grid=Grid(*extent, cell_m=grid.cell_m, centre=grid.centre),
        landmarks=tuple(m if m.within in ids else replace(m, within=None) for m in inside),
        _cache={},
    )
