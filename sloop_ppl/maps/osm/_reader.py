"""Read the tagged shapes of an OpenStreetMap file, through pyosmium."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.errors import MapError
from sloop_ppl.maps.osm._feature import OsmData, OsmFeature
from sloop_ppl.maps.osm._mend import Unmade, mended
from sloop_ppl.maps.osm._ordered import NotInOrder, drawn_id, ordered_copy
from sloop_ppl.maps.osm.import_report import ImportReport

__all__ = ["Bounds", "file_bounds", "read_osm", "unreadable"]

Bounds = tuple[float, float, float, float]
"""West, south, east and north in degrees."""

# What libosmium has for the place of a node that the file lacks.
_UNDEFINED = 2147483647
_STREET_RELATIONS = {"associatedStreet", "street"}


def file_bounds(path: Path) -> Bounds | None:
    """Return the bounds that the header of a file states; None when it states none.

    Raises
    ------
    MapError
        When the file cannot be read as OpenStreetMap.
    """
    import osmium

    try:
        with osmium.io.Reader(str(path), osmium.osm.osm_entity_bits.NOTHING) as reader:
            box = reader.header().box()
            if not box.valid():
                return None
            low, high = box.bottom_left, box.top_right
            return low.lon, low.lat, high.lon, high.lat
    except Exception as error:  # libosmium raises RuntimeError and kinds of its own
        raise unreadable(path, error) from None


def read_osm(path: Path, bounds: Bounds | None, report: ImportReport) -> OsmData:
    """Read the tagged nodes, ways and multipolygons that reach into some bounds.

    Parameters
    ----------
    path
        ``.osm`` XML or ``.osm.pbf``, compressed or not.
    bounds
        What to keep, degrees; everything when None.

    Raises
    ------
    MapError
        When the file cannot be read, or has a coordinate that is not on earth.
    """
    try:
        try:
            return _collected(path, path, bounds, report)
        except (RuntimeError, NotInOrder) as error:
            if isinstance(error, RuntimeError) and "out of order" not in str(error):
                raise
        report.restart()
        with tempfile.TemporaryDirectory() as folder:
            copy, report.duplicates = ordered_copy(path, Path(folder))
            return _collected(copy, path, bounds, report)
    except MapError:
        raise
    except Exception as error:  # libosmium raises RuntimeError and kinds of its own
        raise unreadable(path, error) from None


def _collected(path: Path, called: Path, bounds: Bounds | None, report: ImportReport) -> OsmData:
    import osmium

    found = _Collector(called, bounds, report)
    objects = osmium.FileProcessor(str(path)).with_locations().with_areas()
    for thing in objects.with_filter(osmium.filter.EmptyTagFilter()):
        found.take(thing)
    return found.data(path)


class _Collector:
    """Collects the shapes of a file while it is read."""

    def __init__(self, path: Path, bounds: Bounds | None, report: ImportReport) -> None:
        self.path, self.bounds, self.report = path, bounds, report
        self.features: dict[str, OsmFeature] = {}
        self.street_of: dict[str, str] = {}
        self.relations: dict[str, Unmade] = {}
        self.assembled: set[str] = set()
        self.extent = [float("inf"), float("inf"), -float("inf"), -float("inf")]

    def take(self, thing: Any) -> None:
        if thing.is_area():
            if not thing.from_way():
                self._take_area(thing)
            return
        if thing.id < 0:
            raise NotInOrder
        if thing.deleted:
            return
        self.report.read += 1
        if thing.is_node():
            self._take_node(thing)
        elif thing.is_way():
            self._take_way(thing)
        else:
            self._take_relation(thing)

    def _take_node(self, node: Any) -> None:
        source = f"node/{drawn_id(node.id)}"
        lon, lat = self._lonlat(node.location, source)
        self._keep(source, dict(node.tags), shapely.Point(lon, lat))

    def _take_way(self, way: Any) -> None:
        source = f"way/{drawn_id(way.id)}"
        if any(ref.ref < 0 for ref in way.nodes):
            raise NotInOrder
        # Extracts cut ways at their border: the nodes beyond are not in the file.
        given = [ref for ref in way.nodes if ref.location.x != _UNDEFINED]
        corners = [self._lonlat(ref.location, f"node/{drawn_id(ref.ref)}") for ref in given]
        whole = len(given) == len(way.nodes)
        if not self._meets(corners):
            self.report.outside += 1
            return
        self.report.cut_short += not whole
        whole = whole and way.is_closed()
        # Repeated corners make no side.
        distinct = [c for c, before in zip(corners, [None, *corners], strict=False) if c != before]
        if len(distinct) < 2:
            return
        line = shapely.LineString(distinct)
        # Three corners and the first again.
        if whole and len(distinct) >= 4:
            self._keep(source, dict(way.tags), shapely.Polygon(distinct), outline=line)
        else:
            self._keep(source, dict(way.tags), line)

    def _take_area(self, area: Any) -> None:
        source = f"relation/{drawn_id(area.orig_id())}"
        self.assembled.add(source)
        polygons = []
        for outer in area.outer_rings():
            holes = [_corners(inner) for inner in area.inner_rings(outer)]
            polygons.append(shapely.Polygon(_corners(outer), holes))
        if not polygons:
            self.assembled.discard(source)
            return
        corners = [c for p in polygons for c in p.exterior.coords]
        if not self._meets(corners):
            self.report.outside += 1
            return
        shape = polygons[0] if len(polygons) == 1 else shapely.MultiPolygon(polygons)
        self._keep(source, dict(area.tags), shape)

    def _take_relation(self, relation: Any) -> None:
        tags = dict(relation.tags)
        if tags.get("type") in _STREET_RELATIONS and "name" in tags:
            for member in relation.members:
                # The roles of houses in both kinds of relation.
                if member.role in ("house", "addr:houselink", "address"):
                    sort = {"n": "node", "w": "way", "r": "relation"}[member.type]
                    self.street_of.setdefault(f"{sort}/{drawn_id(member.ref)}", tags["name"])
        elif tags.get("type") == "multipolygon":
            ways = tuple((m.ref, m.role) for m in relation.members if m.type == "w")
            self.relations[f"relation/{drawn_id(relation.id)}"] = tags, ways

    def data(self, path: Path) -> OsmData:
        """Return what was collected, in the order of the sources' numbers."""
        unmade = {s: r for s, r in self.relations.items() if s not in self.assembled}
        for feature in mended(path, unmade, self.report):
            west, south, east, north = feature.geometry.bounds
            if self._meets([(west, south), (east, north)]):
                self._keep(feature.source, feature.tags, feature.geometry)
        features = list(self.features.values())
        bounds = tuple(self.extent) if self.features else None
        return OsmData(features, self.street_of, bounds)  # type: ignore[arg-type]

    def _keep(
        self,
        source: str,
        tags: dict[str, str],
        geometry: BaseGeometry,
        outline: BaseGeometry | None = None,
    ) -> None:
        west, south, east, north = geometry.bounds
        if geometry.geom_type == "Point" and not self._meets([(west, south)]):
            self.report.outside += 1
            return
        self.features[source] = OsmFeature(source, tags, geometry, outline)
        e = self.extent
        self.extent = [min(e[0], west), min(e[1], south), max(e[2], east), max(e[3], north)]

    def _meets(self, corners: list[tuple[float, float]]) -> bool:
        if not corners:
            return False
        if self.bounds is None:
            return True
        west, south, east, north = self.bounds
        lon, lat = zip(*corners, strict=True)
        return not (max(lon) < west or min(lon) > east or max(lat) < south or min(lat) > north)

    def _lonlat(self, location: Any, source: str) -> tuple[float, float]:
        if location.valid():
            return location.lon, location.lat
        lat, lon = location.lat_without_check(), location.lon_without_check()
        name = "lat" if not -90 <= lat <= 90 else "lon"
        raise MapError(
            f"{self.path}: {source}: field '{name}' of lat {lat:g}, lon {lon:g} is out of range; "
            "expected lat in [-90, 90] and lon in [-180, 180]",
            feature=source,
            field=name,
        )


