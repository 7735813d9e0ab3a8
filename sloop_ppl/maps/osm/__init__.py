"""OpenStreetMap: read its files, or fetch a place, as maps."""

from sloop_ppl.maps.osm.extent import read_degrees
from sloop_ppl.maps.osm.fetch import fetch_place
from sloop_ppl.maps.osm.import_report import ImportReport
from sloop_ppl.maps.osm.importer import import_osm

__all__ = ["ImportReport", "fetch_place", "import_osm", "read_degrees"]
