"""Make areas of multipolygon relations that libosmium refuses, because their rings cross."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps._shapes import parts_of_dimension
from sloop_ppl.maps.osm._feature import OsmFeature
from sloop_ppl.maps.osm.import_report import ImportReport

__all__ = ["Unmade", "mended"]

Unmade = tuple[dict[str, str], tuple[tuple[int, str], ...]]
"""Tags of a relation, and the id and role of each way that is a member."""


def mended(
    source: Any, relations: Mapping[str, Unmade], lost_nodes: set[int], report: ImportReport
) -> list[OsmFeature]:
    """Return areas, in degrees, of the relations all of whose ways the file holds.

    What the outer ways enclose is taken, less what the inner ways enclose. The report counts the
    relations that are incomplete, repaired and broken; nodes that their ways lack are added to
    `lost_nodes`.
    """
    if not relations:
        return []
    wanted = {ref for _, members in relations.values() for ref, _ in members}
    lines, begun = _lines(source, wanted, lost_nodes)
    found = []
    for relation, (tags, members) in relations.items():
        if not members or not all(ref in lines for ref, _ in members):
            report.incomplete += 1
            # What crosses the border of an extract is there in part; what was exported without its
            # nodes is not there at all.
            report.lost_relations += not any(ref in lines or ref in begun for ref, _ in members)
            continue
        holes = _enclosed(lines[ref] for ref, role in members if role == "inner")
        outer = _enclosed(lines[ref] for ref, role in members if role != "inner")
        area = parts_of_dimension(shapely.difference(outer, holes), 2)
        if area is None:
            report.broken.append(relation)
        else:
            report.repaired.append(relation)
            found.append(OsmFeature(relation, tags, area))
    return found


def _lines(
    source: Any, wanted: set[int], lost_nodes: set[int]
) -> tuple[dict[int, BaseGeometry], set[int]]:
    """Return the ways of these ids that have all of their nodes, and ids of those with some."""
    import osmium

    ways = osmium.FileProcessor(source).with_locations()
    ways = ways.with_filter(osmium.filter.EntityFilter(osmium.osm.WAY))
    lines, begun = {}, set()
    way: Any
    for way in ways.with_filter(osmium.filter.IdFilter(wanted)):
        missing = [ref.ref for ref in way.nodes if not ref.location.valid()]
        lost_nodes.update(missing)
        if missing and len(missing) < len(way.nodes):
            begun.add(way.id)
        elif not missing and len(way.nodes) >= 2:
            lines[way.id] = shapely.LineString([(ref.lon, ref.lat) for ref in way.nodes])
    return lines, begun


def _enclosed(lines: Iterable[BaseGeometry]) -> BaseGeometry:
    """Return what lines enclose, whatever way they cross."""
    noded = shapely.union_all(list(lines))
    faces: BaseGeometry = shapely.union_all(shapely.get_parts(shapely.polygonize([noded])))
    return faces
