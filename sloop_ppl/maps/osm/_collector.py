"""Collect the tagged shapes of an OpenStreetMap file while pyosmium reads it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.errors import MapError
from sloop_ppl.maps.osm._feature import OsmData, OsmFeature
from sloop_ppl.maps.osm._mend import Unmade, mended
from sloop_ppl.maps.osm._ordered import NotInOrder, drawn_id
from sloop_ppl.maps.osm._window import Bounds, Window
from sloop_ppl.maps.osm.import_report import ImportReport

__all__ = ["Collector"]

# What libosmium has for the place of a node that the file lacks.
_UNDEFINED = 2147483647
_STREET_RELATIONS = {"associatedStreet", "street"}


class Collector:
    """Collects the shapes of a file while it is read.

    Parameters
    ----------
    path
        The file, for messages.
    bounds
        What to keep, degrees; everything when None.
    report
        Counts what is read and left out.
    """

    def __init__(self, path: Path, bounds: Bounds | None, report: ImportReport) -> None:
        self.path, self.report, self.window = path, report, Window(bounds)
        self.features: dict[str, OsmFeature] = {}
        self.street_of: dict[str, str] = {}
        self.relations: dict[str, Unmade] = {}
        self.assembled: set[str] = set()
        self.lost_nodes: set[int] = set()
        self._before: tuple[str, int] | None = None

    def take(self, thing: Any) -> None:
        """Take a node, way, relation or assembled area."""
        if thing.is_area():
            if not thing.from_way():
                self._take_area(thing)
            return
        this = (thing.type_str(), thing.id)
        if thing.id < 0 or this == self._before:  # of several versions the newest counts
            raise NotInOrder
        self._before = this
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
        self.report.ways += 1
        if not whole or not given:
            self.lost_nodes.update(r.ref for r in way.nodes if r.location.x == _UNDEFINED)
            # What is left of an outline is none.
            self.report.lost_ways += len(given) < 2 or way.ends_have_same_id()
        if not corners:
            self.report.no_coordinates += 1
            return
        if not self.window.meets(corners):
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
        if not self.window.meets(corners):
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

    def data(self, source: Any) -> OsmData:
        """Return what was collected; relations that could not be assembled are read again."""
        unmade = {s: r for s, r in self.relations.items() if s not in self.assembled}
        self.report.relations += len(self.relations)
        for feature in mended(source, unmade, self.lost_nodes, self.report):
            west, south, east, north = feature.geometry.bounds
            if self.window.meets([(west, south), (east, north)]):
                self._keep(feature.source, feature.tags, feature.geometry)
        return OsmData(list(self.features.values()), self.street_of, self.window.reached)

    def _keep(
        self,
        source: str,
        tags: dict[str, str],
        geometry: BaseGeometry,
        outline: BaseGeometry | None = None,
    ) -> None:
        if geometry.geom_type == "Point" and not self.window.meets([(geometry.x, geometry.y)]):
            self.report.outside += 1
            return
        self.features[source] = OsmFeature(source, tags, geometry, outline)

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
