"""The streets, crossings and blocks of a map, found once and kept."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from types import MappingProxyType
from typing import Literal

import shapely
from shapely.ops import substring

from sloop_ppl.maps._cache import BoundedCache
from sloop_ppl.maps.blocks import Block, corner_towards, find_blocks
from sloop_ppl.maps.city import CityMap
from sloop_ppl.maps.crossings import Crossing, find_crossings
from sloop_ppl.maps.landmark import PATH_KINDS
from sloop_ppl.maps.street_axes import BESIDE_M, StreetAxis, street_axes

__all__ = ["NETWORKS", "StreetEnd", "StreetNetwork", "Stretch", "street_network"]

NETWORKS = BoundedCache(budget_bytes=1 << 26)
"""Networks of the maps in use, shared by maps of the same streets: 64 MiB."""

# An end this near to the border of the map is the map's, not the street's.
_BORDER_M = 3.0
# The shortest stretch, metres: crossings nearer than this are one place.
_LEAST_STRETCH_M = 1.0


@dataclass(frozen=True, eq=False)
class Stretch:
    """A part of a street between two neighbouring corners, or between a corner and an end.

    Parameters
    ----------
    street
        Position of the street in `StreetNetwork.streets`.
    spine
        Which of its spines it is a part of.
    start_m, end_m
        Where it begins and ends, metres along the spine.
    line
        The part of the spine.
    start, end
        Positions in `StreetNetwork.crossings` of the corners at its ends; None where there is none.
    start_open, end_open
        Whether the border of the map cuts it there, so that it goes on.
    """

    street: int
    spine: int
    start_m: float
    end_m: float
    line: shapely.LineString
    start: int | None
    end: int | None
    start_open: bool
    end_open: bool


@dataclass(frozen=True)
class StreetEnd:
    """An end of a street.

    Parameters
    ----------
    point_m
        x and y, metres.
    kind
        ``"crossing"`` where it ends on another street, ``"dead end"``, or ``"border"`` where it
        goes on beyond the map.
    """

    point_m: tuple[float, float]
    kind: Literal["crossing", "dead end", "border"]


@dataclass(frozen=True, eq=False)
class StreetNetwork:
    """The streets, crossings and blocks of a map; a map without streets has none of them.

    Streets are asked for by the id of any of their landmarks. What is no street has no axis, no
    crossings and no stretches: the answers are then None or empty.

    Parameters
    ----------
    streets
        Axes of all streets, service roads and pedestrian ways that are lines.
    crossings
        Where those of them meet that have a name or bound blocks.
    stretches
        Parts of these streets from corner to corner, by street, spine and position.
    blocks
        What lies between the streets.
    extent_m
        West, south, east and north border of the map, metres.
    """

    streets: tuple[StreetAxis, ...]
    crossings: tuple[Crossing, ...]
    stretches: tuple[Stretch, ...]
    blocks: tuple[Block, ...]
    extent_m: tuple[float, float, float, float]
    _by_id: Mapping[str, int]

    @cached_property
    def _crossings_by_street(self) -> dict[int, list[Crossing]]:
        found: dict[int, list[Crossing]] = {}
        for crossing in self.crossings:
            for street in crossing.streets:
                found.setdefault(street, []).append(crossing)
        return found

    def position(self, street_id: str) -> int | None:
        """Return where in `streets` the street with a landmark of this id is, or None."""
        return self._by_id.get(street_id)

    def street(self, street_id: str) -> StreetAxis | None:
        """Return the street with a landmark of this id, or None."""
        at = self.position(street_id)
        return None if at is None else self.streets[at]

    def crossings_of(self, *street_ids: str) -> tuple[Crossing, ...]:
        """Return the crossings that all of these streets meet at."""
        asked = [self.position(street_id) for street_id in street_ids]
        if not asked or None in asked:
            return ()
        return tuple(c for c in self.crossings if set(asked) <= set(c.streets))

    def stretches_of(self, street_id: str) -> tuple[Stretch, ...]:
        """Return the parts of a street from corner to corner."""
        at = self.position(street_id)
        return tuple(s for s in self.stretches if s.street == at)

    def between(self, street_id: str, one_id: str, other_id: str) -> shapely.LineString | None:
        """Return the part of a street between its crossings with two others.

        Where it crosses one of them several times the shortest such part is meant; None where it
        does not cross both.
        """
        axis = self.street(street_id)
        if axis is None:
            return None
        starts = self._on_spines(axis, self.crossings_of(street_id, one_id))
        ends = self._on_spines(axis, self.crossings_of(street_id, other_id))
        parts = [
            (abs(b - a), spine, min(a, b), max(a, b))
            for spine, a in starts
            for other_spine, b in ends
            if spine == other_spine and abs(b - a) >= _LEAST_STRETCH_M
        ]
        if not parts:
            return None
        _, spine, low, high = min(parts)
        return substring(axis.spines[spine], low, high)

    def ends(self, street_id: str) -> tuple[StreetEnd, ...]:
        """Return the ends of a street's spines; a ring has none."""
        at = self.position(street_id)
        if at is None:
            return ()
        return tuple(
            StreetEnd((float(point.x), float(point.y)), self._end_kind(at, point))
            for spine in self.streets[at].spines
            for point in shapely.get_parts(shapely.boundary(spine))
        )

    def corner_of(self, block: Block, bearing_rad: float) -> Crossing | None:
        """Return the corner of a block that a bearing from its middle means, or None.

        Parameters
        ----------
        block
            One of `blocks`.
        bearing_rad
            Direction, radians anticlockwise from east; the corner lies within 60 degrees of it.
        """
        return corner_towards(block, self.crossings, bearing_rad)

    def _on_spines(
        self, axis: StreetAxis, crossings: Sequence[Crossing]
    ) -> list[tuple[int, float]]:
        return [at for c in crossings if (at := _on_spine(axis, c)) is not None]

    def _end_kind(
        self, street: int, end: shapely.Point
    ) -> Literal["crossing", "dead end", "border"]:
        if shapely.distance(end, shapely.box(*self.extent_m).exterior) <= _BORDER_M:
            return "border"
        if not shapely.box(*self.extent_m).covers(end):
            return "border"
        for crossing in self._crossings_by_street.get(street, ()):
            if crossing.bounds_blocks:
                others = [self.streets[i] for i in crossing.streets if i != street]
                reach = _BORDER_M + max(axis.width_m for axis in others)
                if math.dist(crossing.point_m, (end.x, end.y)) <= reach:
                    return "crossing"
        return "dead end"


