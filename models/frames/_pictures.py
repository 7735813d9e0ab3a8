"""Draw what surrounds a landmark as a small picture, as a network looks at it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap, Landmark
from sloop_ppl.maps.landmark import PATH_KINDS
from sloop_ppl.models.frames._strokes import SHARPER, Shapes, Strokes, drawn, laid_out, spans
from sloop_ppl.registry import Registry

__all__ = [
    "GREYS",
    "PIXELS",
    "PLANES",
    "VIEWS",
    "View",
    "context_image",
    "context_planes",
    "pictures_of",
]

PIXELS = 28
"""Pixels a side. Source: SLOOP sec. IV-C."""

GREYS = {"ground": 1.0, "streets": 0.7, "buildings": 0.35, "background": 0.0}
"""The four grey levels of the paper's picture; all ways are streets there."""

PLANES = ("ground", "streets", "paths", "buildings")
"""The planes of a picture: the landmark itself, named streets, other ways, other buildings."""

_LEAST_WIDTH_M = 4.0
"""No line is drawn narrower."""

_DRAWN = PIXELS * SHARPER


@dataclass(frozen=True)
class View:
    """How a picture is cut out of the map.

    Parameters
    ----------
    centred
        True to put the landmark in the middle (egocentric); False for the tile of the map that it
        lies in, tiles laid from the north-west corner.
    context
        True to draw what else is there; False for the landmark alone.
    side_m
        Side of the picture, metres; a centred one grows with the landmark.
    """

    centred: bool
    context: bool
    side_m: float


VIEWS: Registry[View] = Registry("view")
"""The paper's three pictures by name."""
VIEWS.add("ego-ctx", View(centred=True, context=True, side_m=112.0))
VIEWS.add("ctx", View(centred=False, context=True, side_m=200.0))
VIEWS.add("ego", View(centred=True, context=False, side_m=112.0))


def context_image(city: CityMap, landmark_id: str, view: str = "ego-ctx") -> NDArray[np.float32]:
    """Return the paper's picture of a landmark in four grey levels.

    Parameters
    ----------
    city
        The map.
    landmark_id
        Id of the landmark.
    view
        ``"ego-ctx"``, ``"ego"`` (without context) or ``"ctx"`` (not centred).

    Returns
    -------
    numpy.ndarray
        Greys of `GREYS`, shape (28, 28), row 0 in the south.

    Raises
    ------
    UnknownName
        For another view, or a landmark that is not on the map.

    Notes
    -----
    Source: SLOOP sec. IV-C, 28 x 28 pixels: ground, streets, buildings, background.
    """
    ground, streets, paths, buildings = context_planes(city, landmark_id, view)
    image = np.full((PIXELS, PIXELS), GREYS["background"], dtype=np.float32)
    image[buildings >= 0.5] = GREYS["buildings"]
    image[np.maximum(streets, paths) >= 0.5] = GREYS["streets"]
    image[ground >= min(0.5, float(ground.max())) - 1e-6] = GREYS["ground"]
    return image


def context_planes(
    city: CityMap,
    landmark_id: str,
    view: str = "ego-ctx",
    *,
    turn_rad: float = 0.0,
    shift_m: tuple[float, float] = (0.0, 0.0),
) -> NDArray[np.float32]:
    """Return how much of each pixel the landmark, streets, paths and buildings cover.

    Parameters
    ----------
    city
        The map.
    landmark_id
        Id of the landmark.
    view
        One of `VIEWS`.
    turn_rad
        The scene is turned by this angle about the picture's middle, anticlockwise.
    shift_m
        x and y by which the picture's middle is off, metres.

    Returns
    -------
    numpy.ndarray
        Shares from 0 to 1, shape (4, 28, 28), planes as in `PLANES`, row 0 in the south.

    Raises
    ------
    UnknownName
        For another view, or a landmark that is not on the map.
    """
    planes: NDArray[np.float32] = pictures_of(
        city, [landmark_id], view, turns_rad=[turn_rad], shifts_m=[shift_m]
    )[0]
    return planes


