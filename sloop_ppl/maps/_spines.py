"""Find the one line along which positions on a street are counted."""

from __future__ import annotations

import math
from heapq import heappop, heappush

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

__all__ = ["spines"]

# Pieces of a street that point at one another across a gap up to this wide, such as a square or a
# crossing that the map leaves out, are one street.
_GAP_M = 60.0
# An end points at another when the way there turns by less than this.
_STRAIGHT = math.cos(math.pi / 4)
# What is left of a street beside its spine and is no spine of its own.
_LEAST_M = 20.0

_Edge = tuple[int, int, NDArray[np.float64]]


def spines(lines: BaseGeometry, beside_m: float) -> tuple[shapely.LineString, ...]:
    """Return the spines of a street: lines without branches that together run along all of it.

    Parameters
    ----------
    lines
        All lines of the street, metres.
    beside_m
        How far beside a spine a line is still counted along it, metres: the other carriageway of
        a divided road, a slip road.

    Returns
    -------
    tuple of LineString
        Longest first, each from west to east, or from south to north where it runs rather so.

    Notes
    -----
    A spine leads by the shortest way between the two nodes of the street that are farthest apart
    as the crow flies. The length of the way itself would choose the U-turn where the two
    carriageways of a road meet.
    """
    if lines.geom_type == "LineString" and shapely.is_simple(lines):
        return (_oriented(lines),) if lines.length >= 1e-6 else ()
    found: list[shapely.LineString] = []
    rest = lines
    while not rest.is_empty:
        spine = _spine(rest)
        if spine.length < (_LEAST_M if found else 1e-6):
            break
        found.append(_oriented(spine))
        left = shapely.difference(rest, spine.buffer(beside_m))
        parts = [p for p in shapely.get_parts(left) if p.length >= _LEAST_M]
        rest = shapely.union_all(parts)
    return tuple(sorted(found, key=lambda spine: -spine.length))


def _spine(lines: BaseGeometry) -> shapely.LineString:
    nodes, edges = _graph(lines)
    edges += _bridges(nodes, edges)
    component = _components(len(nodes), edges)
    gaps = np.hypot(*(nodes[:, None, :] - nodes[None, :, :]).transpose(2, 0, 1))
    gaps[component[:, None] != component[None, :]] = -1.0
    start, end = (int(i) for i in np.unravel_index(int(gaps.argmax()), gaps.shape))
    if start == end:  # nothing but rings
        longest = max(edges, key=lambda edge: float(shapely.LineString(edge[2]).length))
        return shapely.LineString(longest[2])
    return shapely.LineString(_shortest(len(nodes), edges, start, end))


def _graph(lines: BaseGeometry) -> tuple[NDArray[np.float64], list[_Edge]]:
    """Return the places where lines end or meet, shape (n, 2), and the lines between them."""
    merged = shapely.line_merge(shapely.union_all(shapely.get_parts(lines)))
    index: dict[tuple[float, float], int] = {}
    nodes: list[NDArray[np.float64]] = []
    edges = []
    for part in shapely.get_parts(merged):
        points = shapely.get_coordinates(part)
        ends = []
        for point in (points[0], points[-1]):
            # To a millimetre: what meets there was computed, and may miss by rounding.
            key = round(float(point[0]), 3), round(float(point[1]), 3)
            if key not in index:
                index[key] = len(nodes)
                nodes.append(point)
            ends.append(index[key])
        edges.append((ends[0], ends[1], points))
    return np.array(nodes), edges


def _bridges(nodes: NDArray[np.float64], edges: list[_Edge]) -> list[_Edge]:
    """Return straight lines over the gaps between ends that point at one another."""
    degree = np.bincount([i for edge in edges for i in edge[:2]], minlength=len(nodes))
    component = _components(len(nodes), edges)
    outward: dict[int, NDArray[np.float64]] = {}
    for start, end, points in edges:
        for node, tip, before in ((start, points[0], points[1]), (end, points[-1], points[-2])):
            if degree[node] == 1:
                outward[node] = (tip - before) / max(math.dist(tip, before), 1e-9)
    candidates = []
    ends = sorted(outward)
    for k, one in enumerate(ends):
        for other in ends[k + 1 :]:
            gap = nodes[other] - nodes[one]
            length = math.hypot(*gap)
            if component[one] == component[other] or not 0 < length <= _GAP_M:
                continue
            ahead, back = gap @ outward[one] / length, -gap @ outward[other] / length
            if min(ahead, back) > _STRAIGHT:
                candidates.append((length, one, other))
    bridges: list[_Edge] = []
    for _, one, other in sorted(candidates):
        if component[one] != component[other]:
            bridges.append((one, other, nodes[[one, other]]))
            component[component == component[other]] = component[one]
    return bridges


def _components(count: int, edges: list[_Edge]) -> NDArray[np.int64]:
    """Return a number for each node that those it is joined to have too."""
    component = np.arange(count)
    for start, end, _ in edges:
        component[component == component[end]] = component[start]
    return component


def _shortest(count: int, edges: list[_Edge], start: int, end: int) -> NDArray[np.float64]:
    """Return the points of the shortest way from one node to another (Dijkstra)."""
    ways: list[list[tuple[float, int, NDArray[np.float64]]]] = [[] for _ in range(count)]
    for one, other, points in edges:
        length = float(np.hypot(*np.diff(points, axis=0).T).sum())
        ways[one].append((length, other, points))
        ways[other].append((length, one, points[::-1]))
    came: dict[int, tuple[int, NDArray[np.float64]]] = {}
    best = {start: 0.0}
    queue = [(0.0, start)]
    while queue:
        far, node = heappop(queue)
        if node == end:
            break
        if far > best[node]:
            continue
        for length, other, points in ways[node]:
            if far + length < best.get(other, math.inf):
                best[other] = far + length
                came[other] = node, points
                heappush(queue, (far + length, other))
    pieces = []
    while end != start:
        end, points = came[end]
        pieces.append(points)
    joined = np.concatenate(pieces[::-1])
    return joined[np.r_[True, np.abs(np.diff(joined, axis=0)).max(axis=1) > 0]]


def _oriented(line: shapely.LineString) -> shapely.LineString:
    points = shapely.get_coordinates(line)
    east, north = points[-1] - points[0]
    backwards = east < 0 if abs(east) >= abs(north) else north < 0
    return shapely.LineString(points[::-1]) if backwards else line
