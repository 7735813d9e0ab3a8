"""Write nodes, ways and relations that have their coordinates in them as a file of libosmium."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from sloop_ppl.errors import MapError
from sloop_ppl.maps.osm._ordered import above_zero

__all__ = ["Elements", "Place", "overpass_elements", "xml_elements"]

Place = tuple[float, float]
"""Longitude and latitude, degrees."""

# Nodes that only have coordinates get ids above all real and all drawn ones.
_NAMELESS = 1 << 42
_LETTER = {"node": "n", "way": "w", "relation": "r"}


class Elements:
    """Nodes, ways and relations in any order, each perhaps more than once.

    Parameters
    ----------
    called
        The file they come from, for messages.
    """

    def __init__(self, called: Path) -> None:
        self.called = called
        self.duplicates = 0
        self._nodes: dict[int, tuple[Place, dict[str, str]]] = {}
        self._ways: dict[int, tuple[list[int], dict[str, str]]] = {}
        self._relations: dict[int, tuple[list[tuple[str, int, str]], dict[str, str]]] = {}
        self._at: dict[Place, int] = {}

    def node(self, number: int, place: Place, tags: dict[str, str]) -> None:
        """Take a node; tags of one that came before are kept."""
        before = self._nodes.get(number, (place, {}))[1]
        self.duplicates += bool(before and tags)
        self._nodes[number] = self._on_earth(place, f"node/{number}"), before | tags

    def way(
        self,
        number: int,
        refs: Sequence[int | None],
        places: Sequence[Place | None],
        tags: dict[str, str],
    ) -> None:
        """Take a way; where a place is given it is that of the node beside it."""
        source = f"way/{number}"
        nodes = []
        for i in range(max(len(refs), len(places))):
            ref = refs[i] if i < len(refs) else None
            place = places[i] if i < len(places) else None
            if place is not None:
                place = self._on_earth(place, source)
                if ref is None:
                    ref = self._at.setdefault(place, _NAMELESS + len(self._at))
                self._nodes.setdefault(ref, (place, {}))
            if ref is not None:
                nodes.append(ref)
        known, before = self._ways.get(number, ([], {}))
        self.duplicates += bool(before and tags)
        # Overpass prints an element twice when asked for its tags and its nodes apart.
        self._ways[number] = nodes or known, before | tags

    def relation(
        self, number: int, members: list[tuple[str, int, str]], tags: dict[str, str]
    ) -> None:
        """Take a relation, its members as letter, id and role."""
        known, before = self._relations.get(number, ([], {}))
        self.duplicates += bool(before and tags)
        self._relations[number] = members or known, before | tags

    def member_way(self, number: int, places: Sequence[Place | None]) -> None:
        """Take the course of a way that a relation tells."""
        if not self._ways.get(number, ([], {}))[0]:
            self.way(number, [], places, {})

    def write(self, path: Path) -> None:
        """Write them in order, ids above zero."""
        import osmium
        from osmium.osm import mutable

        with osmium.SimpleWriter(str(path)) as writer:
            for number, (place, tags) in _by_id(self._nodes):
                writer.add_node(mutable.Node(id=number, version=1, location=place, tags=tags))
            for number, (nodes, tags) in _by_id(self._ways):
                refs = [above_zero(ref) for ref in nodes]
                writer.add_way(mutable.Way(id=number, version=1, nodes=refs, tags=tags))
            for number, (members, tags) in _by_id(self._relations):
                kept = [(letter, above_zero(ref), role) for letter, ref, role in members]
                writer.add_relation(mutable.Relation(id=number, version=1, members=kept, tags=tags))

    def _on_earth(self, place: Place, source: str) -> Place:
        lon, lat = place
        name = "lat" if not (math.isfinite(lat) and -90 <= lat <= 90) else "lon"
        if name == "lat" or not (math.isfinite(lon) and -180 <= lon <= 180):
            raise MapError(
                f"{self.called}: {source}: field '{name}' of lat {lat:g}, lon {lon:g} is out of "
                "range; expected lat in [-90, 90] and lon in [-180, 180]",
                feature=source,
                field=name,
            )
        return place


def overpass_elements(data: Mapping[str, Any], called: Path) -> Elements:
    """Return what parsed Overpass JSON holds, from any of its ``out`` statements.

    Raises
    ------
    MapError
        When an element is not as Overpass writes it; it is named.
    """
    found = Elements(called)
    for i, element in enumerate(data["elements"]):
        try:
            _take(found, element)
        except MapError:
            raise
        except (TypeError, ValueError, KeyError, AttributeError, OverflowError) as error:
            raise MapError(
                f"{called}: element {i} is not as Overpass writes it: {type(error).__name__} "
                f"{error}; expected 'type', 'id', 'tags' and coordinates",
                feature=f"element {i}",
            ) from None
    return found


def xml_elements(text: bytes, called: Path) -> Elements:
    """Return what OpenStreetMap XML holds that has coordinates in its ways, as ``out geom`` writes.

    Raises
    ------
    MapError
        When it declares entities, which are never expanded.
    """
    if b"<!ENTITY" in text:
        raise MapError(f"File '{called}' declares XML entities, which are not supported")
    found = Elements(called)
    for element in ET.fromstring(text):
        if element.get("visible") == "false" or element.get("action") == "delete":
            continue
        if element.tag not in _LETTER:
            continue
        tags = {t.get("k", ""): t.get("v", "") for t in element.iter("tag")}
        number = int(element.get("id", ""))
        if element.tag == "node":
            if (place := _xml_place(element)) is not None:
                found.node(number, place, tags)
        elif element.tag == "way":
            ends = element.findall("nd")
            refs = [int(nd.get("ref", "")) if nd.get("ref") else None for nd in ends]
            found.way(number, refs, [_xml_place(nd) for nd in ends], tags)
        else:
            members = []
            for member in element.findall("member"):
                sort, ref = member.get("type", ""), int(member.get("ref", ""))
                members.append((_LETTER[sort], ref, member.get("role", "")))
                course = [_xml_place(nd) for nd in member.findall("nd")]
                if sort == "way" and any(course):
                    found.member_way(ref, course)
            found.relation(number, members, tags)
    return found


def _take(found: Elements, element: Mapping[str, Any]) -> None:
    sort = element["type"]
    if sort not in _LETTER:  # "count", "timeline", areas of Overpass's own
        return
    if element.get("visible") is False:
        return
    number = _id(element["id"])
    tags = {_text(k): _text(v) for k, v in (element.get("tags") or {}).items()}
    if sort == "node":
        place = _place(element) if "lat" in element else None
        if place is not None:
            found.node(number, place, tags)
    elif sort == "way":
        places = [_place(p) for p in element.get("geometry") or ()]
        found.way(number, [_id(ref) for ref in element.get("nodes") or ()], places, tags)
    else:
        members = []
        for member in element.get("members") or ():
            letter, ref = _LETTER[member["type"]], _id(member["ref"])
            members.append((letter, ref, _text(member.get("role", ""))))
            if letter == "w" and member.get("geometry"):
                found.member_way(ref, [_place(p) for p in member["geometry"]])
        found.relation(number, members, tags)


def _id(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError(f"id {value!r:.40}")  # noqa: TRY004  # one kind for all of a bad element
    if abs(value) >= 1 << 40:
        raise ValueError(f"id {value!r:.40}")
    return value


def _text(value: Any) -> str:
    if not isinstance(value, str | int | float):
        raise ValueError(f"value {value!r:.40}")  # noqa: TRY004
    text = str(value)
    # libosmium keeps texts up to a NUL, and would read beyond its memory for what follows.
    if "\0" in text:
        raise ValueError(f"value {text!r:.40}")
    text.encode()  # half a character is a UnicodeEncodeError, which is a ValueError
    return text


def _place(value: Mapping[str, Any] | None) -> Place | None:
    # Overpass writes null for what lies outside the box of `out geom(box)`.
    return None if value is None else (float(value["lon"]), float(value["lat"]))


def _xml_place(element: ET.Element) -> Place | None:
    lon, lat = element.get("lon"), element.get("lat")
    return None if lon is None or lat is None else (float(lon), float(lat))


def _by_id(things: Mapping[int, Any]) -> Iterable[tuple[int, Any]]:
    return sorted((above_zero(number), thing) for number, thing in things.items())
