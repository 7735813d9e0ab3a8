"""Fetch a place from OpenStreetMap over the network, through osmnx."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from sloop_ppl.errors import InputError, MapError
from sloop_ppl.maps._symbols import folded
from sloop_ppl.maps.city import CityMap
from sloop_ppl.maps.osm._feature import OsmData, OsmFeature
from sloop_ppl.maps.osm.extent import grid_bounds, square_grid
from sloop_ppl.maps.osm.import_report import ImportReport
from sloop_ppl.maps.osm.importer import build_map

__all__ = ["fetch_place"]

_WANTED: dict[str, bool | str | list[str]] = dict.fromkeys(
    (
        "building", "highway", "amenity", "shop", "tourism", "leisure", "office", "craft",
        "healthcare", "historic", "landuse", "natural", "waterway", "place", "railway", "man_made",
        "aeroway", "entrance", "addr:housenumber",
    ),
    True,
)  # fmt: skip


def fetch_place(
    place: str,
    *,
    side_m: float = 200.0,
    cell_m: float = 5.0,
    name: str | None = None,
    progress: Callable[[str], None] | None = None,
) -> tuple[CityMap, ImportReport]:
    """Fetch a square patch round a place from OpenStreetMap.

    Parameters
    ----------
    place
        What to search for, such as ``"Union Square, San Francisco"``.
    side_m
        Side of the patch, metres, > 0.
    cell_m
        Side of a cell, metres, > 0.
    name
        What to call the map; the words of `place` before the first comma when None.
    progress
        Called with a few words on what is being done.

    Returns
    -------
    tuple
        The map and a report, as :func:`import_osm` returns them.

    Raises
    ------
    InputError
        When osmnx is not installed, or a number cannot be used.
    MapError
        When there is no network, no such place or nothing to map there.
    """
    notify = progress or (lambda _: None)
    if not place.strip():
        raise InputError("The place is empty; expected a name such as 'Union Square, New York'")
    square_grid((0.0, 0.0), side_m, cell_m)  # refuses numbers before the network is asked
    try:
        import osmnx
    except ImportError as error:
        raise InputError(
            "Fetching needs osmnx, which is not installed; run pip install 'sloop-ppl[fetch]', or "
            "import a file with `sloop map import`"
        ) from error
    osmnx.settings.use_cache = False  # else it leaves a folder where one stands
    try:
        notify(f"searching for {place}")
        grid = square_grid(osmnx.geocode(place), side_m, cell_m)
        notify("fetching what is there")
        table = osmnx.features_from_bbox(grid_bounds(grid), _WANTED)
    except Exception as error:  # osmnx raises kinds of its own, of requests and of urllib3
        raise MapError(_refused(place, error)) from error
    report = ImportReport(read=len(table))
    data = OsmData([_feature(index, row) for index, row in table.iterrows()])
    called = name or folded(place.split(",")[0]).replace(" ", "_") or "place"
    city = build_map(data, grid, called, report, notify)
    if not city.landmarks:
        raise MapError(f"There is nothing to map round '{place}'; choose another place")
    return city, report


def _feature(index: Any, row: Any) -> OsmFeature:
    tags = {
        str(key): str(value)
        for key, value in row.items()
        if key != "geometry"
        and value is not None
        and not (isinstance(value, float) and math.isnan(value))  # pandas fills with NaN
    }
    outline = row.geometry.exterior if row.geometry.geom_type == "Polygon" else None
    return OsmFeature(f"{index[0]}/{index[1]}", tags, row.geometry, outline)


def _refused(place: str, error: Exception) -> str:
    """Return one line for what osmnx and what it stands on raise."""
    sort = type(error).__name__
    if sort in ("InsufficientResponseError", "TypeError"):
        return f"OpenStreetMap knows no place '{place}', or nothing there; spell it another way"
    message = " ".join(str(error).split())
    network = any(
        word in f"{sort} {message}" for word in ("Connection", "Timeout", "resolve", "Max")
    )
    cause = "there is no network" if network else f"{sort}: {message[:120]}"
    return (
        f"Place '{place}' cannot be fetched: {cause}; where there is none, bring an .osm or "
        ".osm.pbf file and use `sloop map import`"
    )
