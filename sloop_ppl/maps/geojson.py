"""Convert maps from and to the map format: a GeoJSON FeatureCollection in WGS84."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.errors import MapError
from sloop_ppl.maps._shapes import project, repair
from sloop_ppl.maps.city import CityMap
from sloop_ppl.maps.grid import Grid
from sloop_ppl.maps.landmark import Landmark
from sloop_ppl.maps.schema import check_schema, fault

__all__ = ["from_geojson", "to_geojson"]

# A landmark may lie outside the map, but not so far that it can only be a mistake.
_FAR_M = 5000.0
_FAR_SIDES = 5.0

_LOG = logging.getLogger(__name__)

_OWN_MEMBERS = {
    "type", "name", "attribution", "centre", "half_extent_m", "extent_m", "cell_m", "features",
}  # fmt: skip
_FEATURE_MEMBERS = {"type", "properties", "geometry"}
_OWN_PROPERTIES = {"id", "name", "kind", "aliases", "within", "width_m"}


def from_geojson(data: Any, cell_m: float | None = None, source: str = "map") -> CityMap:
    """Make a map of parsed GeoJSON.

    Parameters
    ----------
    data
        The FeatureCollection as parsed by :mod:`json`.
    cell_m
        Side of a cell in metres; the map's own, else 5, when None.
    source
        What to call the input in messages.

    Raises
    ------
    MapError
        When the data do not follow the format; it names the feature and the field.
    """
    check_schema(data, source)
    grid = _grid(data, cell_m, source)
    repaired: list[str] = []
    landmarks = tuple(_landmark(f, grid, source, repaired) for f in data["features"])
    _check_inside(landmarks, grid, source)
    if repaired:
        _LOG.warning(
            "%s: outlines that cross themselves, repaired: %d (%s)",
            source, len(repaired), ", ".join(repaired[:5]) + (", …" if repaired[5:] else ""),
        )  # fmt: skip
    return CityMap(
        name=str(data.get("name") or Path(source).stem),
        grid=grid,
        landmarks=landmarks,
        attribution=str(data.get("attribution") or ""),
        properties=MappingProxyType({k: v for k, v in data.items() if k not in _OWN_MEMBERS}),
    )


def to_geojson(city: CityMap) -> dict[str, Any]:
    """Return a map as a GeoJSON FeatureCollection, coordinates to nine decimals of a degree."""
    grid = city.grid
    if grid.centre is None:
        raise MapError(f"Map '{city.name}' has no centre on earth and cannot be written as GeoJSON")
    west, south, east, north = grid.extent_m
    # Square maps round their centre are written in the short form.
    square = -west == east == -south == north
    data: dict[str, Any] = {
        "type": "FeatureCollection",
        "name": city.name,
        "attribution": city.attribution,
        "centre": {"lat": grid.centre[0], "lon": grid.centre[1]},
        **({"half_extent_m": east} if square else {"extent_m": list(grid.extent_m)}),
        "cell_m": grid.cell_m,
        **city.properties,
    }
    data["features"] = [_feature(m, grid) for m in city.landmarks]
    return data


def _grid(data: Mapping[str, Any], cell_m: float | None, source: str) -> Grid:
    centre = float(data["centre"]["lat"]), float(data["centre"]["lon"])
    half = data.get("half_extent_m")
    extent = data["extent_m"] if half is None else [-half, -half, half, half]
    try:
        west, south, east, north = (float(metres) for metres in extent)
        cell = float(data.get("cell_m", 5.0) if cell_m is None else cell_m)
        return Grid(west, south, east, north, cell, centre)
    except ValueError as error:
        name = "extent_m" if half is None else "half_extent_m"
        raise MapError(f"{source}: field '{name}': {error}", field=name) from error


def _check_inside(landmarks: tuple[Landmark, ...], grid: Grid, source: str) -> None:
    """Refuse a map none of whose landmarks is inside; one without landmarks is an empty patch."""
    west, south, east, north = grid.extent_m
    lat, lon = grid.centre or (math.inf, math.inf)
    if west <= lon <= east and south <= lat <= north and max(east - west, north - south) < 1:
        raise MapError(
            f"{source}: field 'extent_m' is {[west, south, east, north]}, which looks like "
            "degrees; expected metres from the centre, [west, south, east, north]",
            field="extent_m",
        )
    box = shapely.box(west, south, east, north)
    if landmarks and not any(shapely.intersects(box, m.geometry) for m in landmarks):
        raise MapError(
            f"{source}: none of its {len(landmarks)} landmarks is inside field 'extent_m' "
            f"({west:g}, {south:g}, {east:g}, {north:g} metres from the centre); expected an "
            "extent in metres that holds them",
            field="extent_m",
        )


def _landmark(feature: Mapping[str, Any], grid: Grid, source: str, repaired: list[str]) -> Landmark:
    properties = feature["properties"]
    width = properties.get("width_m")
    return Landmark(
        id=properties["id"],
        kind=properties["kind"],
        geometry=_geometry(feature["geometry"], properties["id"], grid, source, repaired),
        name=properties.get("name"),
        aliases=tuple(properties.get("aliases", ())),
        within=properties.get("within"),
        width_m=None if width is None else float(width),
        properties=MappingProxyType(
            {k: v for k, v in properties.items() if k not in _OWN_PROPERTIES}
        ),
        members=MappingProxyType({k: v for k, v in feature.items() if k not in _FEATURE_MEMBERS}),
    )


def _geometry(
    data: Any, landmark_id: str, grid: Grid, source: str, repaired: list[str]
) -> BaseGeometry:
    try:
        lonlat = shapely.geometry.shape(data)
    except Exception as error:  # shapely raises many kinds for malformed input
        raise fault(source, landmark_id, "geometry", f"is not GeoJSON: {error}") from error
    if lonlat.is_empty:
        raise fault(source, landmark_id, "geometry", "is empty")
    geometry = project(lonlat, grid.from_lonlat)
    if not np.isfinite(shapely.get_coordinates(geometry)).all():
        raise fault(source, landmark_id, "geometry", "lies too far from the map's centre")
    if (away_m := _away(geometry, grid)) > _far(grid):
        raise fault(
            source,
            landmark_id,
            "geometry",
            f"lies {away_m / 1000:.0f} km outside the map; are longitude and latitude swapped?",
        )
    if geometry.is_valid:
        return geometry
    sound = repair(geometry)
    if sound is None:
        raise fault(source, landmark_id, "geometry", "is an outline that encloses no area")
    repaired.append(landmark_id)
    return sound


def _far(grid: Grid) -> float:
    west, south, east, north = grid.extent_m
    return _FAR_M + _FAR_SIDES * max(east - west, north - south)


def _away(geometry: BaseGeometry, grid: Grid) -> float:
    """Return how far a geometry's bounding box is from the extent, metres."""
    west, south, east, north = grid.extent_m
    min_x, min_y, max_x, max_y = geometry.bounds
    return math.hypot(max(west - max_x, min_x - east, 0.0), max(south - max_y, min_y - north, 0.0))


def _feature(landmark: Landmark, grid: Grid) -> dict[str, Any]:
    optional = {
        "name": landmark.name,
        "kind": landmark.kind,
        "aliases": list(landmark.aliases) or None,
        "within": landmark.within,
        "width_m": landmark.width_m,
    }
    lonlat = project(landmark.geometry, grid.to_lonlat)
    return {
        "type": "Feature",
        **landmark.members,
        "properties": {
            "id": landmark.id,
            **{k: v for k, v in optional.items() if v is not None},
            **landmark.properties,
        },
        "geometry": _rounded(shapely.geometry.mapping(lonlat)),
    }


def _rounded(value: Any) -> Any:
    """Round the coordinates in a GeoJSON geometry to nine decimals, about 0.1 mm."""
    if isinstance(value, Mapping):
        return {k: _rounded(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(v) for v in value]
    return round(value, 9) if isinstance(value, float) else value
