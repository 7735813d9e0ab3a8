"""OpenStreetMap: read its files, or fetch a place, as maps."""

from sloop_ppl.maps.osm.extent import read_degrees
from sloop_ppl.maps.osm.fetch import fetch_place
from sloop_ppl.maps.osm.importer import import_osm
from sloop_ppl.maps.osm.report import ImportReport

__all__ = ["ImportReport", "fetch_place", "import_osm", "read_degrees"]
