"""Draw what surrounds a landmark as a small picture, as a network looks at it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from sloop_ppl.maps import CityMap, Landmark
from sloop_ppl.maps.landmark import PATH_KINDS
from sloop_ppl.registry import Registry

__all__ = ["GREYS", "PIXELS", "PLANES", "VIEWS", "View", "context_image", "context_planes"]

PIXELS = 28
"""Pixels a side. Source: SLOOP sec. IV-C."""

PLANES = ("ground", "streets", "paths", "buildings")
"""The planes of a picture: the landmark itself, named streets, other ways, other buildings."""

GREYS = {"ground": 1.0, "streets": 0.7, "buildings": 0.35, "background": 0.0}
"""The four grey levels of the paper's picture; all ways are streets there."""

_SHARPER = 2  # drawn so much finer, then averaged
_DRAWN = PIXELS * _SHARPER
_LEAST_WIDTH_M = 4.0


@dataclass(frozen=True)
class View:
    """How a picture is cut out of the map.

    Parameters
    ----------
    centred : True to put the landmark in the middle (egocentric); False for the tile of the map
        that it lies in, tiles laid from the north-west corner.
    context : True to draw what else is there; False for the landmark alone.
    side_m : side of the picture, metres; a centred one grows with the landmark.
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
    city : the map.
    landmark_id : id of the landmark.
    view : ``"ego-ctx"``, ``"ego"`` (without context) or ``"ctx"`` (not centred).

    Returns
    -------
    numpy.ndarray
        Greys of `GREYS`, shape (28, 28), row 0 in the south.

    Raises
    ------
    UnknownName : for another view, or a landmark that is not on the map.

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
    city : the map.
    landmark_id : id of the landmark.
    view : one of `VIEWS`.
    turn_rad : the scene is turned by this angle about the picture's middle, anticlockwise.
    shift_m : x and y by which the picture's middle is off, metres.

    Returns
    -------
    numpy.ndarray
        Shares from 0 to 1, shape (4, 28, 28), planes as in `PLANES`, row 0 in the south.

    Raises
    ------
    UnknownName : for another view, or a landmark that is not on the map.
    """
    chosen = VIEWS[view]
    landmark = city.landmark(landmark_id)
    own = city.footprint(landmark_id)
    middle, side = _window(city, own, chosen)
    middle = middle + np.asarray(shift_m)
    canvas = _Canvas(middle, side, turn_rad)
    canvas.draw(0, own, _LEAST_WIDTH_M)
    if chosen.context:
        half = side / 2 * (math.sqrt(2) if turn_rad % (math.pi / 2) else 1.0)
        box = shapely.box(*(middle - half), *(middle + half))
        for i in city.reaching_into(box):
            other = city.landmarks[i]
            plane = _plane(other)
            if plane is None or other.id in (landmark.id, landmark.within):
                continue
            canvas.draw(plane, other.geometry, max(other.width_m or 0.0, _LEAST_WIDTH_M))
    return canvas.shares()


def _window(city: CityMap, own: Any, view: View) -> tuple[NDArray[np.float64], float]:
    """Return the middle of the picture and its side, metres."""
    west, south, east, north = own.bounds
    centre = np.array([own.centroid.x, own.centroid.y])
    if view.centred:
        return centre, max(view.side_m, 1.6 * max(east - west, north - south))
    grid, side = city.grid, view.side_m
    col = math.floor((centre[0] - grid.west_m) / side)
    row = math.floor((grid.north_m - centre[1]) / side)
    corner = np.array([grid.west_m + col * side, grid.north_m - row * side])
    return corner + np.array([side, -side]) / 2, side


def _plane(landmark: Landmark) -> int | None:
    if landmark.kind == "building":
        return 3
    if landmark.kind not in PATH_KINDS:
        return None
    named = landmark.name is not None and landmark.kind != "pedestrian"
    return 1 if named or landmark.kind == "street" else 2


class _Canvas:
    """Planes one can draw shapely geometries on."""

    def __init__(self, middle: NDArray[np.float64], side_m: float, turn_rad: float) -> None:
        scale = _DRAWN / side_m
        cos, sin = math.cos(turn_rad) * scale, math.sin(turn_rad) * scale
        self._matrix = np.array([[cos, sin], [-sin, cos]])
        self._middle, self._scale = middle, scale
        self._planes = [Image.new("L", (_DRAWN, _DRAWN)) for _ in PLANES]
        self._pens = [ImageDraw.Draw(plane) for plane in self._planes]

    def draw(self, plane: int, geometry: Any, width_m: float) -> None:
        """Draw a geometry; a line is as wide as it is told, a point a pixel or two."""
        pen = self._pens[plane]
        kind = geometry.geom_type
        if kind == "Polygon":
            pen.polygon(self._pixels(geometry.exterior), fill=255)
            for hole in geometry.interiors:
                pen.polygon(self._pixels(hole), fill=0)
        elif kind == "LineString":
            pen.line(self._pixels(geometry), fill=255, width=max(1, round(width_m * self._scale)))
        elif kind == "Point":
            x, y = self._pixels(geometry)
            pen.rectangle((x - 1, y - 1, x, y), fill=255)
        else:
            for part in geometry.geoms:
                self.draw(plane, part, width_m)

    def _pixels(self, geometry: Any) -> list[float]:
        places = (shapely.get_coordinates(geometry) - self._middle) @ self._matrix + _DRAWN / 2
        flat: list[float] = places.ravel().tolist()
        return flat

    def shares(self) -> NDArray[np.float32]:
        """Return the planes, averaged to pixels, shape (4, 28, 28)."""
        fine = np.stack([np.asarray(plane) for plane in self._planes]).astype(np.float32)
        blocks = fine.reshape(len(PLANES), PIXELS, _SHARPER, PIXELS, _SHARPER)
        shares: NDArray[np.float32] = blocks.mean((2, 4)) / np.float32(255)
        return shares
