"""Put an OpenStreetMap file into the form libosmium asks for: in order, ids above zero."""

from __future__ import annotations

from pathlib import Path
from typing import Any

__all__ = ["NotInOrder", "above_zero", "drawn_id", "ordered_copy"]

# Editors give what has not been uploaded ids below zero; they become ids above all real ones.
_DRAWN = 1 << 40


class NotInOrder(Exception):
    """A file has to be copied by `ordered_copy` before it can be read."""


def drawn_id(number: int) -> int:
    """Return the id that an object had in the file, given its id in an ordered copy."""
    return number if number < _DRAWN else _DRAWN - number


def ordered_copy(source: Any, folder: Path) -> tuple[Path, int]:
    """Write a copy with nodes, ways and relations by number, the newest version of each.

    `source` is a path or an `osmium.io.File`. Return the copy, and how many objects the file
    holds more than once.
    """
    import osmium

    above, copy = folder / "above.osm.pbf", folder / "ordered.osm.pbf"
    count = 0
    with osmium.SimpleWriter(str(above)) as writer:
        for thing in osmium.FileProcessor(source):
            count += 1
            _write_above_zero(writer, thing)
    # simplify=True keeps the newest version of each; what is left is sorted by type and id.
    reader = osmium.MergeInputReader()
    reader.add_file(str(above))
    with osmium.SimpleWriter(str(copy)) as writer:
        newest = _Newest(writer)
        reader.apply(newest, simplify=True)
    return copy, count - newest.count


def above_zero(number: int) -> int:
    """Return the id that an object has in an ordered copy."""
    return number if number >= 0 else _DRAWN - number


def _write_above_zero(writer: Any, thing: Any) -> None:
    number = above_zero(thing.id)
    if thing.is_way():
        nodes = [above_zero(ref.ref) for ref in thing.nodes]
        writer.add_way(thing.replace(id=number, nodes=nodes))
    elif thing.is_relation():
        members = [(m.type, above_zero(m.ref), m.role) for m in thing.members]
        writer.add_relation(thing.replace(id=number, members=members))
    else:
        writer.add_node(thing.replace(id=number))


class _Newest:
    """Passes objects on to a writer, which leaves out those that have been deleted."""

    def __init__(self, writer: Any) -> None:
        self.writer, self.count = writer, 0

    def node(self, node: Any) -> None:
        self._pass(node, self.writer.add_node)

    def way(self, way: Any) -> None:
        self._pass(way, self.writer.add_way)

    def relation(self, relation: Any) -> None:
        self._pass(relation, self.writer.add_relation)

    def _pass(self, thing: Any, add: Any) -> None:
        self.count += 1
        if not thing.deleted:
            add(thing)
