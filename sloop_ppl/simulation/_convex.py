"""Cut footprints into convex pieces, because a mesh of MuJoCo collides as its convex hull."""

from __future__ import annotations

import math

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

__all__ = ["convex_pieces"]

_LEAST_M2 = 1e-3
"""Area below which a piece is left out: slivers have no volume for a mesh."""

_SLACK = 1e-6


def convex_pieces(footprint: BaseGeometry) -> list[NDArray[np.float64]]:
    """Return convex polygons that together make up a footprint.

    Parameters
    ----------
    footprint
        One or several polygons, holes allowed; other geometry has no pieces.

    Returns
    -------
    list of numpy.ndarray
        The corners of each piece, anticlockwise, metres, shape (K, 2), K >= 3. They do not overlap.

    Notes
    -----
    A constrained Delaunay triangulation whose triangles are merged across shared edges as long as
    the union is convex (Hertel and Mehlhorn 1983: at most four times as many pieces as needed).

    Examples
    --------
    >>> import shapely
    >>> corner = shapely.box(0, 0, 2, 2) - shapely.box(1, 1, 2, 2)
    >>> len(convex_pieces(corner))
    2
    """
    pieces: list[NDArray[np.float64]] = []
    for part in shapely.get_parts(shapely.make_valid(footprint)):
        for polygon in shapely.get_parts(part):
            if polygon.geom_type == "Polygon" and polygon.area > _LEAST_M2:
                pieces += _pieces_of(polygon)
    return pieces


def _pieces_of(polygon: shapely.Polygon) -> list[NDArray[np.float64]]:
    plain = shapely.orient_polygons(polygon.simplify(0.0))
    if not plain.interiors:
        ring = shapely.get_coordinates(plain.exterior)[:-1]
        if _is_convex(ring):
            return [ring]
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(plain))
    rings = {
        i: [tuple(p) for p in shapely.get_coordinates(shapely.orient_polygons(t).exterior)[:-1]]
        for i, t in enumerate(triangles)
    }
    merged = True
    while merged:
        merged = False
        owner: dict[tuple[tuple[float, ...], tuple[float, ...]], int] = {}
        for i, ring in rings.items():
            for edge in _edges(ring):
                owner[edge] = i
        gone: set[int] = set()
        for (a, b), i in list(owner.items()):
            j = owner.get((b, a))
            if j is None or i == j or i in gone or j in gone:
                continue
            union = _joined(rings[i], rings[j], a, b)
            if union is not None and _is_convex(np.array(union)):
                rings[i] = union
                del rings[j]
                # The edges of both are out of date until the next round.
                gone |= {i, j}
                merged = True
    return [np.array(ring) for ring in rings.values() if shapely.Polygon(ring).area > _LEAST_M2]


def _edges(ring: list[tuple[float, ...]]) -> list[tuple[tuple[float, ...], tuple[float, ...]]]:
    return [(ring[k - 1], ring[k]) for k in range(len(ring))]


def _joined(
    first: list[tuple[float, ...]],
    second: list[tuple[float, ...]],
    a: tuple[float, ...],
    b: tuple[float, ...],
) -> list[tuple[float, ...]] | None:
    """Return the ring around two rings that share the edge from a to b; None if more than that."""
    # Started behind the edge: b ... a of the first, then a ... b of the second without its ends.
    at = first.index(b)
    one = first[at:] + first[:at]
    at = second.index(a)
    two = second[at:] + second[:at]
    if one[-1] != a or two[-1] != b:
        return None
    ring = one + two[1:-1]
    return ring if len(set(ring)) == len(ring) else None


def _is_convex(ring: NDArray[np.float64]) -> bool:
    """Tell whether an anticlockwise ring nowhere turns right."""
    if len(ring) < 4:
        return True
    edge = np.roll(ring, -1, axis=0) - ring
    after = np.roll(edge, -1, axis=0)
    cross = edge[:, 0] * after[:, 1] - edge[:, 1] * after[:, 0]
    scale = np.hypot(*edge.T) * np.hypot(*after.T)
    along = (edge * after).sum(axis=1)
    # An edge that turns back on the one before it is no corner.
    if not bool(((cross > 0) | (along > 0)).all()):
        return False
    if not bool((cross >= -_SLACK * np.maximum(scale, _SLACK)).all()):
        return False
    # One turn in all, else a ring that winds twice would pass.
    turns = np.arctan2(cross, along).sum()
    return bool(abs(turns - 2 * math.pi) < 1e-3)
