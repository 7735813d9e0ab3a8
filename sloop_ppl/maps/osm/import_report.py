"""Say what an import kept, mended and left out."""

from __future__ import annotations

from dataclasses import dataclass, field

__all__ = ["ImportReport"]


@dataclass
class ImportReport:
    """What happened to the features of an OpenStreetMap file; the importer counts as it goes.

    Parameters
    ----------
    read
        Nodes, ways and relations with tags that were read.
    kept
        Landmarks by kind.
    merged
        Pieces that became part of another landmark: of a street of the same name, of the building a
        place of the same name stands in.
    repaired
        Sources of areas whose outline crossed itself and was repaired.
    broken
        Sources of areas and relations that no area could be made of.
    incomplete
        Relations of which the file lacks a member.
    cut_short
        Ways of which the file lacks a node; they are kept without it.
    no_coordinates
        Ways of none of whose nodes the file has a place, left out.
    ways, relations
        Ways with tags and multipolygons that were read.
    lost_ways, lost_relations
        Those among them that cannot be drawn for want of nodes.
    beyond_m
        How far the patch reaches beyond what the file covers, metres by side of it.
    duplicates
        Objects that the file holds twice; the newest version is kept.
    underground
        Features below ground, left out.
    outside
        Features outside the extent, left out.
    of_no_kind
        Features of no kind that a landmark can have, left out.
    unread
        Heights, levels and widths that could not be read, each with its source.
    entrances, addresses
        How many were attached to buildings.
    """

    read: int = 0
    kept: dict[str, int] = field(default_factory=dict)
    merged: int = 0
    repaired: list[str] = field(default_factory=list)
    broken: list[str] = field(default_factory=list)
    incomplete: int = 0
    cut_short: int = 0
    no_coordinates: int = 0
    ways: int = 0
    relations: int = 0
    lost_ways: int = 0
    lost_relations: int = 0
    beyond_m: dict[str, float] = field(default_factory=dict)
    duplicates: int = 0
    underground: int = 0
    outside: int = 0
    of_no_kind: int = 0
    unread: list[str] = field(default_factory=list)
    entrances: int = 0
    addresses: int = 0

    def restart(self) -> None:
        """Forget what has been counted."""
        vars(self).update(vars(ImportReport()))

    def lines(self) -> list[str]:
        """Return the report as short lines, nothing said of what did not occur."""
        kinds = ", ".join(f"{n} {kind}" for kind, n in self.kept.items())
        lines = [f"kept {sum(self.kept.values())} landmarks: {kinds}"]
        lines += [
            f"{text}: {count}"
            for text, count in (
                ("entrances on buildings", self.entrances),
                ("addresses on buildings", self.addresses),
                ("pieces merged into another landmark", self.merged),
                ("left out, of no kind a landmark can have", self.of_no_kind),
                ("left out, below ground", self.underground),
                ("left out, outside the extent", self.outside),
                ("left out, without coordinates in the file", self.no_coordinates),
                ("twice in the file, newest version kept", self.duplicates),
                ("ways without some of their nodes, kept without them", self.cut_short),
                ("relations without all of their members, left out", self.incomplete),
            )
            if count
        ]
        lines += [
            f"{text}: {len(sources)} ({', '.join(sources[:4])}{', …' if sources[4:] else ''})"
            for text, sources in (
                ("outlines that cross themselves, repaired", self.repaired),
                ("areas that enclose nothing, left out", self.broken),
                ("heights, levels and widths that cannot be read", self.unread),
            )
            if sources
        ]
        if self.beyond_m:
            sides = ", ".join(f"{metres:.0f} m {side}" for side, metres in self.beyond_m.items())
            lines.append(f"the patch reaches beyond the file, where nothing is known: {sides}")
        return lines
