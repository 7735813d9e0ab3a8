"""Numbers, regions and places that sum up a belief over cells."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.maps import Grid

__all__ = [
    "Place",
    "circular_summary",
    "entropy_nats",
    "expected_distance_m",
    "expected_m",
    "hpd_cells",
    "hpd_places",
    "mode_m",
    "probability_in",
]

Belief = NDArray[np.float64]


@dataclass(frozen=True)
class Place:
    """A connected part of an HPD region.

    Parameters
    ----------
    p
        Probability of the part.
    cells
        How many cells it has.
    mode_m
        Its most probable cell's centre, metres.
    """

    p: float
    cells: int
    mode_m: tuple[float, float]


def entropy_nats(belief: Belief) -> float:
    """Return the entropy of a belief in nats; 0 log 0 counts as 0.

    Examples
    --------
    >>> import numpy as np
    >>> round(entropy_nats(np.full((41, 41), 1 / 1681)), 2)
    7.43
    """
    positive = belief[belief > 0]
    return float(abs((positive * np.log(positive)).sum()))  # abs: no -0.0 where it is certain


def mode_m(belief: Belief, grid: Grid) -> tuple[float, float]:
    """Return x and y of the most probable cell's centre; the mean of the cells that tie for it.

    Beliefs within one part in a billion of the greatest tie; of tied cells the one nearest to
    their mean is taken, so that a plateau is answered by its middle.
    """
    rows, cols = np.nonzero(belief >= belief.max() * (1 - 1e-9))
    x, y = grid.x_m[cols], grid.y_m[rows]
    middle = np.argmin((x - x.mean()) ** 2 + (y - y.mean()) ** 2)
    return float(x[middle]), float(y[middle])


def expected_m(belief: Belief, grid: Grid) -> tuple[float, float]:
    """Return the mean x and y under a belief, metres."""
    return float(belief.sum(0) @ grid.x_m), float(belief.sum(1) @ grid.y_m)


def expected_distance_m(belief: Belief, grid: Grid, place_m: tuple[float, float]) -> float:
    """Return the mean distance under a belief from a place (x, y) to the cells, metres."""
    x, y = place_m
    if not (np.isfinite(x) and np.isfinite(y)):
        raise InputError(f"A place is {place_m}; expected finite x and y in metres")
    apart = np.hypot(grid.x_m[None, :] - x, grid.y_m[:, None] - y)
    return float((belief * apart).sum())


def hpd_cells(belief: Belief, mass: float) -> NDArray[np.bool_]:
    """Return the smallest set of cells that holds at least `mass`, ties broken by cell order.

    Examples
    --------
    >>> import numpy as np
    >>> hpd_cells(np.array([[0.5, 0.3], [0.15, 0.05]]), 0.8)
    array([[ True,  True],
           [False, False]])
    """
    flat = belief.reshape(-1)
    order = np.argsort(-flat, kind="stable")
    # Rounding of a running sum must not ask for one cell more: .9 of ten equal cells is nine.
    needed = int(np.searchsorted(np.cumsum(flat[order]), mass - 1e-12)) + 1
    inside = np.zeros(flat.size, dtype=bool)
    inside[order[:needed]] = True
    return inside.reshape(belief.shape)


def probability_in(belief: Belief, grid: Grid, polygon: Any) -> float:
    """Return the probability that the target is inside a polygon.

    Parameters
    ----------
    belief
        Probability of each cell, shape (H, W).
    grid
        The cells.
    polygon
        Shapely Polygon or MultiPolygon in metres from the map's centre.

    Returns
    -------
    float
        A cell that is partly inside counts by the share of its area that is.

    Raises
    ------
    InputError
        When it is no polygon, is empty, or crosses itself.
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


def hpd_places(belief: Belief, grid: Grid, mass: float = 0.9) -> tuple[Place, ...]:
    """Return the connected parts of an HPD region, most probable first.

    Cells that touch by a side or a corner are connected.
    """
    from scipy import ndimage

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


def circular_summary(
    weights: NDArray[np.float64], angles_rad: NDArray[np.float64]
) -> tuple[float, float]:
    """Return circular mean (radians) and von Mises concentration of weighted angles.

    The concentration is the moment estimate of Fisher (1993, sec. 4.5.5), within a few per cent
    of the maximum likelihood one.
    """
    c, s = float(weights @ np.cos(angles_rad)), float(weights @ np.sin(angles_rad))
    length = min(float(np.hypot(c, s)) / float(weights.sum()), 1 - 1e-9)
    if length < 0.53:
        kappa = 2 * length + length**3 + 5 * length**5 / 6
    elif length < 0.85:
        kappa = -0.4 + 1.39 * length + 0.43 / (1 - length)
    else:
        kappa = 1 / (length**3 - 4 * length**2 + 3 * length)
    return float(np.arctan2(s, c)), kappa
