"""Find maps by name or path, read them, and write them so that a stopped write leaves the old."""

from __future__ import annotations

import json
import os
from importlib.resources import files
from pathlib import Path
from typing import Any

from sloop_ppl._foreign import ForeignFault, is_file, parse_json, read_text
from sloop_ppl.errors import InputError, MapError, OutputError, UnknownName
from sloop_ppl.maps.city import CityMap
from sloop_ppl.maps.geojson import from_geojson, to_geojson
from sloop_ppl.outputs import check_output

__all__ = [
    "bundled_maps",
    "check_map_path",
    "load_map",
    "map_names",
    "read_map",
    "replace_file",
    "write_map",
]

_ENDINGS = (".geojson", ".json")


def read_map(path: str | Path, cell_m: float | None = None) -> CityMap:
    """Read a map file.

    Parameters
    ----------
    path
        A ``.geojson`` file.
    cell_m
        Side of a cell in metres; the file's own, else 5, when None.

    Raises
    ------
    MapError
        When the file cannot be read or does not follow the format.
    """
    text = read_text(path, "Map file", error=MapError)
    try:
        data = parse_json(text, finite=False)  # the format names the feature of a NaN
    except ForeignFault as error:
        raise MapError(f"Map file '{path}' is not JSON: {error}") from error
    return from_geojson(data, cell_m=cell_m, source=str(path))


def check_map_path(path: str | Path) -> Path:
    """Return the path if a map can be written there; call it before the work.

    Raises
    ------
    InputError
        When it does not end in ``.geojson`` or ``.json``.
    OutputError
        When its folder does not exist or it is a folder.
    """
    path = Path(path)
    if path.suffix.lower() not in _ENDINGS:
        raise InputError(f"'{path}' is no path for a map; expected one that ends in .geojson")
    return check_output(path, _ENDINGS)


def write_map(city: CityMap, path: str | Path) -> None:
    """Write a map file, all of it or nothing: a file that was there stays until the new is whole.

    Raises
    ------
    MapError
        When the map has no centre on earth or holds what JSON cannot say.
    OutputError
        When the path cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from sloop_ppl.maps import load_map
    >>> path = Path(tempfile.mkdtemp()) / "mine.geojson"
    >>> write_map(load_map("cleveland"), path)
    >>> load_map(str(path), cell_m=10)
    CityMap('cleveland', 21 x 21 cells of 10 m, 61 landmarks)
    """
    data = to_geojson(city)
    try:
        features = ",\n".join(_dumps(feature) for feature in data.pop("features"))
        text = f'{_dumps(data)[:-1]}, "features": [\n{features}\n]}}\n'
        written = text.encode("utf-8")
    except (TypeError, ValueError) as error:
        raise MapError(f"Map '{city.name}' cannot be written as JSON: {error}") from error
    replace_file(Path(path), written)


def replace_file(path: Path, content: bytes) -> None:
    """Put a file in place in one step, so that nobody ever sees half of it.

    Raises
    ------
    OutputError
        When the path cannot be written; the file that was there is as before.
    """
    try:
        temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
        file = temporary.open("wb")
    except (OSError, ValueError) as error:
        raise OutputError(f"'{path}' cannot be written: {error}") from error
    try:
        with file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        if path.exists():
            temporary.chmod(path.stat().st_mode & 0o777)
        temporary.replace(path)
    except BaseException as error:
        temporary.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise OutputError(f"'{path}' cannot be written: {error}") from error
        raise


def _dumps(data: Any) -> str:
    return json.dumps(data, ensure_ascii=False, allow_nan=False)


_MAPS = Path(str(files("sloop_ppl"))) / "data" / "maps"


_INVENTED = ("suburb",)
"""Maps of no real place: they have no part in studies, or in scores over all bundled maps."""


def bundled_maps() -> list[str]:
    """Return the names of the cities that ship with the package, in alphabetical order.

    Examples
    --------
    >>> bundled_maps()
    ['austin', 'cleveland', 'denver', 'honolulu', 'washington_dc']
    """
    return [name for name in map_names() if name not in _INVENTED]


def map_names() -> list[str]:
    """Return the names that `load_map` knows: the bundled cities and ``suburb``, an invented place.

    Examples
    --------
    >>> sorted(set(map_names()) - set(bundled_maps()))
    ['suburb']
    """
    return sorted(path.stem for path in _MAPS.glob("*.geojson"))


def load_map(name_or_path: str | Path, cell_m: float | None = None) -> CityMap:
    """Load a bundled map by name, or any map file by path.

    Parameters
    ----------
    name_or_path
        A name that :func:`map_names` lists, or the path of a ``.geojson`` file.
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
    known = map_names()
    if name in known:
        return read_map(_MAPS / f"{name}.geojson", cell_m)
    if is_file(name):
        return read_map(name, cell_m)
    raise UnknownName("map", name, known, hint=" (or give the path of a .geojson file)")
