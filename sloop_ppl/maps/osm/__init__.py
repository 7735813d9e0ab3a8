"""OpenStreetMap: read its files, or fetch a place, as maps."""

from sloop_ppl.maps.osm.importer import import_osm
from sloop_ppl.maps.osm.report import ImportReport

__all__ = ["ImportReport", "import_osm"]
