"""Find a map by the name of a bundled city or by path."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from sloop_ppl.errors import UnknownName
from sloop_ppl.maps.city import CityMap
from sloop_ppl.maps.files import read_map

__all__ = ["bundled_maps", "load_map"]

_MAPS = Path(str(files("sloop_ppl"))) / "data" / "maps"


def bundled_maps() -> list[str]:
    """Return the names of the maps that ship with the package, in alphabetical order."""
    return sorted(path.stem for path in _MAPS.glob("*.geojson"))


def load_map(name_or_path: str | Path, cell_m: float | None = None) -> CityMap:
    """Load a bundled map by name, or any map file by path.

    Parameters
    ----------
    name_or_path
        A name that :func:`bundled_maps` lists, or the path of a ``.geojson`` file.
    cell_m
        Side of a cell in metres; the map's own, else 5, when None.

    Raises
    ------
    UnknownName
        When there is neither such a bundled map nor such a file.
    MapError
        When the file does not follow the format.

    Examples
    --------
    >>> load_map("cleveland")
    CityMap('cleveland', 41 x 41 cells of 5 m, 61 landmarks)
    """
    name = str(name_or_path)
    if name in bundled_maps():
        return read_map(_MAPS / f"{name}.geojson", cell_m)
    if Path(name).is_file():
        return read_map(name, cell_m)
    raise UnknownName("map", name, bundled_maps(), hint=" (or give the path of a .geojson file)")
