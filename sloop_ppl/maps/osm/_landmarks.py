"""Turn pieces into landmarks: ids, aliases, widths, heights, kept tags."""

from __future__ import annotations

from collections import Counter
from types import MappingProxyType
from typing import Any

from sloop_ppl.maps._symbols import camel_case, unique
from sloop_ppl.maps.landmark import KINDS, Landmark
from sloop_ppl.maps.osm._feature import source_key
from sloop_ppl.maps.osm._feature_names import aliases, local_languages
from sloop_ppl.maps.osm._measures import height_m, road_width_m, unread
from sloop_ppl.maps.osm._pieces import Piece
from sloop_ppl.maps.osm.import_report import ImportReport

__all__ = ["KEPT_TAGS", "landmarks_of"]

KEPT_TAGS = (
    "amenity", "shop", "cuisine", "tourism", "leisure", "office", "craft", "healthcare", "historic",
    "religion", "denomination", "sport", "vending", "information", "artwork_type", "memorial",
    "building", "building:levels", "building:colour", "building:material", "roof:colour",
    "roof:shape", "height", "colour", "material", "highway", "service", "footway", "oneway",
    "lanes", "width", "surface", "bridge", "layer", "level", "ref", "place", "landuse", "natural",
    "water", "waterway", "railway", "public_transport", "man_made", "aeroway", "brand", "operator",
    "addr:street", "addr:housenumber", "addr:unit", "addr:postcode", "addr:city",
)  # fmt: skip
"""Tags of OpenStreetMap that a landmark keeps as properties."""


def landmarks_of(pieces: list[Piece], report: ImportReport) -> tuple[Landmark, ...]:
    """Return the landmarks of pieces, by kind and then by the number of their source.

    Ids are CamelCase symbols of names, numbered from 2 when several landmarks have the same;
    nameless ones are called by what they are and numbered from 1. The report lists heights and
    widths that cannot be read.
    """
    ordered = sorted(pieces, key=lambda p: (KINDS.index(p.kind), source_key(p.sources[0])))
    ids = _ids(ordered)
    for piece in ordered:
        if piece.kind == "building" or piece.is_line:
            tags = unread(piece.tags, is_building=piece.kind == "building")
            report.unread += [f"{piece.sources[0]} {tag}" for tag in tags]
    languages = local_languages(p.tags for p in ordered if p.name)
    return tuple(_landmark(p, ids, languages) for p in ordered)


def _ids(pieces: list[Piece]) -> dict[int, str]:
    ids: dict[int, str] = {}
    taken: set[str] = set()
    for piece in pieces:
        if symbol := camel_case(_shortened(piece)):
            ids[id(piece)] = unique(symbol, taken)
            taken.add(ids[id(piece)])
    numbers: Counter[str] = Counter()
    for piece in pieces:
        while id(piece) not in ids:
            numbers[piece.word] += 1
            symbol = f"{piece.word}{numbers[piece.word]}"
            if symbol not in taken:
                ids[id(piece)] = symbol
                taken.add(symbol)
    return ids


def _shortened(piece: Piece) -> str:
    """Return a name with a final "Street" as "St", as the bundled maps have it."""
    name = piece.name or ""
    return f"{name[:-6]}St" if piece.kind == "street" and name.endswith(" Street") else name


def _landmark(piece: Piece, ids: dict[int, str], languages: tuple[str, ...]) -> Landmark:
    tags = piece.tags
    properties: dict[str, Any] = {key: tags[key] for key in KEPT_TAGS if key in tags}
    if piece.kind == "building":
        if (height := height_m(tags)) is not None:
            properties["height_m"] = height
        if "addr:housenumber" in tags:
            properties["house_number"] = tags["addr:housenumber"]
    within = piece.properties.get("within")
    properties |= {k: v for k, v in piece.properties.items() if k != "within"}
    properties["osm"] = piece.sources
    others = aliases(tags, piece.name, languages)
    addresses = [a for a in piece.properties.get("addresses", ()) if a not in others]
    return Landmark(
        id=ids[id(piece)],
        kind=piece.kind,
        geometry=piece.geometry,
        name=piece.name,
        aliases=(*others, *(a for a in addresses if a != piece.name)),
        within=None if within is None else ids[id(within)],
        width_m=road_width_m(tags) if piece.is_line else None,
        properties=MappingProxyType(properties),
    )
