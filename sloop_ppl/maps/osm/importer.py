"""Import an OpenStreetMap file as a map."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import shapely

from sloop_ppl._foreign import is_file
from sloop_ppl.errors import InputError, MapError
from sloop_ppl.maps.city import CityMap
from sloop_ppl.maps.geojson import from_geojson, to_geojson
from sloop_ppl.maps.grid import Grid
from sloop_ppl.maps.osm._buildings import Buildings
from sloop_ppl.maps.osm._coast import sea
from sloop_ppl.maps.osm._feature import OsmData
from sloop_ppl.maps.osm._landmarks import landmarks_of
from sloop_ppl.maps.osm._merge import merge_pieces
from sloop_ppl.maps.osm._outlines import one_of_two
from sloop_ppl.maps.osm._pieces import pieces_of, projected
from sloop_ppl.maps.osm._reader import file_bounds, read_osm
from sloop_ppl.maps.osm._window import Bounds
from sloop_ppl.maps.osm.extent import beyond_m, box_grid, data_grid, grid_bounds, square_grid
from sloop_ppl.maps.osm.import_report import ImportReport

__all__ = ["ATTRIBUTION", "build_map", "import_osm"]

# Where a file states no bounds it ends with its outermost feature; a strip is bare by chance.
_BARE_SHARE = 0.15

ATTRIBUTION = "(c) OpenStreetMap contributors, ODbL 1.0"


def import_osm(
    path: str | Path,
    *,
    centre: Sequence[float] | None = None,
    side_m: float | None = None,
    bbox: Sequence[float] | None = None,
    everything: bool = False,
    cell_m: float = 5.0,
    name: str | None = None,
    allow_incomplete: bool = False,
    progress: Callable[[str], None] | None = None,
) -> tuple[CityMap, ImportReport]:
    """Import a patch of an OpenStreetMap file, offline.

    Parameters
    ----------
    path
        OpenStreetMap XML, a change file or ``.osm.pbf``, compressed or not; Overpass JSON; GeoJSON
        with tags, of overpass-turbo or QGIS. The content tells which, not the suffix.
    centre
        Latitude and longitude of the middle of a square patch, degrees, with `side_m`.
    side_m
        Side of the square, metres.
    bbox
        West, south, east and north of a patch, degrees, instead of `centre` and `side_m`.
    everything
        Take all that is in the file, instead.
    cell_m
        Side of a cell, metres, > 0.
    name
        What to call the map; the file's name up to its first dot when None.
    allow_incomplete
        Go on when over a tenth of the ways or relations is lost for want of nodes.
    progress
        Called with a few words on what is being done.

    Returns
    -------
    tuple
        The map, exactly as it will be read back once it is written, and a report of what was
        merged, repaired and left out.

    Raises
    ------
    InputError
        When the patch is not given in one of the three ways, or a number cannot be used.
    MapError
        When the file cannot be read, is incomplete, or has nothing in the patch.
    """
    file, notify, report = Path(path), progress or (lambda _: None), ImportReport()
    grid = _asked(centre, side_m, bbox, everything, cell_m)
    if not is_file(file):
        raise MapError(f"File '{path}' cannot be read: no such file; expected .osm or .osm.pbf")
    known = file_bounds(file)
    if grid is None and known is not None:
        grid = box_grid(known, cell_m)
    notify(f"reading {file.name}")
    data = read_osm(file, None if grid is None else grid_bounds(grid), report, allow_incomplete)
    if grid is None:
        if data.bounds is None:
            raise MapError(f"File '{path}' holds no tagged feature; expected a piece of a city")
        grid = data_grid(data.bounds, cell_m)
    elif known is not None:
        report.beyond_m = beyond_m(grid, known)
    elif data.bounds is not None:
        report.beyond_m = beyond_m(grid, data.bounds, share=_BARE_SHARE)
    city = build_map(data, grid, name or file.name.split(".")[0], report, notify)
    if not city.landmarks:
        raise MapError(_empty(file, grid, known))
    return city, report


def build_map(
    data: OsmData, grid: Grid, name: str, report: ImportReport, notify: Callable[[str], None]
) -> CityMap:
    """Make a map of features in degrees; `report` counts what happens to them."""
    notify(f"sorting out {len(data.features)} features")
    features = projected(data.features, grid)
    pieces = merge_pieces(one_of_two(pieces_of(features, grid, report), report), report)
    if (water := sea(features, grid)) is not None:
        pieces.append(water)
    notify(f"furnishing {len(pieces)} landmarks")
    buildings = Buildings(pieces)
    buildings.take_doors(features, grid.to_lonlat, report)
    buildings.take_addresses(features, data.street_of, report)
    pieces = buildings.take_places(pieces, report)
    made = CityMap(name, grid, landmarks_of(pieces, report), ATTRIBUTION)
    report.kept = made.counts()
    city = from_geojson(to_geojson(made), source=name)
    # Rounding can make a thin outline cross itself; what was repaired then is rounded once more.
    return city if _corners(city) == _corners(made) else from_geojson(to_geojson(city), source=name)


def _corners(city: CityMap) -> list[int]:
    return [int(shapely.get_num_coordinates(m.geometry)) for m in city.landmarks]


def _asked(
    centre: Sequence[float] | None,
    side_m: float | None,
    bbox: Sequence[float] | None,
    everything: bool,
    cell_m: float,
) -> Grid | None:
    """Return the grid asked for; None for everything, whose extent the file tells."""
    square = centre is not None or side_m is not None
    if square + (bbox is not None) + everything != 1:
        raise InputError(
            "The patch is given in no way or in several; expected one of: a centre and a side_m, "
            "a bbox, everything"
        )
    if everything:
        Grid.square(1.0, cell_m)  # refuses a cell that cannot be used
        return None
    if bbox is not None:
        return box_grid(bbox, cell_m)
    if centre is None or side_m is None:
        raise InputError("centre and side_m go together; one of them is missing")
    return square_grid(centre, side_m, cell_m)


def _empty(file: Path, grid: Grid, known: Bounds | None) -> str:
    lat, lon = grid.centre or (0.0, 0.0)
    message = f"File '{file}' has nothing to map round lat {lat:g}, lon {lon:g}"
    if known is None:
        return f"{message}; choose another centre"
    west, south, east, north = known
    hint = "choose a centre inside"
    # The centre would lie inside if its numbers were exchanged.
    if south <= lon <= north and west <= lat <= east:
        hint = "latitude and longitude are swapped"
    return f"{message}; it covers lat {south:g} to {north:g}, lon {west:g} to {east:g}: {hint}"