def street_network(city: CityMap) -> StreetNetwork:
    """Return the streets, crossings and blocks of a map.

    Parameters
    ----------
    city
        The map. Only its border and its paths count, not the size of its cells.

    Examples
    --------
    >>> from sloop_ppl.maps import load_map
    >>> network = street_network(load_map("washington_dc"))
    >>> [c.streets for c in network.crossings_of("FStreetNorthwest", "20thStreetNorthwest")]
    [(0, 1)]
    >>> network.ends("FStreetNorthwest")[0].kind
    'border'
    """
    return city.derived(
        "street network", lambda: NETWORKS.get(_key(city), lambda: _network(city), _cost(city))
    )


def _key(city: CityMap) -> str:
    """Return what networks are known by: all that counts of the paths, and the border."""
    digest = hashlib.sha256(repr(city.grid.extent_m).encode())
    for m in city.of_kind(*PATH_KINDS):
        known = (m.id, m.kind, m.name, m.aliases, m.width_m, sorted(m.properties.items()))
        digest.update(repr(known).encode())
        digest.update(m.geometry.wkb)
    return digest.hexdigest()


def _cost(city: CityMap) -> int:
    # Each point lies on an axis, on a spine and on the outlines of two blocks.
    points = sum(shapely.get_num_coordinates(m.geometry) for m in city.of_kind(*PATH_KINDS))
    return 4096 + 200 * int(points)


def _network(city: CityMap) -> StreetNetwork:
    extent = city.grid.extent_m
    axes = street_axes(city.of_kind(*PATH_KINDS), extent)
    crossings = find_crossings(axes, extent)
    blocks = find_blocks(axes, crossings, extent)
    by_id = MappingProxyType({name: i for i, axis in enumerate(axes) for name in axis.ids})
    uncut = StreetNetwork(axes, crossings, (), blocks, extent, by_id)
    return replace(uncut, stretches=tuple(_stretches(uncut)))


def _stretches(network: StreetNetwork) -> list[Stretch]:
    corners: dict[tuple[int, int], list[tuple[float, int]]] = {}
    for k, crossing in enumerate(network.crossings):
        for street in crossing.streets if crossing.is_corner else ():
            at = _on_spine(network.streets[street], crossing)
            if at is not None:
                corners.setdefault((street, at[0]), []).append((at[1], k))
    found = []
    for street, axis in enumerate(network.streets):
        if not (axis.named or axis.bounds_blocks):
            continue
        for spine, line in enumerate(axis.spines):
            cuts = sorted(corners.get((street, spine), []))
            found += _cut(network, street, spine, line, cuts)
    return found


def _cut(
    network: StreetNetwork,
    street: int,
    spine: int,
    line: shapely.LineString,
    cuts: list[tuple[float, int]],
) -> list[Stretch]:
    """Return the parts of one spine between its corners, given as (metres, crossing)."""
    first, last = (shapely.get_point(line, i) for i in (0, -1))
    open_at = {
        0.0: network._end_kind(street, first) == "border",
        line.length: network._end_kind(street, last) == "border",
    }
    places: list[tuple[float, int | None]] = [(0.0, None), *cuts, (line.length, None)]
    found = []
    for (start, one), (end, other) in pairwise(places):
        if end - start < _LEAST_STRETCH_M:
            continue
        part = substring(line, start, end)
        found.append(
            Stretch(
                street, spine, start, end, part, one, other,
                start_open=one is None and open_at.get(start, False),
                end_open=other is None and open_at.get(end, False),
            )
        )  # fmt: skip
    return found


def _on_spine(axis: StreetAxis, crossing: Crossing) -> tuple[int, float] | None:
    """Return which spine of a street a crossing lies on, and where, in metres along it."""
    point = shapely.Point(crossing.point_m)
    gaps = [float(shapely.distance(point, spine)) for spine in axis.spines]
    if not gaps or min(gaps) > BESIDE_M:
        return None
    spine = gaps.index(min(gaps))
    return spine, float(shapely.line_locate_point(axis.spines[spine], point))
