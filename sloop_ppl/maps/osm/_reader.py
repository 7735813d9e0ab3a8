"""Read the tagged shapes of an OpenStreetMap file, through pyosmium."""

from __future__ import annotations

import json
import re
import tempfile
from collections.abc import Collection
from pathlib import Path
from typing import Any

from sloop_ppl.errors import MapError
from sloop_ppl.maps.osm._collector import Collector
from sloop_ppl.maps.osm._elements import Elements, overpass_elements, xml_elements
from sloop_ppl.maps.osm._feature import OsmData
from sloop_ppl.maps.osm._form import JSON_FORM, content, form_of, holds
from sloop_ppl.maps.osm._ordered import NotInOrder, ordered_copy
from sloop_ppl.maps.osm._tagged_geojson import read_tagged
from sloop_ppl.maps.osm._unreadable import unreadable
from sloop_ppl.maps.osm._window import Bounds
from sloop_ppl.maps.osm.import_report import ImportReport

__all__ = ["file_bounds", "read_osm"]

# A node of a way that has its coordinates with it, as Overpass writes for `out geom`.
_PLACED = re.compile(rb"<nd\b[^>]*\slat=")
# libosmium refuses the coordinates that Overpass writes into members, and bounds into ways.
_NESTED = re.compile("element inside <(member|way|relation)>|Unknown element in <(way|relation)>")
# What editors and histories write at what is there no more, which libosmium reads in order only.
_GONE = re.compile(rb"""\svisible=["']false""")
_TO_DELETE = re.compile(rb"""\saction=["']delete""")
# What Overpass adds when a query ran out of time or memory: the file then ends early.
_REMARK = re.compile(r"<remark>\s*(.*?)\s*</remark>", re.DOTALL)
# Share of the ways or relations that may lack their nodes.
_LOST_SHARE = 0.1


class _PlacedInWays(Exception):
    """The coordinates of a file's ways are in the ways."""


def file_bounds(path: Path) -> Bounds | None:
    """Return the bounds that the header of a file states; None when it states none of use.

    Raises
    ------
    MapError
        When the file cannot be read as OpenStreetMap.
    """
    import osmium

    form = form_of(path)
    if form == JSON_FORM:
        return None
    try:
        source = osmium.io.File(str(path), form)
        with osmium.io.Reader(source, osmium.osm.osm_entity_bits.NOTHING) as reader:
            box = reader.header().box()
            if not box.valid():
                return None
            low, high = box.bottom_left, box.top_right
            west, east = low.lon, high.lon
            # libosmium puts the lesser longitude first, also of bounds across longitude 180.
            if east - west > 180:
                west, east = east, west
            return (west, low.lat, east, high.lat) if west != east and low.lat < high.lat else None
    except Exception as error:  # libosmium raises RuntimeError and kinds of its own
        raise unreadable(path, error) from None


def read_osm(
    path: Path, bounds: Bounds | None, report: ImportReport, allow_incomplete: bool = False
) -> OsmData:
    """Read the tagged nodes, ways and multipolygons that reach into some bounds.

    Parameters
    ----------
    path
        OpenStreetMap XML, a change file, ``.osm.pbf``, Overpass JSON or GeoJSON with tags; the
        content tells which, not the suffix.
    bounds
        What to keep, degrees; everything when None.
    allow_incomplete
        Go on when much is lost for want of nodes.

    Raises
    ------
    MapError
        When the file cannot be read, has a coordinate that is not on earth, or is incomplete.
    """
    form = form_of(path)
    with tempfile.TemporaryDirectory() as folder:
        try:
            if form == JSON_FORM:
                data = _read_json(path, Path(folder), bounds, report, allow_incomplete)
            else:
                data = _read_osmium(path, form, Path(folder), bounds, report)
        except MapError:
            raise
        except Exception as error:  # libosmium raises RuntimeError and kinds of its own
            raise unreadable(path, error) from None
    if not allow_incomplete:
        _check_complete(path, report)
        if form.startswith("osm") and path.stat().st_size < 1 << 28:
            _check_remark(path, _REMARK.search(_end(path)))
    return data