def pictures_of(
    city: CityMap,
    landmark_ids: Sequence[str],
    view: str = "ego-ctx",
    *,
    turns_rad: ArrayLike = 0.0,
    shifts_m: ArrayLike = (0.0, 0.0),
) -> NDArray[np.float32]:
    """Return the planes of :func:`context_planes` for N landmarks.

    Parameters
    ----------
    city
        The map.
    landmark_ids
        Ids of the landmarks; one may come several times.
    view
        One of `VIEWS`.
    turns_rad
        The angle each scene is turned by, shape (N,), or one for all.
    shifts_m
        x and y by which each picture's middle is off, metres, shape (N, 2), or one for all.

    Returns
    -------
    numpy.ndarray
        Shares from 0 to 1, shape (N, 4, 28, 28), planes as in `PLANES`, row 0 in the south.

    Raises
    ------
    InputError
        When turns or shifts have another shape.
    UnknownName
        For another view, or a landmark that is not on the map.
    """
    chosen = VIEWS[view]
    landmarks = [city.landmark(i) for i in landmark_ids]
    own = np.array([city.footprint(i) for i in landmark_ids], dtype=object)
    turn, shift = _for_each(len(landmarks), turns_rad, shifts_m)
    middle, side = _windows(city, own, chosen)
    middle = middle + shift
    scale = _DRAWN / side
    frame = _Frame(middle.view(np.complex128)[:, 0], scale * (np.cos(turn) + 1j * np.sin(turn)))
    each = np.arange(len(landmarks))
    width = np.rint(_LEAST_WIDTH_M * scale).astype(int)
    layers = [frame.strokes(laid_out(own), each, each, np.zeros_like(each), width)]
    if chosen.context:
        half = (side / 2 * np.where(turn % (math.pi / 2), math.sqrt(2), 1.0))[:, None]
        known = city.derived("frame scenery", lambda: _scenery(city))
        boxes = shapely.box(*(middle - half).T, *(middle + half).T)
        picture, found = known.reaching_into(boxes, landmarks)
        width = np.rint(known.width_m[found] * scale[picture]).astype(int)
        layers.append(frame.strokes(known.shapes, found, picture, known.plane[found], width))
    return drawn(layers, len(PLANES), PIXELS)


def _for_each(
    count: int, turns_rad: ArrayLike, shifts_m: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the turn and the shift of each of so many pictures."""
    turns, shifts = np.asarray(turns_rad, dtype=float), np.asarray(shifts_m, dtype=float)
    if turns.shape not in ((), (count,)) or shifts.shape not in ((2,), (count, 2)):
        raise InputError(
            f"turns_rad has shape {turns.shape} and shifts_m {shifts.shape}; expected one for all, "
            f"() and (2,), or one for each landmark, ({count},) and ({count}, 2)"
        )
    return np.broadcast_to(turns, (count,)), np.broadcast_to(shifts, (count, 2))


def _windows(
    city: CityMap, own: NDArray[np.object_], view: View
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the middle of each picture, shape (N, 2), and its side, shape (N,), metres."""
    centre = shapely.get_coordinates(shapely.centroid(own))
    if view.centred:
        west, south, east, north = shapely.bounds(own).T
        return centre, np.maximum(view.side_m, 1.6 * np.maximum(east - west, north - south))
    grid, side = city.grid, view.side_m
    tile = np.floor((centre - (grid.west_m, grid.north_m)) / side * (1, -1))
    corner = (grid.west_m, grid.north_m) + tile * (side, -side)
    return corner + np.array([side, -side]) / 2, np.full(len(own), side)


@dataclass(frozen=True, eq=False)
class _Frame:
    """Where N pictures lie: their middles, and scales times turns, as complex numbers."""

    middle: NDArray[np.complex128]
    factor: NDArray[np.complex128]

    def strokes(
        self,
        shapes: Shapes,
        which: NDArray[np.intp],
        picture: NDArray[np.intp],
        plane: NDArray[np.intp],
        width: NDArray[np.int_],
    ) -> Strokes:
        """Return the strokes of some geometries, each for one picture; pictures ascend."""
        runs, run = spans(shapes.run, which)
        points, point = spans(shapes.point, runs)
        owner = np.repeat(np.arange(len(which)), run[1:] - run[:-1])
        at = np.repeat(picture[owner], point[1:] - point[:-1])
        places = (shapes.points[points] - self.middle[at]) * self.factor[at]
        places += _DRAWN / 2 * (1 + 1j)
        return Strokes(
            run[np.searchsorted(picture, np.arange(len(self.middle) + 1))].tolist(),
            plane[owner].tolist(),
            shapes.kind[runs].tolist(),
            np.maximum(width, 1)[owner].tolist(),
            point.tolist(),
            places.view(np.float64).tolist(),
        )


@dataclass(frozen=True, eq=False)
class _Scenery:
    """The buildings and ways of a map, in its order.

    Parameters
    ----------
    shapes
        Their points; G geometries.
    plane
        Number in `PLANES` of the plane that each is drawn on, shape (G,).
    width_m
        How wide each is drawn where it is a line, metres, shape (G,).
    tree
        An index of them.
    number
        The place of each in this list, by its id.
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


def _scenery(city: CityMap) -> _Scenery:
    """Return what of a map is drawn."""
    some = [(landmark, _plane(landmark)) for landmark in city.landmarks]
    kept = [(landmark, plane) for landmark, plane in some if plane is not None]
    geometry = np.array([landmark.geometry for landmark, _ in kept], dtype=object)
    return _Scenery(
        laid_out(geometry),
        np.array([plane for _, plane in kept], dtype=np.intp),
        np.array([max(landmark.width_m or 0.0, _LEAST_WIDTH_M) for landmark, _ in kept]),
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
