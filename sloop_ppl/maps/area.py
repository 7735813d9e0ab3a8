"""The part of a map in which targets are searched for."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import shape as shape_of
from shapely.geometry.base import BaseGeometry

from sloop_ppl._foreign import ForeignFault, parse_json, read_text
from sloop_ppl.errors import InputError
from sloop_ppl.maps._given_point import are_degrees_of
from sloop_ppl.maps._shapes import parts_of_dimension, project
from sloop_ppl.maps.grid import Grid

__all__ = ["SearchArea", "search_area"]

_WANTED = (
    "expected W,S,E,N in metres, @W,S,E,N in degrees, a polygon, or GeoJSON of one (a dict, or the "
    "path of a .geojson file)"
)

_NEAR_DEGREES = 1.0
"""GeoJSON all of whose corners are so near a map's centre in longitude and latitude is in degrees.
Read as metres it would be two metres long."""


@dataclass(frozen=True, eq=False)
class SearchArea:
    """The part of a map in which targets are searched for.

    Shape legend: H, W grid.

    Parameters
    ----------
    polygon
        Its outline, metres; it may reach beyond the map.
    cells
        True for the cells whose centre is in it, borders included, shape (H, W); at least one.
    """

    polygon: BaseGeometry
    cells: NDArray[np.bool_]

    @property
    def n_cells(self) -> int:
        """Number of cells."""
        return int(self.cells.sum())

    def log_restricted(self, log_prior: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return a log prior, shape (S,), without the cells outside, normalised again.

        Raises
        ------
        InputError
            When it is zero in the whole area.
        """
        inside = np.where(self.cells.reshape(-1), log_prior, -np.inf)
        peak = inside.max()
        if not np.isfinite(peak):
            raise InputError(
                f"The prior is zero in all {self.n_cells} cells of the area; expected a positive "
                "weight in one of them: give another prior or a larger area"
            )
        restricted: NDArray[np.float64] = inside - (peak + np.log(np.exp(inside - peak).sum()))
        return restricted


def search_area(area: Any, grid: Grid) -> SearchArea:
    """Return the cells of an area that is given as a rectangle or a polygon.

    Parameters
    ----------
    area
        West, south, east and north border in metres, as four numbers or as the text ``W,S,E,N``,
        or in degrees as the text ``@W,S,E,N``; a shapely polygon in metres; GeoJSON, as a mapping
        or as the path of a file: polygons, or features and collections of them.
    grid
        The map's grid.

    Returns
    -------
    SearchArea
        What of the area lies on the map.

    Raises
    ------
    InputError
        When it is none of these, is not finite, empty or outside the map, has its borders in
        another order, crosses itself, holds no cell's centre, or when borders in metres are
        degrees of the map.

    Notes
    -----
    GeoJSON is in longitude and latitude (RFC 7946) when all its corners lie within a degree of the
    map's centre, else in metres.

    Examples
    --------
    >>> from sloop_ppl.maps import Grid
    >>> search_area((-50, -50, 50, 50), Grid.square(100)).n_cells
    400
    """
    if isinstance(area, SearchArea):
        return search_area(area.polygon, grid)
    if isinstance(area, BaseGeometry):
        polygon = _polygon(area, "The area")
    elif isinstance(area, Mapping):
        polygon = _from_geojson(area, grid, "The area")
    elif isinstance(area, Path):
        polygon = _from_file(area, grid)
    elif isinstance(area, str):
        numbers = _typed(area.removeprefix("@"))
        if numbers is None:
            polygon = _from_file(Path(area), grid)
        elif area.startswith("@"):
            polygon = _in_degrees(numbers, grid)
        else:
            polygon = _in_metres(numbers, grid)
    elif isinstance(area, Sequence | np.ndarray):
        polygon = _in_metres(area, grid)
    else:
        raise InputError(f"The area is a {type(area).__name__}; {_WANTED}")
    return SearchArea(polygon, _cells(polygon, grid))


def _cells(polygon: BaseGeometry, grid: Grid) -> NDArray[np.bool_]:
    if not polygon.intersects(shapely.box(*grid.cells_extent_m)):
        raise InputError(
            f"The area ({_borders(polygon)}) is outside the map; expected part of it within "
            f"{_borders(shapely.box(*grid.extent_m))} metres"
        )
    x, y = np.meshgrid(grid.x_m, grid.y_m)
    shapely.prepare(polygon)
    cells: NDArray[np.bool_] = shapely.intersects_xy(polygon, x, y)
    if not cells.any():
        raise InputError(
            f"The area ({_borders(polygon)}) holds no cell's centre; expected one larger than a "
            f"cell of {grid.cell_m:g} m"
        )
    return cells


