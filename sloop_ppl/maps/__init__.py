"""Maps: grids, landmarks, city maps, OpenStreetMap, and reading and writing them."""

from sloop_ppl.maps.area import SearchArea, search_area
from sloop_ppl.maps.city import CityMap
from sloop_ppl.maps.fields import LandmarkFields, landmark_fields
from sloop_ppl.maps.files import bundled_maps, check_map_path, load_map, read_map, write_map
from sloop_ppl.maps.find import kind_words
from sloop_ppl.maps.frontage import Facing, Frontage
from sloop_ppl.maps.geojson import from_geojson, to_geojson
from sloop_ppl.maps.grid import Grid
from sloop_ppl.maps.landmark import KINDS, PATH_KINDS, Landmark
from sloop_ppl.maps.rasterise import touched_cells
from sloop_ppl.maps.schema import map_schema
from sloop_ppl.maps.summary import summary

__all__ = [
    "KINDS",
    "PATH_KINDS",
    "CityMap",
    "Facing",
    "Frontage",
    "Grid",
    "Landmark",
    "LandmarkFields",
    "SearchArea",
    "bundled_maps",
    "check_map_path",
    "from_geojson",
    "kind_words",
    "landmark_fields",
    "load_map",
    "map_schema",
    "read_map",
    "search_area",
    "summary",
    "to_geojson",
    "touched_cells",
    "write_map",
]
