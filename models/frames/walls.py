"""Tell how a direction lies to the walls of a building."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from sloop_ppl.models.frames.shapes import spans

__all__ = ["Walls"]


@dataclass(frozen=True, eq=False)
class Walls:
    """The corners of N footprints, and the axis that the walls of each follow.

    Parameters
    ----------
    corners : x + iy of all corners in turn, metres, shape (P,).
    corner : first corner of each footprint, and their number, shape (N + 1,).
    axis_rad : the direction that most of its walls have, or are square to, shape (N,). The step
        from one ring or part to the next counts as a wall, as the shipped networks learnt it.
    walled : False for what has no walls, such as a point, shape (N,).
    """

    corners: NDArray[np.complex128]
    corner: NDArray[np.intp]
    axis_rad: NDArray[np.float64]
    walled: NDArray[np.bool_]

    @classmethod
    def of(cls, footprints: NDArray[np.object_]) -> Walls:
        """Return the walls of some footprints."""
        xy, owner = shapely.get_coordinates(footprints, return_index=True)
        corners, count = xy.view(np.complex128)[:, 0], len(footprints)
        same = owner[1:] == owner[:-1]
        wall, walls = (corners[1:] - corners[:-1])[same], owner[1:][same]
        long = np.abs(wall)
        turn = long * np.exp(4j * np.angle(wall))
        sums = (np.bincount(walls, one, count) for one in (long, turn.real, turn.imag))
        length, east, north = sums
        corner = np.searchsorted(owner, np.arange(count + 1))
        walled = (corner[1:] - corner[:-1] >= 3) & (length > 0)
        return cls(corners, corner, np.arctan2(north, east) / 4, walled)

    def seen_from(
        self, which: NDArray[np.intp], bearing_rad: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return how square a direction is to the walls, and how narrow the side it looks from.

        Parameters
        ----------
        which : the footprint that each direction is of, shape (C,).
        bearing_rad : the directions, shape (C,).

        Returns
        -------
        tuple of numpy.ndarray
            From -1 to 1, and the log of depth over width, shape (C,) each; 0 without walls.
        """
        corners, start = spans(self.corner, which)
        seen = self.corners[corners] * np.repeat(np.exp(-1j * bearing_rad), start[1:] - start[:-1])
        deep, wide = (_extent(one, start[:-1]) for one in (seen.real, seen.imag))
        square = np.cos(4 * (bearing_rad - self.axis_rad[which]))
        narrow = np.log(np.maximum(deep, 1) / np.maximum(wide, 1))
        walled = self.walled[which]
        return np.where(walled, square, 0.0), np.where(walled, narrow, 0.0)


def _extent(values: NDArray[np.float64], start: NDArray[np.intp]) -> NDArray[np.float64]:
    extent: NDArray[np.float64] = np.maximum.reduceat(values, start) - np.minimum.reduceat(
        values, start
    )
    return extent
