"""Put entrances, addresses and places on the buildings they belong to."""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import Any

import numpy as np
import shapely

from sloop_ppl.maps._symbols import folded
from sloop_ppl.maps.osm._feature import OsmFeature, source_key
from sloop_ppl.maps.osm._feature_names import address
from sloop_ppl.maps.osm._pieces import Piece
from sloop_ppl.maps.osm.import_report import ImportReport

__all__ = ["Buildings"]

_ON_WALL_M = 0.5
_DOOR_TAGS = ("name", "ref", "addr:street", "addr:housenumber", "addr:unit", "wheelchair")


class Buildings:
    """The buildings of a map in the making, found by place."""

    def __init__(self, pieces: list[Piece]) -> None:
        self.pieces = [p for p in pieces if p.kind == "building" and p.is_area]
        self._tree = shapely.STRtree([p.geometry for p in self.pieces])
        self._areas = np.array([p.geometry.area for p in self.pieces])

    def at(self, geometry: shapely.Geometry) -> Piece | None:
        """Return the smallest building that holds a geometry, or has a point on its wall."""
        held = self._tree.query(geometry, predicate="covered_by")
        if not len(held) and geometry.geom_type == "Point":
            held = self._tree.query(geometry, predicate="dwithin", distance=_ON_WALL_M)
        return self.pieces[held[int(np.argmin(self._areas[held]))]] if len(held) else None

    def take_doors(self, features: list[OsmFeature], lonlat: Any, report: ImportReport) -> None:
        """Keep entrances on the building whose wall they are in, main ones first.

        Features are in metres; `lonlat` converts x and y, metres, to longitude and latitude.
        """
        doors: defaultdict[int, list[tuple[Any, ...]]] = defaultdict(list)
        for feature in features:
            sort = _door(feature.tags)
            if sort is None or feature.geometry.geom_type != "Point":
                continue
            building = self.at(feature.geometry)
            if building is None:
                continue
            lon, lat = lonlat(feature.geometry.x, feature.geometry.y)
            door_tags = {k: feature.tags[k] for k in _DOOR_TAGS if k in feature.tags}
            door = {
                "entrance": sort,
                "lonlat": [round(float(lon), 9), round(float(lat), 9)],
                **door_tags,
            }
            # Main entrances first, then by the number of the node, so that the order is that of no
            # file.
            doors[id(building)].append((sort != "main", source_key(feature.source), door))
            report.entrances += 1
        for building in self.pieces:
            if id(building) in doors:
                kept = sorted(doors[id(building)], key=lambda d: d[:2])
                building.properties["entrances"] = [door for _, _, door in kept]

    def take_addresses(
        self, features: list[OsmFeature], street_of: dict[str, str], report: ImportReport
    ) -> None:
        """Give buildings the addresses of the nodes in them and on their walls.

        A building without a street of its own is on the street of its nodes, when they agree or
        when its main entrance says.
        """
        found: defaultdict[int, list[dict[str, str]]] = defaultdict(list)
        for feature in features:
            tags = _with_street(feature.tags, street_of.get(feature.source))
            if feature.geometry.geom_type == "Point" and _is_address(tags):
                building = self.at(feature.geometry)
                if building is not None:
                    found[id(building)].append(tags)
                    report.addresses += 1
        for building in self.pieces:
            street = next((street_of[s] for s in building.sources if s in street_of), None)
            building.tags = _with_street(building.tags, street)
            _settle(building, found[id(building)])

    def take_places(self, pieces: list[Piece], report: ImportReport) -> list[Piece]:
        """Tell places which building they stand in; return the pieces without those that are it.

        A place that has the name of its building is the building: its tags go to it.
        """
        kept = []
        for piece in pieces:
            building = self.at(piece.geometry) if piece.kind == "poi" else None
            if building is None:
                kept.append(piece)
            elif piece.name and building.name and folded(piece.name) == folded(building.name):
                building.tags = piece.tags | building.tags
                building.sources.append(piece.sources[0])
                report.merged += 1
            else:
                piece.properties["within"] = building
                kept.append(piece)
        return kept


def _door(tags: dict[str, str]) -> str | None:
    sort = tags.get("entrance", "yes" if tags.get("building") == "entrance" else "no")
    return None if sort in ("no", "") else sort


def _is_address(tags: dict[str, str]) -> bool:
    """Tell an address point or a door from a shop, whose address is its own."""
    place = any(key in tags for key in ("amenity", "shop", "office", "tourism", "leisure", "craft"))
    return "addr:housenumber" in tags and not place


def _with_street(tags: dict[str, str], street: str | None) -> dict[str, str]:
    if street is None or "addr:street" in tags:
        return tags
    return tags | {"addr:street": street}


def _settle(building: Piece, found: list[dict[str, str]]) -> None:
    addresses = [text for tags in (building.tags, *found) if (text := address(tags))]
    if found:
        building.properties["addresses"] = list(dict.fromkeys(addresses))
    if "addr:street" not in building.tags:
        streets = Counter(tags["addr:street"] for tags in found if "addr:street" in tags)
        mains = {
            t["addr:street"] for t in found if t.get("entrance") == "main" and "addr:street" in t
        }
        # One street that all nodes name, else the one that the main entrance names.
        agreed = set(streets) if len(streets) == 1 else mains
        if len(agreed) == 1:
            building.tags = building.tags | {"addr:street": next(iter(agreed))}
    numbers = {tags["addr:housenumber"] for tags in found}
    if "addr:housenumber" not in building.tags and len(numbers) == 1:
        building.tags = building.tags | {"addr:housenumber": next(iter(numbers))}
