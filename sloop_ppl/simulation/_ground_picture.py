"""The ground of the city as one picture: streets, parks, parking and water, without height."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps import CityMap

if TYPE_CHECKING:
    from PIL.ImageDraw import ImageDraw

__all__ = ["ground_picture"]

_GROUND = (138, 132, 118)
# Muted, so that the saturated colours of targets stand out. Later kinds lie on earlier ones.
_LAYERS = {
    "park": (112, 122, 92),
    "water": (84, 104, 122),
    "square": (150, 143, 132),
    "parking": (116, 116, 118),
    "pedestrian": (158, 150, 138),
    "service": (100, 100, 102),
    "street": (82, 82, 85),
}
_PATHS = ("pedestrian", "service", "street")
_LINE = (196, 192, 180)
_PAVEMENT = (152, 148, 140)

# Map files have the widths of drawings; a lane takes 3 m.
_LEAST_WIDTH_M = {"street": 7.0, "service": 3.5, "pedestrian": 2.5}
_PAVEMENT_M = 1.8
_MOST_PIXELS = 2048
_PIXEL_M = 0.1


def ground_picture(city: CityMap, margin_m: float) -> NDArray[np.uint8]:
    """Return the ground seen from above, north up, shape (rows, columns, 3).

    Parameters
    ----------
    city
        The map.
    margin_m
        How far the picture reaches beyond the map's extent, metres, >= 0.

    Notes
    -----
    One picture on one plane instead of thin layers over each other: those flicker from far away,
    where the depth buffer cannot tell them apart.
    """
    from PIL import Image, ImageDraw

    west, south, east, north = city.grid.extent_m
    west, south, east, north = west - margin_m, south - margin_m, east + margin_m, north + margin_m
    scale = min(1.0 / _PIXEL_M, _MOST_PIXELS / max(east - west, north - south))
    size = round((east - west) * scale), round((north - south) * scale)
    image = Image.new("RGB", size, _GROUND)
    draw = ImageDraw.Draw(image)

    def paint(shape: BaseGeometry, colour: tuple[int, int, int]) -> None:
        _paint(draw, shape, colour, west, north, scale)

    paths = {kind: _paths(city, kind) for kind in _PATHS}
    for kind, colour in _LAYERS.items():
        if kind == "pedestrian":  # pavements lie under all that is driven or walked on
            paint(paths["street"].buffer(_PAVEMENT_M), _PAVEMENT)
        for landmark in city.of_kind(kind):
            if landmark.geometry.geom_type in ("Polygon", "MultiPolygon"):
                paint(landmark.geometry, colour)
        if kind in paths:
            paint(paths[kind], colour)
    _mark_lanes(draw, city, west, north, scale)
    grain = np.random.default_rng(0).normal(0.0, 3.0, (*np.asarray(image).shape[:2], 1))
    pixels: NDArray[np.uint8] = np.clip(np.asarray(image) + grain, 0, 255).astype(np.uint8)
    return pixels


def _paths(city: CityMap, kind: str) -> BaseGeometry:
    """Return what the lines of a kind cover."""
    lines = [m for m in city.of_kind(kind) if "LineString" in m.geometry.geom_type]
    widths = [max(m.width_m or 0.0, _LEAST_WIDTH_M[kind]) for m in lines]
    covers = [m.geometry.buffer(w / 2) for m, w in zip(lines, widths, strict=True)]
    return shapely.union_all(covers)


def _paint(
    draw: ImageDraw,
    shape: BaseGeometry,
    colour: tuple[int, int, int],
    west: float,
    north: float,
    scale: float,
) -> None:
    # Holes are no holes in a drawn polygon: the triangles of the shape are.
    for part in shapely.get_parts(shape):
        if part.geom_type != "Polygon" or part.is_empty:
            continue
        plain = [part]
        if part.interiors:
            plain = list(shapely.get_parts(shapely.constrained_delaunay_triangles(part)))
        for polygon in plain:
            xy = shapely.get_coordinates(polygon.exterior)
            draw.polygon([((x - west) * scale, (north - y) * scale) for x, y in xy], fill=colour)


def _mark_lanes(draw: ImageDraw, city: CityMap, west: float, north: float, scale: float) -> None:
    """Paint the broken line in the middle of streets."""
    for street in city.of_kind("street"):
        for line in shapely.get_parts(street.geometry):
            if line.geom_type != "LineString":
                continue
            for at in np.arange(0.0, line.length, 6.0):  # 3 m of line, 3 m of gap
                dash = shapely.get_coordinates(line.interpolate([at, min(at + 3.0, line.length)]))
                draw.line(
                    [((x - west) * scale, (north - y) * scale) for x, y in dash],
                    fill=_LINE, width=max(1, round(0.2 * scale)),
                )  # fmt: skip
