"""Read the maps of a folder, OpenStreetMap extracts and map files alike."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap, load_map
from sloop_ppl.maps.osm import import_osm

__all__ = ["maps_of_folder"]


def maps_of_folder(
    folder: str | Path,
    *,
    leave_out: tuple[str, ...] = (),
    progress: Callable[[str], None] | None = None,
) -> dict[str, CityMap]:
    """Return the maps of a folder by the name of their file up to its first dot.

    Parameters
    ----------
    folder : holds ``.osm``, ``.osm.pbf`` or ``.geojson`` files.
    leave_out : names not to read.
    progress : told a line a map.

    Raises
    ------
    InputError : when there is no such folder, no map in it, or two of one name, or a name to
        leave out is not there.
    MapError : when a file is no map.
    """
    place = Path(folder)
    if not place.is_dir():
        raise InputError(f"The maps folder '{folder}' is no folder; expected one of map files")
    endings = (".geojson", ".osm", ".osm.pbf")
    paths = [p for p in sorted(place.iterdir()) if p.name.endswith(endings)]
    names = [path.name.split(".")[0] for path in paths]
    if not paths:
        raise InputError(
            f"The maps folder '{folder}' holds no map; expected .osm, .osm.pbf or .geojson files"
        )
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise InputError(f"The maps folder '{folder}' holds '{min(twice)}' twice; keep one")
    for name in leave_out:
        if name not in names:
            raise InputError(
                f"Map '{name}' to leave out is not in folder '{folder}'; it holds "
                f"{', '.join(names)}"
            )
    maps = {}
    for name, path in zip(names, paths, strict=True):
        if name in leave_out:
            continue
        if path.suffix == ".geojson":
            maps[name] = load_map(path)
        else:
            maps[name], _ = import_osm(path, everything=True)
        if progress:
            progress(f"{name}: {len(maps[name].of_kind('building'))} buildings")
    return maps
