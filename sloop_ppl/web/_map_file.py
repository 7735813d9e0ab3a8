"""Read a map file that someone dropped in, of any kind that the package imports."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from sloop_ppl.web import _limits

__all__ = ["read_map_file"]

_WINDOW_M = 1_000.0


def read_map_file(path: Path, name: str) -> dict[str, Any]:
    """Return the map as ``map`` and what is to be said of it as ``note``.

    Raises
    ------
    SloopError
        When it is no map.
    """
    from sloop_ppl.maps.geojson import to_geojson
    from sloop_ppl.maps.osm import import_osm

    city, note = _own_map(path), ""
    if city is None:
        city, _ = import_osm(path, everything=True, name=name)
    if city.grid.size > _limits.MOST_CELLS:
        west, south, east, north = city.grid.extent_m
        city = city.window(((west + east) / 2, (south + north) / 2), _WINDOW_M)
        note = (
            f"'{name}' is larger than the workbench shows; this is the kilometre in its middle. "
            "`sloop map import` takes any other patch"
        )
    return {"map": {**to_geojson(city), "name": name}, "note": note}


def _own_map(path: Path) -> Any:
    """Return a map in the package's own format, or None when it is of another."""
    from sloop_ppl.maps.files import read_map

    with path.open("rb") as file:
        head = file.read(2**16)
    if not head.lstrip().startswith(b"{") or b'"centre"' not in head + _tail(path):
        return None
    return read_map(path)


def _tail(path: Path) -> bytes:
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - 2**16))
        return file.read()