def _corners(ring: Any) -> list[tuple[float, float]]:
    return [(ref.lon, ref.lat) for ref in ring]


_COORDINATE = re.compile(r"coordinate: '([^']*)'|lon/lat: '?([^'\s]*)")


def unreadable(path: Path, error: Exception) -> MapError:
    """Return the one line for a file that libosmium refuses; it names the node at fault."""
    message = " ".join(str(error).split()) or type(error).__name__
    feature = name = None
    if found := _COORDINATE.search(message):
        value = found[2] if found[1] is None else found[1]
        if bearer := next(_bearers(path, value), None):
            feature, name = bearer
            message = f"{feature}: field '{name}' is {value!r}"
    return MapError(
        f"File '{path}' cannot be read as OpenStreetMap: {message}; expected .osm XML or .osm.pbf, "
        "whole",
        feature=feature,
        field=name,
    )


def _bearers(path: Path, value: str) -> Iterator[tuple[str, str]]:
    """Yield the nodes of an XML file that have a coordinate of this text, to name them."""
    node = re.compile(rb"<node\b[^>]*>")
    try:
        # 256 MiB: larger files are not read a second time only to name the node.
        content = path.read_bytes() if path.stat().st_size < 1 << 28 else b""
    except OSError:
        return
    for found in node.finditer(content):
        text = found[0].decode("utf-8", "replace")
        number = re.search(r"\bid=[\"'](-?\d+)", text)
        for name in ("lat", "lon"):
            if number and re.search(rf"\b{name}=[\"']{re.escape(value)}[\"']", text):
                yield f"node/{number[1]}", name
