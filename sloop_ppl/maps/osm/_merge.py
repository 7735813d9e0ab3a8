"""Join pieces of one name: of a street, of a square, of a river; of a shop and its building."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps._shapes import parts_of_dimension
from sloop_ppl.maps._symbols import folded
from sloop_ppl.maps.landmark import PATH_KINDS
from sloop_ppl.maps.osm._feature import source_key
from sloop_ppl.maps.osm._pieces import Piece
from sloop_ppl.maps.osm.import_report import ImportReport

__all__ = ["merge_pieces"]

_JOINED_AREAS = {"square", "park", "water", "pedestrian", "service"}
# Ways that run along a street and bear its name, but are not it.
_BESIDE = {"sidewalk", "crossing", "traffic_island"}
# A line is part of an area when this share of it runs within the area, widened by _REACH_M.
_INSIDE_SHARE = 0.8
_REACH_M = 5.0


def merge_pieces(pieces: list[Piece], report: ImportReport) -> list[Piece]:
    """Return the pieces with those of one name joined.

    All lines of a name become one street, its kind the most road-like there is among them; a line
    that runs within an area of its name becomes part of that area, and an area along a line of its
    name becomes part of the line's landmark. Squares, parks and waters of one name and kind become
    one. Buildings, car parks and places are never joined.
    """
    named: defaultdict[str, list[Piece]] = defaultdict(list)
    rest: list[Piece] = []
    for piece in pieces:
        joins = piece.is_line or (piece.is_area and piece.kind in _JOINED_AREAS)
        (named[folded(piece.name)] if joins and piece.name else rest).append(piece)
    for group in named.values():
        rest += _joined(group)
    report.merged += len(pieces) - len(rest)
    return sorted(rest, key=lambda piece: source_key(piece.sources[0]))


def _joined(group: list[Piece]) -> list[Piece]:
    lines = [p for p in group if p.is_line]
    areas = _by_kind(p for p in group if p.is_area)
    found = []
    for sort in ("path", "water"):
        alike = [p for p in lines if (p.kind in PATH_KINDS) == (sort == "path")]
        if not alike:
            continue
        line = _one_line(alike)
        kinds = ("square", "pedestrian", "service", "park") if sort == "path" else ("water",)
        near = [a for a in areas if a.kind in kinds]
        host = next((a for a in near if _runs_within(line, a.geometry)), None)
        if host is not None:
            _absorb(host, line)
            continue
        for area in [a for a in near if a.kind in ("pedestrian", "service")]:
            _absorb(line, area)
            areas.remove(area)
        found.append(line)
    return found + areas


def _one_line(lines: list[Piece]) -> Piece:
    kind = next(
        k for k in ("street", "pedestrian", "service", "water") if any(p.kind == k for p in lines)
    )
    along = [p for p in lines if p.tags.get("footway") not in _BESIDE] or lines
    first = max((p for p in along if p.kind == kind), key=lambda p: p.geometry.length, default=None)
    chief = first or max(along, key=lambda p: p.geometry.length)
    joined = shapely.line_merge(shapely.union_all([p.geometry for p in along]))
    geometry = parts_of_dimension(joined, 1)
    return _union(lines, chief, chief.geometry if geometry is None else geometry)


def _by_kind(areas: Iterable[Piece]) -> list[Piece]:
    kinds: defaultdict[str, list[Piece]] = defaultdict(list)
    for area in areas:
        kinds[area.kind].append(area)
    found = []
    for alike in kinds.values():
        chief = max(alike, key=lambda p: p.geometry.area)
        if len(alike) == 1:
            found.append(chief)
            continue
        joined = parts_of_dimension(shapely.union_all([p.geometry for p in alike]), 2)
        found.append(_union(alike, chief, chief.geometry if joined is None else joined))
    return found


def _union(pieces: list[Piece], chief: Piece, geometry: BaseGeometry) -> Piece:
    sources = sorted({s for p in pieces for s in p.sources}, key=source_key)
    every: dict[str, str] = {}
    for piece in pieces:
        for key, value in piece.tags.items():
            every.setdefault(key, value)
    # All names count, of other tags those of the largest piece alone.
    names = {k: v for k, v in every.items() if "name" in k}
    return Piece(sources, chief.kind, chief.word, chief.name, names | chief.tags, geometry)


def _absorb(host: Piece, guest: Piece) -> None:
    host.sources = sorted({*host.sources, *guest.sources}, key=source_key)
    host.tags = {k: v for k, v in guest.tags.items() if "name" in k} | host.tags


def _runs_within(line: Piece, area: BaseGeometry) -> bool:
    inside = shapely.intersection(line.geometry, area.buffer(_REACH_M)).length
    return bool(inside >= _INSIDE_SHARE * line.geometry.length)
