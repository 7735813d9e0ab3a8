"""Find the maps that descriptions name: bundled ones, or those of a folder."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

from sloop_ppl._foreign import is_folder
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import CityMap, bundled_maps, load_map

__all__ = ["all_maps", "map_finder"]


def map_finder(folder: str | Path | None = None) -> Callable[[str], CityMap]:
    """Return what gives a map by its name; each map is loaded once.

    Parameters
    ----------
    folder
        Where ``NAME.geojson`` files lie, which come before the bundled maps; None for the bundled
        maps, and for paths.

    Raises
    ------
    InputError
        When `folder` is no folder, or holds no map file.
    """
    if folder is None:
        return cache(load_map)
    paths = _paths(folder)

    def find(name: str) -> CityMap:
        if name not in paths and name in bundled_maps():
            return load_map(name)
        if name not in paths:
            raise UnknownName("map", name, paths, hint=f" (in folder '{folder}')")
        return load_map(paths[name])

    return cache(find)


def all_maps(folder: str | Path | None = None) -> list[CityMap]:
    """Return all maps of a folder, or all bundled ones, in alphabetical order."""
    find = map_finder(folder)
    return [find(name) for name in (bundled_maps() if folder is None else _paths(folder))]


def _paths(folder: str | Path) -> dict[str, Path]:
    if not is_folder(folder):
        raise InputError(f"The maps folder '{folder}' is no folder; expected one of .geojson files")
    paths = {path.stem: path for path in sorted(Path(folder).glob("*.geojson"))}
    if not paths:
        raise InputError(
            f"The maps folder '{folder}' holds no .geojson file; expected at least one"
        )
    return paths
