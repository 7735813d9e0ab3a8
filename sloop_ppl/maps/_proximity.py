"""Find the geometry nearest to a point, quickly among thousands."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

__all__ = ["NearestIndex"]


class NearestIndex:
    """A spatial index over geometries (metres), called by their position in the sequence."""

    def __init__(self, geometries: Sequence[BaseGeometry]) -> None:
        self.geometries = np.array(geometries, dtype=object)
        self._tree = shapely.STRtree(self.geometries)

    def __len__(self) -> int:
        return len(self.geometries)

    def nearest(self, to: BaseGeometry) -> tuple[int, float] | None:
        """Return the nearest geometry and its distance in metres, the first of equals."""
        if not len(self):
            return None
        found, distance = self._tree.query_nearest(to, return_distance=True)
        return int(found.min()), float(distance[0])

    def within(self, to: BaseGeometry, reach_m: float) -> list[tuple[int, float]]:
        """Return the geometries within `reach_m` metres, nearest first, with their distances."""
        found = np.sort(self._tree.query(to, predicate="dwithin", distance=reach_m))
        distances = shapely.distance(self.geometries[found], to)
        order = np.argsort(distances, kind="stable")
        return [(int(found[i]), float(distances[i])) for i in order]

    def containing(self, geometry: BaseGeometry) -> NDArray[np.intp]:
        """Return the positions of the areas that contain a geometry, in order."""
        return np.sort(self._tree.query(geometry, predicate="within"))

    def touching(self, geometry: BaseGeometry) -> NDArray[np.intp]:
        """Return the positions of the geometries that meet a geometry, in order."""
        return np.sort(self._tree.query(geometry, predicate="intersects"))
