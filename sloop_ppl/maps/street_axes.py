"""The axis of each street: all lines of one name as one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps._spines import spines
from sloop_ppl.maps.frontage import street_key
from sloop_ppl.maps.landmark import PATH_KINDS, Landmark

__all__ = ["BESIDE_M", "StreetAxis", "street_axes"]

BESIDE_M = 30.0
"""How far apart the two carriageways of one road may be, metres."""

# Narrower is a line on a drawing: a lane and two kerbs.
_LEAST_WIDTH_M = 4.0
# A line that ends this near to the edge of another street's carriageway, or to the border of the
# map, ends on it.
_REACH_M = 4.0
# A road is divided where at least so much of it lies beside its spine.
_LEAST_BESIDE_M = 20.0
_OVERSHOOT_M = 0.01
_ROADS = ("street", "pedestrian", "service")
# Ways of kind pedestrian that lie beside or within a block rather than around it.
_FOOTWAYS = frozenset({"footway", "path", "steps", "cycleway", "bridleway", "corridor"})


@dataclass(frozen=True, eq=False)
class StreetAxis:
    """A street: all the lines that have its name.

    Parameters
    ----------
    ids
        Ids of its landmarks, in file order.
    label
        Its name, or the id of a nameless one.
    kind
        The most road-like kind among its lines: street, pedestrian or service.
    named
        Whether it has a name.
    bounds_blocks
        Whether blocks end at it: streets, nameless ones too, named service roads, and named
        pedestrian ways that are no mere footway.
    width_m
        Width of its widest carriageway, metres.
    lines
        Its lines, joined and prolonged to the streets they end on, metres.
    spines
        Lines without branches along which positions on it are counted, longest first; most
        streets have one. A divided road has one for both carriageways.
    """

    ids: tuple[str, ...]
    label: str
    kind: str
    named: bool
    bounds_blocks: bool
    width_m: float
    lines: BaseGeometry
    spines: tuple[shapely.LineString, ...]

    @cached_property
    def carriageway(self) -> BaseGeometry:
        """What it covers, the strip between two carriageways included."""
        surface = shapely.buffer(self.lines, self.width_m / 2, cap_style="flat")
        return shapely.union(surface, self.median)

    @cached_property
    def median(self) -> BaseGeometry:
        """What lies between its two carriageways; empty where it has but one."""
        along = sum(float(spine.length) for spine in self.spines)
        if self.lines.length < along + _LEAST_BESIDE_M:
            return shapely.Polygon()
        half = self.width_m / 2
        # Grown and shrunk again, a shape is closed where it was parted by less than twice that.
        grown = shapely.buffer(self.lines, half + BESIDE_M / 2, cap_style="flat")
        closed = shapely.buffer(grown, -BESIDE_M / 2)
        apart = shapely.difference(closed, shapely.buffer(self.lines, half))
        # The inner side of a bend is closed, too: it is thin.
        return shapely.buffer(shapely.buffer(apart, -1.0), 1.0)


def street_axes(
    paths: Sequence[Landmark], extent_m: tuple[float, float, float, float]
) -> tuple[StreetAxis, ...]:
    """Return the streets of a map, in the order in which their first lines come.

    Parameters
    ----------
    paths
        Landmarks of the kinds one travels along; those that are areas are left out.
    extent_m
        West, south, east and north border of the map, metres.
    """
    groups: dict[str, list[Landmark]] = {}
    for path in paths:
        if path.kind in PATH_KINDS and "LineString" in path.geometry.geom_type:
            # A nameless line is a street of its own; no name is folded to one with a space before.
            key = (street_key(path.name) if path.name else "") or f" {path.id}"
            groups.setdefault(key, []).append(path)
    axes = tuple(_axis(group) for group in groups.values())
    border = shapely.box(*extent_m).exterior
    return tuple(
        replace(axis, lines=lines, spines=spines(lines, BESIDE_M))
        for axis, lines in zip(axes, _prolonged(axes, border), strict=True)
    )


def _axis(group: Sequence[Landmark]) -> StreetAxis:
    first = group[0]
    lines = shapely.union_all([shapely.force_2d(m.geometry) for m in group])
    return StreetAxis(
        ids=tuple(m.id for m in group),
        label=first.label,
        kind=min((m.kind for m in group), key=_ROADS.index),
        named=first.name is not None,
        bounds_blocks=any(_bounds(m) for m in group),
        width_m=max(_LEAST_WIDTH_M, *(m.width_m or 0.0 for m in group)),
        lines=_merged(lines),
        spines=(),
    )


def _bounds(path: Landmark) -> bool:
    if path.kind == "street":
        return True
    return path.name is not None and path.properties.get("highway") not in _FOOTWAYS


def _merged(lines: BaseGeometry) -> BaseGeometry:
    return shapely.line_merge(lines) if lines.geom_type != "LineString" else lines


def _prolonged(axes: Sequence[StreetAxis], border: BaseGeometry) -> list[BaseGeometry]:
    """Return the lines of each street, with the last metres to where it ends on another."""
    targets = [axis for axis in axes if axis.bounds_blocks]
    shapes = [*(axis.lines for axis in targets), border]
    reach = [_REACH_M + axis.width_m / 2 for axis in targets] + [_REACH_M]
    tree = shapely.STRtree(shapes)
    made = []
    for axis in axes:
        added = []
        # Nobody speaks of the crossings of the others, and no block ends at them.
        for end in _ends(axis.lines) if axis.named or axis.bounds_blocks else ():
            found = np.sort(tree.query(end, predicate="dwithin", distance=max(reach)))
            near = [i for i in found if i == len(targets) or targets[i] is not axis]
            gaps = {i: float(shapely.distance(end, shapes[i])) for i in near}
            close = [i for i in near if gaps[i] <= reach[i]]
            # A line that crosses what it ends near runs past it already.
            last = shapely.intersection(axis.lines, shapely.buffer(end, 2 * max(reach)))
            if close and not any(shapely.intersects(shapes[i], last) for i in close):
                nearest = min(close, key=gaps.__getitem__)
                added.append(_onto(end, shapes[nearest]))
        made.append(_merged(shapely.union_all([axis.lines, *added])) if added else axis.lines)
    return made


def _onto(end: shapely.Point, other: BaseGeometry) -> shapely.LineString:
    """Return a line from the end of a street to just beyond the nearest place of another."""
    here, there = shapely.get_coordinates(shapely.shortest_line(end, other))
    # A line that ends on another but for rounding would neither cross it nor close a block.
    step = (there - here) / max(float(np.hypot(*(there - here))), 1e-12)
    return shapely.LineString([here, there + _OVERSHOOT_M * step])


def _ends(lines: BaseGeometry) -> list[shapely.Point]:
    """Return the points at which an odd number of a street's lines end: its loose ends."""
    boundary = shapely.boundary(lines)
    return list(shapely.get_parts(boundary))
