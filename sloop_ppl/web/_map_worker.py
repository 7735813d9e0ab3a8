"""Read a map file that someone dropped in, in a process of its own with limits."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from sloop_ppl.errors import SloopError
from sloop_ppl.web import _limits

__all__ = ["read_in_worker"]

_MORE_BYTES = 3 * 2**30
_WINDOW_M = 1_000.0


def read_in_worker(path: str, name: str, connection: Connection) -> None:
    """Send ``{"map": ..., "note": ...}`` or ``{"error": ...}``, and end."""
    _limit_process()
    answer: dict[str, Any]
    try:
        answer = _read(Path(path), name)
    except SloopError as error:
        answer = {"error": str(error).replace(path, name)}
    except MemoryError:
        answer = {"error": "The map is too large to be read; import a smaller patch of it"}
    connection.send_bytes(json.dumps(answer).encode())
    connection.close()


def _read(path: Path, name: str) -> dict[str, Any]:
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


def _limit_process() -> None:
    """Bound memory and processor time, where the system can."""
    if sys.platform == "win32":
        return
    import resource

    pages = int(Path("/proc/self/statm").read_text().split()[0]) if _has_proc() else 0
    most = pages * resource.getpagesize() + _MORE_BYTES
    bounds: tuple[tuple[int, int], ...] = (
        (resource.RLIMIT_AS, most),
        (resource.RLIMIT_CPU, int(_limits.SECONDS_FOR_A_MAP)),
    )
    set_limit: Callable[..., None] = resource.setrlimit
    for what, value in bounds:
        set_limit(what, (value, value))


def _has_proc() -> bool:
    return Path("/proc/self/statm").exists()
