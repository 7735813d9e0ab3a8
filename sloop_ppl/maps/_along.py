"""Find, for many points at once, the nearest place on lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

__all__ = ["NearestOnLines", "nearest_on_lines"]


@dataclass(frozen=True, eq=False)
class NearestOnLines:
    """The place on some lines that is nearest to each of N points.

    Parameters
    ----------
    line
        Position of the nearest line, shape (N,).
    along_m
        Where on it, metres from its start, shape (N,).
    offset_m
        From there to the point, east and north, metres, shape (N, 2).
    on_left
        Whether the point lies to the left of the line's direction, shape (N,).
    """

    line: NDArray[np.intp]
    along_m: NDArray[np.float64]
    offset_m: NDArray[np.float64]
    on_left: NDArray[np.bool_]


def nearest_on_lines(
    lines: Sequence[shapely.LineString], points_m: NDArray[np.float64]
) -> NearestOnLines:
    """Return the nearest place on any of some lines for each point.

    Parameters
    ----------
    lines
        At least one line, metres.
    points_m
        x and y, metres, shape (N, 2).

    Notes
    -----
    A tree of the lines' segments finds the nearest in time that hardly grows with their number;
    measuring along whole lines would take time in proportion to their points.
    """
    pieces = [_segments(line) for line in lines]
    start, way, passed, before, after = (np.concatenate(part) for part in zip(*pieces, strict=True))
    owner = np.repeat(np.arange(len(lines)), [len(piece[0]) for piece in pieces])
    tree = shapely.STRtree(shapely.linestrings(np.stack([start, start + way], axis=1)))
    segment = tree.query_nearest(shapely.points(points_m), all_matches=False)[1]
    origin, step = start[segment], way[segment]
    length = np.maximum(np.hypot(*step.T), 1e-12)
    share = np.clip(((points_m - origin) * step).sum(axis=1) / length**2, 0.0, 1.0)
    offset = points_m - (origin + share[:, None] * step)
    # Where the nearest place is a bend, side goes by the bisector of the bend, whichever of its two
    # segments was found.
    ahead = np.where(share[:, None] <= 0, before[segment], step)
    ahead = np.where(share[:, None] >= 1, after[segment], ahead)
    return NearestOnLines(
        line=owner[segment],
        along_m=passed[segment] + share * length,
        offset_m=offset,
        on_left=ahead[:, 0] * offset[:, 1] - ahead[:, 1] * offset[:, 0] > 0,
    )


def _segments(line: shapely.LineString) -> tuple[NDArray[np.float64], ...]:
    """Return start, vector, metres before it, and direction at start and end of each segment."""
    points = shapely.get_coordinates(line)
    way = np.diff(points, axis=0)
    length = np.hypot(*way.T)
    unit = way / np.maximum(length, 1e-12)[:, None]
    bend = unit[:-1] + unit[1:]
    # At the ends of the line there is no bend.
    before, after = np.vstack([unit[:1], bend]), np.vstack([bend, unit[-1:]])
    return points[:-1], way, np.cumsum(length) - length, before, after
