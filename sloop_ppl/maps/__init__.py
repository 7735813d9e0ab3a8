"""Maps: grids, landmarks, city maps, OpenStreetMap, and reading and writing them."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from sloop_ppl.maps.blocks import Block
from sloop_ppl.maps.city import CityMap
from sloop_ppl.maps.crossings import Arm, Crossing
from sloop_ppl.maps.fields import LandmarkFields, landmark_fields
from sloop_ppl.maps.files import (
    bundled_maps,
    check_map_path,
    load_map,
    map_names,
    read_map,
    write_map,
)
from sloop_ppl.maps.find import kind_words
from sloop_ppl.maps.frontage import Facing, Frontage
from sloop_ppl.maps.geojson import from_geojson, to_geojson
from sloop_ppl.maps.grid import Grid
from sloop_ppl.maps.house_numbers import HouseNumbers, house_numbers
from sloop_ppl.maps.landmark import KINDS, PATH_KINDS, Landmark
from sloop_ppl.maps.rasterise import touched_cells
from sloop_ppl.maps.street_axes import StreetAxis
from sloop_ppl.maps.street_network import StreetEnd, StreetNetwork, Stretch, street_network
from sloop_ppl.maps.street_tables import (
    EdgeTables,
    StreetTables,
    block_table,
    edge_tables,
    quadrant_table,
    street_tables,
)
from sloop_ppl.maps.summary import summary

if TYPE_CHECKING:
    from sloop_ppl.maps.area import SearchArea, search_area
    from sloop_ppl.maps.schema import map_schema
    from sloop_ppl.maps.street_places import across_street, blocks_of, same_block, street_side
    from sloop_ppl.maps.uneven_grid import UnevenGrid, cells_of_map, log_cells, uneven_fields

# No name of a module here: importing the module would put it in the place of the function.
_LAZY = {
    "SearchArea": "area",
    "across_street": "street_places",
    "blocks_of": "street_places",
    "map_schema": "schema",
    "same_block": "street_places",
    "search_area": "area",
    "street_side": "street_places",
    "UnevenGrid": "uneven_grid",
    "cells_of_map": "uneven_grid",
    "log_cells": "uneven_grid",
    "uneven_fields": "uneven_grid",
}

__all__ = [
    "KINDS",
    "PATH_KINDS",
    "Arm",
    "Block",
    "CityMap",
    "Crossing",
    "EdgeTables",
    "Facing",
    "Frontage",
    "Grid",
    "HouseNumbers",
    "Landmark",
    "LandmarkFields",
    "SearchArea",
    "StreetAxis",
    "StreetEnd",
    "StreetNetwork",
    "StreetTables",
    "Stretch",
    "UnevenGrid",
    "across_street",
    "block_table",
    "blocks_of",
    "bundled_maps",
    "cells_of_map",
    "check_map_path",
    "edge_tables",
    "from_geojson",
    "house_numbers",
    "kind_words",
    "landmark_fields",
    "load_map",
    "log_cells",
    "map_names",
    "map_schema",
    "quadrant_table",
    "read_map",
    "same_block",
    "search_area",
    "street_network",
    "street_side",
    "street_tables",
    "summary",
    "to_geojson",
    "touched_cells",
    "uneven_fields",
    "write_map",
]


def __getattr__(name: str) -> Any:
    """Load what few commands need when it is first asked for."""
    if name not in _LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_LAZY[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
