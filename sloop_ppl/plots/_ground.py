"""Draw what covers the ground: parks, water, parking, roads and buildings."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps import CityMap, Landmark
from sloop_ppl.plots._axes import stroke, width_in
from sloop_ppl.plots._palette import PAPER, MapPalette

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.path import Path

__all__ = [
    "areas_of",
    "draw_ground",
    "draw_shape",
    "road_surface",
    "road_width_m",
    "shape_path",
]

# Widths in the bundled maps are those of a drawing: real carriageways are wider.
_WIDEN = {"street": 1.35, "service": 1.3, "pedestrian": 1.0}
_AT_LEAST_M = {"street": 5.5, "service": 2.6, "pedestrian": 2.0}
_SIGN_PT = 5.5


def draw_ground(ax: Axes, city: CityMap, palette: MapPalette) -> None:
    """Draw every landmark of a map but its labels, clipped to the map's extent."""
    # Order of drawing (zorder): ground 0.1 to 0.56, buildings 0.7, signs and places 0.9, highlights
    # 1 to 3.2, belief 2 to 3.4, arrows and path 4, targets and finds 5, labels 6, furniture 7,
    # legend 8.
    window = shapely.box(*city.grid.extent_m)
    draw_shape(ax, window, 0.1, palette.ground)
    _areas(ax, city, palette, window)
    _roads(ax, city, palette, window)
    for shape in _polygons(city.of_kind("building"), window):
        face, edge = palette.building, palette.building_edge
        draw_shape(ax, shape, 0.7, face, edge, 0.6, joinstyle="round")
    _pois(ax, city, palette)
    _parking_signs(ax, city, palette, window)


def road_width_m(landmark: Landmark) -> float:
    """Return how wide a line is drawn, metres."""
    kind = landmark.kind if landmark.kind in _WIDEN else "pedestrian"
    return max((landmark.width_m or 0.0) * _WIDEN[kind], _AT_LEAST_M[kind])


def draw_shape(
    ax: Axes,
    geometry: BaseGeometry,
    zorder: float,
    face: str = "none",
    edge: str = "none",
    points: float = 0.0,
    **style: Any,
) -> None:
    """Add one polygon, line or several of them to an axes without touching its limits.

    The edge is so many points wide on an axes of usual width; see `stroke`.
    """
    from matplotlib.patches import PathPatch

    path = shape_path(geometry)
    if np.size(path.vertices):
        colours: dict[str, Any] = {
            "facecolor": face,
            "edgecolor": edge,
            "linewidth": points * stroke(ax),
        }
        ax.add_artist(PathPatch(path, zorder=zorder, **colours, **style))


def shape_path(geometry: BaseGeometry) -> Path:
    """Return the matplotlib path of a shapely geometry, holes included; points leave no trace."""
    from matplotlib.path import Path

    vertices: list[Any] = []
    codes: list[int] = []
    _trace(geometry, vertices, codes)
    return Path(np.reshape(np.asarray(vertices, dtype=float), (-1, 2)), codes)


def _trace(geometry: BaseGeometry, vertices: list[Any], codes: list[int]) -> None:
    """Append the vertices and path codes of a geometry and all its parts."""
    from matplotlib.path import Path

    move, line, close = int(Path.MOVETO), int(Path.LINETO), int(Path.CLOSEPOLY)
    if hasattr(geometry, "geoms"):
        for part in geometry.geoms:
            _trace(part, vertices, codes)
    elif geometry.geom_type == "Polygon":
        for ring in (geometry.exterior, *geometry.interiors):
            points = shapely.get_coordinates(ring)
            vertices.extend(points)
            # The last point of a ring repeats the first: its code closes the ring, so that holes
            # stay open.
            codes.extend([move, *[line] * (len(points) - 2), close])
    elif geometry.geom_type in ("LineString", "LinearRing"):
        points = shapely.get_coordinates(geometry)
        vertices.extend(points)
        codes.extend([move, *[line] * (len(points) - 1)][: len(points)])


def areas_of(geometry: BaseGeometry) -> BaseGeometry:
    """Return the polygons in a geometry, made valid; empty when there is none."""
    parts = shapely.get_parts(shapely.get_parts(shapely.make_valid(geometry)))
    return shapely.union_all([p for p in parts if p.geom_type == "Polygon"])


def _polygons(landmarks: Iterable[Landmark], window: BaseGeometry) -> list[BaseGeometry]:
    """Return the areas among the landmarks' geometries, clipped."""
    shapes = [areas_of(shapely.intersection(areas_of(m.geometry), window)) for m in landmarks]
    return [s for s in shapes if not s.is_empty]


def _areas(ax: Axes, city: CityMap, palette: MapPalette, window: BaseGeometry) -> None:
    fills = {
        "park": (palette.park, palette.park_edge),
        "water": (palette.water, palette.water_edge),
        "square": (palette.square, palette.road_edge),
        "pedestrian": (palette.square, palette.road_edge),
    }
    for shape in _polygons(city.of_kind("poi"), window):  # a campus, a marina, a market: grounds
        draw_shape(ax, shape, 0.2, palette.square)
    for kind, (face, edge) in fills.items():
        for shape in _polygons(city.of_kind(kind), window):
            draw_shape(ax, shape, 0.3, face, edge, 0.5)
    for shape in _polygons(city.of_kind("parking"), window):
        draw_shape(ax, shape, 0.35, palette.parking, palette.parking_edge, 0.5)
        draw_shape(ax, _hatch(shape), 0.4, edge=palette.parking_edge, points=0.35)
    for landmark in city.of_kind("park", "water"):
        if landmark.geometry.geom_type in ("LineString", "MultiLineString"):
            strip = landmark.geometry.buffer(max(landmark.width_m or 0.0, 2.0) / 2)
            draw_shape(ax, strip & window, 0.3, *fills[landmark.kind], 0.5)


