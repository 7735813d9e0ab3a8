"""Make areas of multipolygon relations that libosmium refuses, because their rings cross."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps._shapes import parts_of_dimension
from sloop_ppl.maps.osm._feature import OsmFeature
from sloop_ppl.maps.osm.import_report import ImportReport

__all__ = ["Unmade", "mended"]

Unmade = tuple[dict[str, str], tuple[tuple[int, str], ...]]
"""Tags of a relation, and the id and role of each way that is a member."""


def mended(path: Path, relations: Mapping[str, Unmade], report: ImportReport) -> list[OsmFeature]:
    """Return areas, in degrees, of the relations all of whose ways the file holds.

    What the outer ways enclose is taken, less what the inner ways enclose. The report counts the
    relations that are incomplete, repaired and broken.
    """
    if not relations:
        return []
    lines = _lines(path, {ref for _, members in relations.values() for ref, _ in members})
    found = []
    for source, (tags, members) in relations.items():
        if not members or not all(ref in lines for ref, _ in members):
            report.incomplete += 1
            continue
        holes = _enclosed(lines[ref] for ref, role in members if role == "inner")
        outer = _enclosed(lines[ref] for ref, role in members if role != "inner")
        area = parts_of_dimension(shapely.difference(outer, holes), 2)
        if area is None:
            report.broken.append(source)
        else:
            report.repaired.append(source)
            found.append(OsmFeature(source, tags, area))
    return found


def _lines(path: Path, wanted: set[int]) -> dict[int, BaseGeometry]:
    """Return the ways of these ids that have all of their nodes."""
    import osmium

    ways = osmium.FileProcessor(str(path)).with_locations()
    ways = ways.with_filter(osmium.filter.EntityFilter(osmium.osm.WAY))
    lines = {}
    way: Any
    for way in ways.with_filter(osmium.filter.IdFilter(wanted)):
        if len(way.nodes) >= 2 and all(ref.location.valid() for ref in way.nodes):
            lines[way.id] = shapely.LineString([(ref.lon, ref.lat) for ref in way.nodes])
    return lines


def _enclosed(lines: Iterable[BaseGeometry]) -> BaseGeometry:
    """Return what lines enclose, whatever way they cross."""
    noded = shapely.union_all(list(lines))
    faces: BaseGeometry = shapely.union_all(shapely.get_parts(shapely.polygonize([noded])))
    return faces