def _typed(text: str) -> list[float] | None:
    """Return the numbers of ``W,S,E,N``; None for a text that is no list of numbers."""
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        return None


def _in_metres(borders: Any, grid: Grid) -> BaseGeometry:
    polygon = _rectangle(borders)
    west, south, east, north = polygon.bounds
    if are_degrees_of(grid, south, west) and are_degrees_of(grid, north, east):
        raise InputError(
            f"The area ({_borders(polygon)}) is in degrees; expected metres from the map's centre, "
            f"or the text @{west:.10g},{south:.10g},{east:.10g},{north:.10g}"
        )
    return polygon


def _in_degrees(borders: Sequence[float], grid: Grid) -> BaseGeometry:
    polygon = _rectangle(borders)
    west, south, east, north = polygon.bounds
    if not (west >= -180 and east <= 180 and south >= -90 and north <= 90):
        raise InputError(
            f"The area ({_borders(polygon)}) is not on earth; expected west, south, east, north in "
            "degrees"
        )
    # Sides that are straight in degrees bulge in metres.
    return project(
        shapely.segmentize(polygon, (east - west + north - south) / 32), grid.from_lonlat
    )


def _rectangle(borders: Any) -> BaseGeometry:
    try:
        values = [float(value) for value in borders]
    except (TypeError, ValueError) as error:
        raise InputError(f"The area is {borders!r}; {_WANTED}") from error
    listed = ", ".join(f"{value:g}" for value in values)
    if len(values) != 4:
        raise InputError(f"The area has {len(values)} numbers ({listed}); {_WANTED}")
    if not all(map(math.isfinite, values)):
        raise InputError(f"The area ({listed}) is not finite; {_WANTED}")
    west, south, east, north = values
    if not (west < east and south < north):
        raise InputError(
            f"The area ({listed}) is empty or in another order; expected west, south, east, north "
            "with west < east and south < north"
        )
    return shapely.box(west, south, east, north)


def _polygon(geometry: BaseGeometry, what: str) -> BaseGeometry:
    if geometry.is_empty or geometry.geom_type not in ("Polygon", "MultiPolygon"):
        kind = "empty" if geometry.is_empty else f"a {geometry.geom_type}"
        raise InputError(f"{what} is {kind}; expected a polygon with an area")
    if not np.isfinite(shapely.get_coordinates(geometry)).all():
        raise InputError(f"{what} has a corner that is not finite; expected metres")
    if not geometry.is_valid:
        raise InputError(
            f"{what} is no sound polygon ({shapely.is_valid_reason(geometry)}); expected an "
            "outline that does not cross itself"
        )
    return shapely.force_2d(geometry)


def _from_file(path: Path, grid: Grid) -> BaseGeometry:
    text = read_text(path, "Area", hint=f"; {_WANTED}")
    try:
        data = parse_json(text, finite=False)  # whose numbers are checked as corners
    except ForeignFault as error:
        raise InputError(f"Area '{path}' is not JSON ({error}); {_WANTED}") from error
    if not isinstance(data, Mapping):
        raise InputError(f"Area '{path}' holds a {type(data).__name__}; expected a GeoJSON object")
    return _from_geojson(data, grid, f"Area '{path}'")


def _from_geojson(data: Mapping[str, Any], grid: Grid, what: str) -> BaseGeometry:
    shapes = []
    for member in _geometries(data):
        try:
            # A polygon is checked before it is joined to others, which would repair it.
            shapes.append(_polygon(shape_of(member), what))
        except InputError:
            raise
        except Exception as error:  # shapely raises what it meets: KeyError, TypeError, GEOS
            reason = " ".join(f"{type(error).__name__}: {error}".split())
            raise InputError(f"{what} is no GeoJSON of a polygon ({reason})") from error
    if not shapes:
        raise InputError(f"{what} holds no geometry; expected GeoJSON of a polygon")
    joined = _polygon(parts_of_dimension(shapely.union_all(shapes), 2) or shapely.Polygon(), what)
    if grid.centre is None:
        return joined
    lat, lon = grid.centre
    away = np.abs(shapely.get_coordinates(joined) - (lon, lat))
    return project(joined, grid.from_lonlat) if away.max() <= _NEAR_DEGREES else joined


def _geometries(data: Any) -> list[Any]:
    """Return the geometries of a GeoJSON object."""
    kind = data.get("type") if isinstance(data, Mapping) else None
    if kind in ("FeatureCollection", "GeometryCollection"):
        members = data.get("features" if kind == "FeatureCollection" else "geometries")
        return [g for member in members or () for g in _geometries(member)]
    return _geometries(data.get("geometry")) if kind == "Feature" else [data]


def _borders(polygon: BaseGeometry) -> str:
    return ", ".join(f"{value:g}" for value in polygon.bounds)
