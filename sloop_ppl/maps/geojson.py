"""Read and write the map format: a GeoJSON FeatureCollection in WGS84."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.errors import MapError
from sloop_ppl.maps.city import CityMap
from sloop_ppl.maps.grid import Grid
from sloop_ppl.maps.landmark import KINDS, Landmark

__all__ = ["from_geojson", "read_map", "to_geojson", "write_map"]

_OWN_MEMBERS = {
    "type", "name", "attribution", "centre", "half_extent_m", "extent_m", "cell_m", "features",
}  # fmt: skip
_OWN_PROPERTIES = {"id", "name", "kind", "aliases", "within", "width_m"}


def read_map(path: str | Path, cell_m: float | None = None) -> CityMap:
    """Read a map file.

    Parameters
    ----------
    path : a ``.geojson`` file.
    cell_m : side of a cell in metres; the file's own, else 5, when None.

    Raises
    ------
    MapError : when the file cannot be read or does not follow the format.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise MapError(f"Map file '{path}' cannot be read: {error}") from error
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise MapError(f"Map file '{path}' is not JSON: {error}") from error
    return from_geojson(data, cell_m=cell_m, source=str(path))


def from_geojson(data: Any, cell_m: float | None = None, source: str = "map") -> CityMap:
    """Make a map of parsed GeoJSON.

    Parameters
    ----------
    data : the FeatureCollection as parsed by :mod:`json`.
    cell_m : side of a cell in metres; the map's own, else 5, when None.
    source : what to call the input in messages.

    Raises
    ------
    MapError : when the data do not follow the format; it names the feature and the field.
    """
    if not isinstance(data, Mapping) or data.get("type") != "FeatureCollection":
        raise MapError(
            f"{source}: field 'type' is not 'FeatureCollection'; expected a map file as "
            "`sloop map import` writes it",
            field="type",
        )
    features = data.get("features")
    if not isinstance(features, list):
        raise MapError(f"{source}: field 'features' is not a list", field="features")
    grid = _grid(data, cell_m, source)
    landmarks = tuple(_landmark(f, i, grid, source) for i, f in enumerate(features))
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


def write_map(city: CityMap, path: str | Path) -> None:
    """Write a map file."""
    data = to_geojson(city)
    features = ",\n".join(json.dumps(f, ensure_ascii=False) for f in data.pop("features"))
    head = json.dumps(data, ensure_ascii=False)[:-1]
    Path(path).write_text(f'{head}, "features": [\n{features}\n]}}\n', encoding="utf-8")


def _grid(data: Mapping[str, Any], cell_m: float | None, source: str) -> Grid:
    centre = data.get("centre")
    lat = _number(centre.get("lat") if isinstance(centre, Mapping) else None, "centre.lat", source)
    lon = _number(centre.get("lon") if isinstance(centre, Mapping) else None, "centre.lon", source)
    if not (-90 <= lat <= 90 and -180 <= lon <= 180):
        raise MapError(
            f"{source}: field 'centre' is lat {lat}, lon {lon}; expected lat in [-90, 90] and "
            "lon in [-180, 180]; are they swapped?",
            field="centre",
        )
    if "half_extent_m" in data:
        half = _number(data["half_extent_m"], "half_extent_m", source)
        extent = [-half, -half, half, half]
    else:
        given = data.get("extent_m")
        if not isinstance(given, list) or len(given) != 4:
            raise MapError(
                f"{source}: field 'half_extent_m' is missing; expected a number of metres "
                "(or 'extent_m': [west, south, east, north])",
                field="half_extent_m",
            )
        extent = [_number(value, "extent_m", source) for value in given]
    if cell_m is None:
        cell_m = _number(data.get("cell_m", 5.0), "cell_m", source)
    try:
        return Grid(*extent, cell_m=cell_m, centre=(lat, lon))
    except ValueError as error:
        raise MapError(f"{source}: {error}", field="extent_m") from error


def _landmark(feature: Any, index: int, grid: Grid, source: str) -> Landmark:
    properties = feature.get("properties") if isinstance(feature, Mapping) else None
    if not isinstance(properties, Mapping):
        raise _fault(source, f"number {index}", "properties", "is missing; expected an object")
    landmark_id = properties.get("id")
    if not isinstance(landmark_id, str) or not landmark_id:
        raise _fault(source, f"number {index}", "id", f"is {landmark_id!r}; expected a name")
    kind = properties.get("kind")
    if kind not in KINDS:
        raise _fault(
            source, landmark_id, "kind", f"is {kind!r}; expected one of {', '.join(KINDS)}"
        )
    for name in ("name", "within"):
        if not isinstance(properties.get(name), str | None):
            raise _fault(source, landmark_id, name, f"is {properties[name]!r}; expected a string")
    aliases = properties.get("aliases", [])
    if not isinstance(aliases, list) or not all(isinstance(a, str) for a in aliases):
        raise _fault(source, landmark_id, "aliases", "is not a list of strings")
    width = properties.get("width_m")
    return Landmark(
        id=landmark_id,
        kind=kind,
        geometry=_geometry(feature.get("geometry"), landmark_id, grid, source),
        name=properties.get("name"),
        aliases=tuple(aliases),
        within=properties.get("within"),
        width_m=None if width is None else _number(width, "width_m", f"{source}: '{landmark_id}'"),
        properties=MappingProxyType(
            {k: v for k, v in properties.items() if k not in _OWN_PROPERTIES}
        ),
    )


def _geometry(data: Any, landmark_id: str, grid: Grid, source: str) -> BaseGeometry:
    try:
        lonlat = shapely.geometry.shape(data)
        coordinates = shapely.get_coordinates(lonlat)
    except Exception as error:  # shapely raises many kinds for malformed input
        raise _fault(source, landmark_id, "geometry", f"is not GeoJSON: {error}") from error
    if lonlat.is_empty:
        raise _fault(source, landmark_id, "geometry", "is empty")
    lon, lat = coordinates.T
    if not ((abs(lon) <= 180).all() and (abs(lat) <= 90).all()):
        raise _fault(
            source,
            landmark_id,
            "geometry",
            "has coordinates out of range; expected [longitude, latitude] in degrees",
        )
    geometry: BaseGeometry = shapely.transform(
        lonlat, lambda x, y: grid.from_lonlat(x, y), interleaved=False
    )
    return geometry


def _feature(landmark: Landmark, grid: Grid) -> dict[str, Any]:
    lonlat = shapely.transform(
        landmark.geometry, lambda x, y: grid.to_lonlat(x, y), interleaved=False
    )
    optional = {
        "name": landmark.name,
        "aliases": list(landmark.aliases) or None,
        "within": landmark.within,
        "width_m": landmark.width_m,
    }
    return {
        "type": "Feature",
        "properties": {
            "id": landmark.id,
            "kind": landmark.kind,
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


def _number(value: Any, name: str, source: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise MapError(
            f"{source}: field '{name}' is {value!r}; expected a finite number", field=name
        )
    return float(value)


def _fault(source: str, feature: str, name: str, what: str) -> MapError:
    return MapError(
        f"{source}: feature {feature!r}: field '{name}' {what}", feature=feature, field=name
    )
