"""How far each cell is from a landmark, and in which direction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from sloop_ppl.maps.grid import Grid

__all__ = ["LandmarkFields", "landmark_fields"]


@dataclass(frozen=True)
class LandmarkFields:
    """What a relation likelihood may know about a ground, cell by cell.

    Parameters
    ----------
    distance_m : metres from each cell to the nearest cell of the landmark, 0 on it, shape (H, W).
    bearing_rad : direction from the landmark's centroid to each cell, anticlockwise from east,
        in (-pi, pi], shape (H, W).
    from_centroid_m : metres from the centroid to each cell's centre, shape (H, W).
    nearest : row and column of the landmark's nearest cell, shape (2, H, W).
    extent_m : the longer side of the landmark's bounding box, metres.
    """

    distance_m: NDArray[np.float64]
    bearing_rad: NDArray[np.float64]
    from_centroid_m: NDArray[np.float64]
    nearest: NDArray[np.int32]
    extent_m: float


def landmark_fields(
    grid: Grid, cells: NDArray[np.bool_], centroid: tuple[float, float], extent_m: float
) -> LandmarkFields:
    """Compute the fields of a landmark from its cells and its centroid.

    Parameters
    ----------
    grid : the grid the cells lie on.
    cells : True on the landmark, at least once, shape (H, W).
    centroid : x and y of the landmark's centroid, metres.
    extent_m : the longer side of its bounding box, metres.
    """
    distance, nearest = distance_transform_edt(~cells, sampling=grid.cell_m, return_indices=True)
    east = grid.x_m[None, :] - centroid[0]
    north = grid.y_m[:, None] - centroid[1]
    return LandmarkFields(
        distance_m=distance,
        bearing_rad=np.arctan2(north, east),
        from_centroid_m=np.hypot(north, east),
        nearest=nearest,
        extent_m=extent_m,
    )
