"""How probable an area is, and which connected places hold most of a belief."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage

from sloop_ppl.errors import InputError
from sloop_ppl.inference.summaries import hpd_cells, mode_m
from sloop_ppl.maps import Grid

__all__ = ["Place", "hpd_places", "probability_in"]

Table = NDArray[np.float64]


@dataclass(frozen=True)
class Place:
    """A connected part of an HPD region.

    Parameters
    ----------
    p : probability of the part.
    cells : how many cells it has.
    mode_m : its most probable cell's centre, metres.
    """

    p: float
    cells: int
    mode_m: tuple[float, float]


def probability_in(belief: Table, grid: Grid, polygon: Any) -> float:
    """Return the probability that the target is inside a polygon.

    Parameters
    ----------
    belief : probability of each cell, shape (H, W).
    grid : the cells.
    polygon : shapely Polygon or MultiPolygon in metres from the map's centre.

    Returns
    -------
    float
        A cell that is partly inside counts by the share of its area that is.

    Raises
    ------
    InputError : when it is no polygon, is empty, or crosses itself.
    """
    kind = getattr(polygon, "geom_type", type(polygon).__name__)
    if kind not in ("Polygon", "MultiPolygon"):
        raise InputError(
            f"An area is a {kind}; expected a shapely Polygon or MultiPolygon in metres from the "
            "map's centre"
        )
    if polygon.is_empty:
        raise InputError("An area is empty; expected a polygon with an inside")
    if not polygon.is_valid:
        raise InputError(
            f"An area is not valid ({shapely.is_valid_reason(polygon)}); mend it with "
            "shapely.make_valid"
        )
    half = grid.cell_m / 2
    x, y = np.meshgrid(grid.x_m, grid.y_m)
    west, south, east, north = polygon.bounds
    held = belief > 0
    held &= (x + half > west) & (x - half < east) & (y + half > south) & (y - half < north)
    boxes = shapely.box(x[held] - half, y[held] - half, x[held] + half, y[held] + half)
    shapely.prepare(polygon)
    inside = shapely.contains_properly(polygon, boxes)
    share = np.ones(len(boxes))
    share[~inside] = shapely.area(shapely.intersection(boxes[~inside], polygon)) / grid.cell_m**2
    return min(float(belief[held] @ share), 1.0)


def hpd_places(belief: Table, grid: Grid, mass: float = 0.9) -> tuple[Place, ...]:
    """Return the connected parts of an HPD region, most probable first.

    Cells that touch by a side or a corner are connected.
    """
    labels, count = ndimage.label(hpd_cells(belief, mass), structure=np.ones((3, 3)))
    places = []
    for label in range(1, count + 1):
        own = labels == label
        places.append(
            Place(
                float(belief[own].sum()),
                int(own.sum()),
                mode_m(np.where(own, belief, 0.0), grid),
            )
        )
    return tuple(sorted(places, key=lambda place: -place.p))