def _read_osmium(
    path: Path, form: str, folder: Path, bounds: Bounds | None, report: ImportReport
) -> OsmData:
    import osmium

    source = osmium.io.File(str(path), form)
    xml = form.startswith("osm")
    if xml and holds(path, _TO_DELETE):
        return _from_xml(path, folder, bounds, report)
    try:
        # The parts of a change file are by what was done to them, not by sort.
        if not (_has_versions(source, form) or (xml and holds(path, _GONE))):
            return _collected(source, path, form, bounds, report)
    except (RuntimeError, _PlacedInWays, NotInOrder) as error:
        if isinstance(error, NotInOrder) or "out of order" in str(error):
            pass
        elif isinstance(error, _PlacedInWays) or _NESTED.search(str(error)):
            return _from_xml(path, folder, bounds, report)
        else:
            raise
    report.restart()
    try:
        copy, report.duplicates = ordered_copy(source, folder)
        return _collected(copy, path, form, bounds, report)
    except (RuntimeError, _PlacedInWays) as error:
        if isinstance(error, RuntimeError) and not _NESTED.search(str(error)):
            raise
        return _from_xml(path, folder, bounds, report)


def _has_versions(source: Any, form: str) -> bool:
    """Tell whether a file is a change file, or a history."""
    import osmium

    with osmium.io.Reader(source, osmium.osm.osm_entity_bits.NOTHING) as reader:
        return form.startswith("osc") or reader.header().has_multiple_object_versions


def _from_xml(path: Path, folder: Path, bounds: Bounds | None, report: ImportReport) -> OsmData:
    report.restart()
    return _from_elements(xml_elements(content(path), path), folder, bounds, report)


def _collected(
    source: Any, path: Path, form: str, bounds: Bounds | None, report: ImportReport
) -> OsmData:
    import osmium

    found = Collector(path, bounds, report)
    objects = osmium.FileProcessor(source).with_locations().with_areas()
    for thing in objects.with_filter(osmium.filter.EmptyTagFilter()):
        found.take(thing)
    data = found.data(source)
    if found.lost_nodes and _holds_any(source, found.lost_nodes):
        raise NotInOrder
    wants = found.lost_nodes or report.incomplete
    if wants and form.startswith("osm") and holds(path, _PLACED):
        raise _PlacedInWays
    return data


def _holds_any(source: Any, nodes: Collection[int]) -> bool:
    """Tell whether a file holds any of some nodes, which then come after the ways they are of."""
    import osmium

    found = osmium.FileProcessor(source, osmium.osm.NODE)
    return any(True for _ in found.with_filter(osmium.filter.IdFilter(nodes)))


def _from_elements(
    elements: Elements, folder: Path, bounds: Bounds | None, report: ImportReport
) -> OsmData:
    copy = folder / "elements.osm.pbf"
    elements.write(copy)
    report.duplicates = elements.duplicates
    return _collected(str(copy), elements.called, "pbf", bounds, report)


def _read_json(
    path: Path, folder: Path, bounds: Bounds | None, report: ImportReport, allow_incomplete: bool
) -> OsmData:
    try:
        data = json.loads(content(path))
    except (ValueError, RecursionError) as error:
        raise MapError(f"File '{path}' cannot be read as JSON: {error}") from None
    if isinstance(data, dict) and isinstance(data.get("elements"), list):
        if not allow_incomplete and data.get("remark"):
            _check_remark(path, re.search("(.*)", str(data["remark"]), re.DOTALL))
        return _from_elements(overpass_elements(data, path), folder, bounds, report)
    return read_tagged(data, path, bounds, report)


def _check_complete(path: Path, report: ImportReport) -> None:
    for sort, lost, read, want in (
        ("ways", report.lost_ways, report.ways, "nodes"),
        ("relations", report.lost_relations, report.relations, "ways or their nodes"),
    ):
        if lost > _LOST_SHARE * read:
            raise MapError(
                f"File '{path}' lacks {want} of {lost} of its {read} {sort}, which cannot be drawn "
                "without; export them too (in Overpass `out geom;` or `(._;>;); out body;`), or "
                "give --allow-incomplete (allow_incomplete=True) to import what is there"
            )


def _check_remark(path: Path, remark: re.Match[str] | None) -> None:
    if remark is not None and "error" in remark[1].casefold():
        words = " ".join(remark[1].split())
        raise MapError(
            f"File '{path}' ends early, the server says: {words[:160]}; export it again, or give "
            "--allow-incomplete (allow_incomplete=True) to import what is there"
        )


def _end(path: Path) -> str:
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - 4096))
        return file.read().decode("utf-8", "replace")
