"""Maps: grids, landmarks, city maps, and reading and writing them."""

from sloop_ppl.maps.bundled import bundled_maps, load_map
from sloop_ppl.maps.city import CityMap
from sloop_ppl.maps.fields import LandmarkFields, landmark_fields
from sloop_ppl.maps.geojson import from_geojson, read_map, to_geojson, write_map
from sloop_ppl.maps.grid import Grid
from sloop_ppl.maps.landmark import KINDS, PATH_KINDS, Landmark
from sloop_ppl.maps.rasterise import touched_cells

__all__ = [
    "KINDS",
    "PATH_KINDS",
    "CityMap",
    "Grid",
    "Landmark",
    "LandmarkFields",
    "bundled_maps",
    "from_geojson",
    "landmark_fields",
    "load_map",
    "read_map",
    "to_geojson",
    "touched_cells",
    "write_map",
]
