"""Put the objects of an OpenStreetMap file in order, which libosmium asks for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

__all__ = ["ordered_copy"]


def ordered_copy(path: Path, folder: Path) -> tuple[Path, int]:
    """Write a copy with nodes, ways and relations by number, the newest version of each.

    Parameters
    ----------
    path : the file.
    folder : where to write the copy.

    Returns
    -------
    tuple
        The copy, and how many objects the file holds more than once.
    """
    import osmium

    copy = folder / "ordered.osm.pbf"
    reader = osmium.MergeInputReader()
    reader.add_file(str(path))
    with osmium.SimpleWriter(str(copy)) as writer:
        newest = _Newest(writer)
        reader.apply(newest, simplify=True)
    return copy, sum(1 for _ in osmium.FileProcessor(str(path))) - newest.count


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
