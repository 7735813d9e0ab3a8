"""How far each cell is from a landmark, and in which direction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.maps.grid import Grid

__all__ = ["LandmarkFields", "landmark_fields"]

BYTES_PER_CELL = 33
"""What a landmark's cells and fields take at most: a bool, three float64 and two int32."""


@dataclass(frozen=True, eq=False)
class LandmarkFields:
    """What a relation likelihood may know about a ground, cell by cell.

    Each field is computed when it is first asked for, and kept.

    Parameters
    ----------
    grid
        The grid the cells lie on.
    cells
        True on the landmark, at least once, shape (H, W).
    centroid
        x and y of the landmark's centroid, metres.
    extent_m
        The longer side of the landmark's bounding box, metres.
    touched
        Of a grid that is not even, the centres of the cells that the landmark takes, metres, shape
        (N, 2), and row and column of the entry that each is in, shape (2, N); else None.
    """

    grid: Grid
    cells: NDArray[np.bool_]
    centroid: tuple[float, float]
    extent_m: float
    touched: tuple[NDArray[np.float64], NDArray[np.int32]] | None = None

    @property
    def distance_m(self) -> NDArray[np.float64]:
        """Metres from each cell to the nearest cell of the landmark, 0 on it, shape (H, W)."""
        return self._transform[0]

    @property
    def nearest(self) -> NDArray[np.int32]:
        """Row and column of the landmark's nearest cell, shape (2, H, W)."""
        return self._transform[1]

    @cached_property
    def bearing_rad(self) -> NDArray[np.float64]:
        """Direction from the landmark's centroid to each cell, shape (H, W).

        Radians anticlockwise from east, in (-pi, pi].
        """
        return np.arctan2(self._north, self._east)

    @cached_property
    def from_centroid_m(self) -> NDArray[np.float64]:
        """Metres from the centroid to each cell's centre, shape (H, W)."""
        return np.hypot(self._north, self._east)

    @property
    def _east(self) -> NDArray[np.float64]:
        return self.grid.x_m[None, :] - self.centroid[0]

    @property
    def _north(self) -> NDArray[np.float64]:
        return self.grid.y_m[:, None] - self.centroid[1]

    @cached_property
    def _transform(self) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        if self.touched is not None:
            return self._nearest_of_touched(*self.touched)
        from scipy.ndimage import distance_transform_edt

        distance, nearest = distance_transform_edt(
            ~self.cells, sampling=self.grid.cell_m, return_indices=True
        )
        return distance, nearest

    def _nearest_of_touched(
        self, centres: NDArray[np.float64], entries: NDArray[np.int32]
    ) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        from scipy.spatial import KDTree

        x, y = np.meshgrid(self.grid.x_m, self.grid.y_m)
        distance, which = KDTree(centres).query(np.column_stack([x.ravel(), y.ravel()]))
        return distance.reshape(x.shape), entries[:, which].reshape(2, *x.shape)


def landmark_fields(
    grid: Grid, cells: NDArray[np.bool_], centroid: tuple[float, float], extent_m: float
) -> LandmarkFields:
    """Return the fields of a landmark; the arguments are those of `LandmarkFields`."""
    return LandmarkFields(grid, cells, centroid, extent_m)
