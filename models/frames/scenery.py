"""Keep what of a map is drawn around a landmark, ready to be looked up and drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from sloop_ppl.maps import CityMap, Landmark
from sloop_ppl.maps.landmark import PATH_KINDS
from sloop_ppl.models.frames.shapes import Shapes, laid_out

__all__ = ["LEAST_WIDTH_M", "PLANES", "Scenery", "scenery"]

PLANES = ("ground", "streets", "paths", "buildings")
"""The planes of a picture: the landmark itself, named streets, other ways, other buildings."""

LEAST_WIDTH_M = 4.0
"""No line is drawn narrower."""


@dataclass(frozen=True, eq=False)
class Scenery:
    """The buildings and ways of a map, in its order.

    Parameters
    ----------
    shapes : their points; G geometries.
    plane : number in `PLANES` of the plane that each is drawn on, shape (G,).
    width_m : how wide each is drawn where it is a line, metres, shape (G,).
    tree : an index of them.
    number : the place of each in this list, by its id.
    """

    shapes: Shapes
    plane: NDArray[np.intp]
    width_m: NDArray[np.float64]
    tree: shapely.STRtree
    number: dict[str | None, int]

    def reaching_into(
        self, areas: NDArray[np.object_], around: Sequence[Landmark]
    ) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return pairs of an area and what meets it, sorted, both as numbers.

        What an area is around is left out, and the building that it stands in.
        """
        pairs = self.tree.query(areas, predicate="intersects")
        area, found = np.divmod(np.sort(pairs[0] * len(self.plane) + pairs[1]), len(self.plane))
        own = np.array([self.number.get(one.id, -1) for one in around])
        holder = np.array([self.number.get(one.within, -1) for one in around])
        other = (found != own[area]) & (found != holder[area])
        return area[other], found[other]


def scenery(city: CityMap) -> Scenery:
    """Return what of a map is drawn; it is found once a map."""
    return city.derived("frame scenery", lambda: _scenery(city))


def _scenery(city: CityMap) -> Scenery:
    some = [(landmark, _plane(landmark)) for landmark in city.landmarks]
    kept = [(landmark, plane) for landmark, plane in some if plane is not None]
    geometry = np.array([landmark.geometry for landmark, _ in kept], dtype=object)
    return Scenery(
        laid_out(geometry),
        np.array([plane for _, plane in kept], dtype=np.intp),
        np.array([max(landmark.width_m or 0.0, LEAST_WIDTH_M) for landmark, _ in kept]),
        shapely.STRtree(geometry),
        {landmark.id: i for i, (landmark, _) in enumerate(kept)},
    )


def _plane(landmark: Landmark) -> int | None:
    """Return the number of the plane a landmark is drawn on."""
    if landmark.kind == "building":
        return PLANES.index("buildings")
    if landmark.kind not in PATH_KINDS:
        return None
    named = landmark.name is not None and landmark.kind != "pedestrian"
    return PLANES.index("streets" if named or landmark.kind == "street" else "paths")
