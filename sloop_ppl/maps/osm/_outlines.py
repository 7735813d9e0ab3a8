"""Join what is drawn twice: a way, and the relation of which it is the outline."""

from __future__ import annotations

from collections import defaultdict

import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps._symbols import folded
from sloop_ppl.maps.osm._feature import source_key
from sloop_ppl.maps.osm._pieces import Piece
from sloop_ppl.maps.osm.import_report import ImportReport

__all__ = ["one_of_two"]

Outline = frozenset[tuple[float, float]]


def one_of_two(pieces: list[Piece], report: ImportReport) -> list[Piece]:
    """Return the pieces without areas of ways that a relation of their kind has as an outline.

    The relation, which knows of holes, keeps its geometry and gets the tags it lacks. Two that
    have different names are two.
    """
    ways: defaultdict[tuple[str, Outline], list[Piece]] = defaultdict(list)
    relations = [p for p in pieces if p.is_area and p.sources[0].startswith("relation/")]
    if not relations:
        return pieces
    for piece in pieces:
        if piece.is_area and piece.sources[0].startswith("way/"):
            ways[piece.kind, _outline(piece.geometry)].append(piece)
    gone = set()
    for relation in relations:
        for part in shapely.get_parts(relation.geometry):
            for way in ways.get((relation.kind, _outline(part)), ()):
                if id(way) in gone or _differ(relation.name, way.name):
                    continue
                gone.add(id(way))
                relation.tags = way.tags | relation.tags
                relation.name = relation.name or way.name
                relation.sources = sorted([*relation.sources, *way.sources], key=source_key)
                report.merged += 1
    return [piece for piece in pieces if id(piece) not in gone]


def _outline(area: BaseGeometry) -> Outline:
    """Return the corners of an area's outer rings, in centimetres."""
    rings = shapely.get_exterior_ring(shapely.get_parts(area))
    corners = shapely.get_coordinates(rings).round(2)
    return frozenset((x, y) for x, y in corners.tolist())


def _differ(one: str | None, other: str | None) -> bool:
    return bool(one and other and folded(one) != folded(other))
