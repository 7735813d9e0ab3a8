"""Read GeoJSON whose features have tags of OpenStreetMap, of overpass-turbo and QGIS."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.errors import MapError
from sloop_ppl.maps.osm._feature import OsmData, OsmFeature
from sloop_ppl.maps.osm._window import Bounds, Window
from sloop_ppl.maps.osm.import_report import ImportReport

__all__ = ["read_tagged"]

_SORTS = {
    "n": "node", "w": "way", "r": "relation", "node": "node", "way": "way", "relation": "relation",
}  # fmt: skip
# "way/12" of overpass-turbo, "w12" of QuickOSM and osmium; osmium numbers areas "a" apart.
_NAMED = re.compile(r"(node|way|relation|n|w|r)/?(-?\d{1,18})")
_AREA = re.compile(r"a(\d{1,18})")
# Members of the properties that are no tags.
_NO_TAGS = {
    "id", "fid", "type", "tags", "other_tags", "all_tags", "relations", "meta", "osm_id",
    "osm_way_id", "osm_type", "full_id", "z_order", "@id", "@type", "timestamp", "version",
    "changeset", "user", "uid",
}  # fmt: skip
# What OGR writes for tags it has no column for: "key"=>"value","key"=>"value".
_HSTORE = re.compile(r'"((?:[^"\\]|\\.)*)"=>"((?:[^"\\]|\\.)*)"')
_MULTI = {
    "LineString": shapely.MultiLineString, "MultiLineString": shapely.MultiLineString,
    "Polygon": shapely.MultiPolygon, "MultiPolygon": shapely.MultiPolygon,
}  # fmt: skip
# Systems of coordinates that are longitude and latitude.
_DEGREES = re.compile(r"(CRS:?:?84|EPSG:+(?:[\d.]*:)?4326)$", re.IGNORECASE)


def read_tagged(data: Any, path: Path, bounds: Bounds | None, report: ImportReport) -> OsmData:
    """Read the features of parsed GeoJSON that reach into some bounds.

    Parameters
    ----------
    data
        A FeatureCollection or a Feature.
    path
        The file it comes from, for messages.
    bounds
        What to keep, degrees; everything when None.

    Raises
    ------
    MapError
        When it is no GeoJSON, is a map already, or has a coordinate that is not on earth.
    """
    items = _features(data, path)
    window = Window(bounds)
    features: dict[str, OsmFeature] = {}
    for i, item in enumerate(items):
        if not isinstance(item, Mapping) or not isinstance(item.get("properties") or {}, Mapping):
            raise MapError(f"File '{path}': feature number {i} is no GeoJSON Feature")
        tags = _tags(item.get("properties") or {})
        if not tags:
            continue
        report.read += 1
        if item.get("geometry") is None:
            report.no_coordinates += 1
            continue
        shape = _shape(item["geometry"], path, i)
        source = _source(item, shape, i)
        if shape is None:
            report.broken.append(source)
            continue
        if not window.meets([(x, y) for x, y in shapely.get_coordinates(shape).tolist()]):
            report.outside += 1
            continue
        if (before := features.get(source)) is not None and _is_piece(before.geometry, shape):
            pieces = shapely.get_parts([before.geometry, shape])
            shape = _MULTI[shape.geom_type](list(pieces))
        else:
            report.duplicates += before is not None
        features[source] = _feature(source, tags, shape)
    return OsmData(list(features.values()), {}, window.reached)


def _features(data: Any, path: Path) -> list[Any]:
    if isinstance(data, Mapping) and data.get("type") == "Feature":
        data = {"type": "FeatureCollection", "features": [data]}
    if not isinstance(data, Mapping) or not isinstance(data.get("features"), list):
        raise MapError(
            f"File '{path}' is JSON of another kind; expected Overpass JSON ('elements') or "
            "GeoJSON ('features')"
        )
    if "centre" in data:
        raise MapError(f"File '{path}' is a map already; use it where a map is asked for")
    crs = data.get("crs")
    inner = crs.get("properties") if isinstance(crs, Mapping) else None
    named = inner.get("name") if isinstance(inner, Mapping) else None
    if isinstance(named, str) and not _DEGREES.search(named):
        raise MapError(
            f"File '{path}' has coordinates in {named:.60}; expected degrees: export it in "
            "EPSG:4326 (WGS 84)"
        )
    features: list[Any] = data["features"]
    return features


def _tags(properties: Mapping[str, Any]) -> dict[str, str]:
    given = properties.get("tags")
    if isinstance(given, Mapping):  # overpass-turbo of old
        return {str(k): str(v) for k, v in given.items() if v is not None}
    tags: dict[str, str] = {}
    for key in ("other_tags", "all_tags"):
        value = properties.get(key)
        if isinstance(value, str):
            tags |= {_plain(k): _plain(v) for k, v in _HSTORE.findall(value)}
        elif isinstance(value, Mapping):
            tags |= {str(k): str(v) for k, v in value.items() if v is not None}
    for key, value in properties.items():
        # QGIS writes null, and older ones an empty text, in columns that a feature has no tag for.
        plain = isinstance(value, str | int | float) and not isinstance(value, bool)
        if key not in _NO_TAGS and not key.startswith("@") and plain and value != "":
            tags[str(key)] = f"{value:g}" if isinstance(value, float) else str(value)
    return tags


def _plain(text: str) -> str:
    return text.replace('\\"', '"').replace("\\\\", "\\")


def _source(item: Mapping[str, Any], shape: BaseGeometry | None, index: int) -> str:
    """Return the element a feature comes from; a number of its own when the file does not say."""
    properties = item.get("properties") or {}
    for text in (properties.get("@id"), properties.get("full_id"), item.get("id")):
        if isinstance(text, str) and (named := _NAMED.fullmatch(text)):
            return f"{_SORTS[named[1]]}/{int(named[2])}"
        if isinstance(text, str) and (area := _AREA.fullmatch(text)):
            # Osmium gives areas twice the id of their way, and one more than that of a relation.
            return f"{('way', 'relation')[int(area[1]) % 2]}/{int(area[1]) // 2}"
    sort = "way"
    if shape is not None and shape.geom_type == "Point":
        sort = "node"
    elif shape is not None and shape.geom_type.startswith("Multi"):
        sort = "relation"
    stated = properties.get("@type", properties.get("osm_type", properties.get("type")))
    if properties.get("osm_way_id"):  # the table of areas that OGR makes
        return f"way/{_number(properties['osm_way_id'], index)}"
    sort = _SORTS.get(stated, sort) if isinstance(stated, str) else sort
    known = (properties.get(k) for k in ("@id", "osm_id", "id"))
    return f"{sort}/{_number(next((v for v in known if v not in (None, '')), None), index)}"


def _number(value: Any, index: int) -> int:
    try:
        return int(str(value)[:18])
    except ValueError:
        # Below zero, as editors number what OpenStreetMap has no number for.
        return -1 - index


def _shape(geometry: Any, path: Path, index: int) -> BaseGeometry | None:
    """Return a point, line or area; None when there is nothing in it or it is of several sorts."""
    try:
        shape = shapely.force_2d(shapely.geometry.shape(geometry))
    except Exception as error:  # shapely raises many kinds for malformed input
        raise MapError(
            f"File '{path}': feature number {index}: geometry is no GeoJSON: {error}"
        ) from None
    if shape.is_empty or shape.geom_type in ("GeometryCollection", "LinearRing"):
        return None
    places = shapely.get_coordinates(shape)
    on_earth = np.abs(places) <= (180, 90)
    if not on_earth.all():
        lon, lat = places[~on_earth.all(axis=1)][0]
        raise MapError(
            f"File '{path}': feature number {index}: lon {lon:g}, lat {lat:g} is not on earth; "
            "expected degrees (EPSG:4326), longitude first"
        )
    parts = shapely.get_parts(shape)
    return parts[0] if len(parts) == 1 or shape.geom_type == "MultiPoint" else shape


def _is_piece(before: BaseGeometry, shape: BaseGeometry) -> bool:
    """Tell whether two shapes of one element are pieces of it, as QGIS makes when it cuts."""
    if not (before.is_valid and shape.is_valid):
        return False
    family = _MULTI.get(shape.geom_type)
    alike = family is not None and family is _MULTI.get(before.geom_type)
    return alike and bool(before.disjoint(shape) or before.touches(shape))


def _feature(source: str, tags: dict[str, str], shape: BaseGeometry) -> OsmFeature:
    ring = None
    if shape.geom_type == "Polygon" and not shape.interiors:
        ring = shapely.LineString(shape.exterior.coords)
    elif shape.geom_type == "LineString" and shape.is_closed and len(shape.coords) >= 4:
        # A closed way, which its tags make a ring road or an area.
        ring, shape = shape, shapely.Polygon(shape.coords)
    return OsmFeature(source, tags, shape, ring)