def _hatch(shape: BaseGeometry, step_m: float = 4.0) -> BaseGeometry:
    """Return diagonal strokes over an area; laid in metres, so that they are the same anywhere."""
    west, south, east, north = shape.bounds
    rise = north - south
    # Multiples of the step from the origin: the strokes of neighbouring car parks line up.
    first = np.floor((west - rise) / step_m) * step_m
    starts = np.arange(first, east + step_m, step_m)
    low = np.stack([starts, np.full_like(starts, south)], axis=1)
    high = np.stack([starts + rise, np.full_like(starts, north)], axis=1)
    lines = shapely.linestrings(np.stack([low, high], axis=1))
    return shapely.intersection(shapely.multilinestrings(lines), shape)


def road_surface(city: CityMap) -> BaseGeometry:
    """Return everything that is drawn as drivable, not clipped to the map's extent."""
    ways = []
    for landmark in city.of_kind("street", "service"):
        if landmark.geometry.geom_type in ("LineString", "MultiLineString"):
            half = road_width_m(landmark) / 2
            ways += [_run_out(p, city).buffer(half) for p in shapely.get_parts(landmark.geometry)]
        else:
            ways.append(shapely.make_valid(landmark.geometry))
    return shapely.unary_union(ways)


def _run_out(line: BaseGeometry, city: CityMap, near_m: float = 2.0) -> BaseGeometry:
    """Prolong a way that ends at the border of the map, so that it leaves it squarely."""
    west, south, east, north = city.grid.extent_m
    rim = shapely.box(west, south, east, north).exterior
    points = shapely.get_coordinates(line)
    ends = []
    for end, before in ((points[0], points[1]), (points[-1], points[-2])):
        step = end - before
        length = float(np.hypot(*step))
        # 30 m is more than the half width of any road: the round end of its buffer lies off the
        # map.
        reach = 30.0 if rim.distance(shapely.Point(end)) < near_m and length > 0 else 0.0
        ends.append(end + step * (reach / length if length else 0.0))
    return shapely.linestrings(np.vstack([ends[0], points[1:-1], ends[1]]))


def _roads(ax: Axes, city: CityMap, palette: MapPalette, window: BaseGeometry) -> None:
    """Draw drivable ways as one surface with one rim, so that junctions are open."""
    # Union first, rim after: the outlines of single roads would cross every junction.
    surface = road_surface(city)
    if surface.is_empty:
        surface = shapely.Polygon()
    draw_shape(ax, surface & window, 0.5, palette.road)
    draw_shape(ax, shapely.boundary(surface) & window, 0.52, edge=palette.road_edge, points=0.9)
    for landmark in city.of_kind("pedestrian"):
        if landmark.geometry.geom_type not in ("LineString", "MultiLineString"):
            continue
        line = shapely.intersection(landmark.geometry, window)
        strip = shapely.intersection(line.buffer(road_width_m(landmark) / 2), window)
        draw_shape(ax, strip, 0.55, palette.square)
        dashes = (0, (3.0, 2.0))
        draw_shape(ax, line, 0.56, edge=palette.pedestrian, points=0.9, linestyle=dashes)


def _pois(ax: Axes, city: CityMap, palette: MapPalette) -> None:
    points = [m.geometry for m in city.of_kind("poi") if m.geometry.geom_type == "Point"]
    if points:
        ax.scatter(
            [p.x for p in points],
            [p.y for p in points],
            s=9 * stroke(ax) ** 2,
            color=palette.poi,
            edgecolor=PAPER,
            linewidth=0.5 * stroke(ax),
            zorder=0.9,
        )


def _parking_signs(ax: Axes, city: CityMap, palette: MapPalette, window: BaseGeometry) -> None:
    """Put a P on each car park that has room for one."""
    size = _SIGN_PT * stroke(ax)
    west, east = ax.get_xlim()
    # 0.6 of the font size in metres: what a letter with its box takes from the middle.
    least_m = 0.6 * size * (east - west) / (72 * width_in(ax))
    built = [shapely.make_valid(m.geometry) for m in city.of_kind("building")]
    taken = shapely.unary_union([road_surface(city), *built])
    for shape in _polygons(city.of_kind("parking"), window):
        free = areas_of(shapely.difference(shape, taken))
        if free.is_empty:
            continue
        # The largest circle in what is free: the roomiest place of the car park.
        centre, rim = shapely.get_coordinates(shapely.maximum_inscribed_circle(free, tolerance=0.5))
        if float(np.hypot(*(rim - centre))) < least_m:
            continue
        ax.annotate(
            "P",
            tuple(centre),
            ha="center",
            va="center",
            fontsize=size,
            fontweight="bold",
            color=PAPER,
            bbox={"boxstyle": "round,pad=0.25", "facecolor": palette.sign, "edgecolor": "none"},
            zorder=0.85,
            annotation_clip=True,
            gid="parking-sign",
        )
