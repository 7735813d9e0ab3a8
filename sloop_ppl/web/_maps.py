"""The maps that pages may choose from: the bundled ones, the server's own, and those dropped in."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Sequence

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap, load_map, map_names
from sloop_ppl.maps.geojson import from_geojson
from sloop_ppl.web import _limits
from sloop_ppl.web._file_worker import read_dropped_file
from sloop_ppl.web._map_file import read_map_file
from sloop_ppl.web._refusal import Refusal

__all__ = ["MapShelf", "shown_name"]


class MapShelf:
    """Maps by key: a bundled map's name, or the digest of another.

    A digest, so that a link to a map that was dropped in holds on any machine that has the map.

    Parameters
    ----------
    given
        Names or paths the server was started with; the first is shown first.
    """

    def __init__(self, given: Sequence[str] = ()) -> None:
        self._bundled = frozenset(map_names())
        self._lock = threading.Lock()
        self._loaded: dict[str, CityMap] = {}
        self._dropped: OrderedDict[str, CityMap] = OrderedDict()
        self.sources: dict[str, str] = {name: name for name in sorted(self._bundled)}
        keys = [self.add(name) for name in given]
        self.first = keys[0] if keys else "cleveland"

    def add(self, name: str) -> str:
        """Load a map by name or path, and return its key.

        Raises
        ------
        SloopError
            When there is no such map, or it is too large.
        """
        if name in self._bundled:
            return name
        city = load_map(name)
        if city.grid.size > _limits.MOST_CELLS:
            raise InputError(
                f"Map '{name}' has {city.grid.size} cells; the workbench takes "
                f"{_limits.MOST_CELLS} at most: import a smaller patch, or larger cells"
            )
        self._loaded[city.digest] = city
        self.sources[city.digest] = name
        return city.digest

    def get(self, key: str) -> CityMap:
        """Return a map.

        Raises
        ------
        Refusal
            When there is none of this key.
        """
        with self._lock:
            if key in self._dropped:
                self._dropped.move_to_end(key)
                return self._dropped[key]
            if key not in self._loaded:
                if key not in self._bundled:
                    raise Refusal(
                        404, "This map is not here; drop its file into the page, or choose another"
                    )
                self._loaded[key] = load_map(key)
            return self._loaded[key]

    def key_of(self, source: str) -> str:
        """Return the key of a map that was added by name or path."""
        return next(key for key, name in self.sources.items() if name == source)

    def key_of_episode(self, name: str, digest: str) -> str:
        """Return the key of the map that an episode names, by its digest if it has one.

        Raises
        ------
        Refusal
            When it is not here.
        """
        with self._lock:
            own = {key: city.name for key, city in (*self._loaded.items(), *self._dropped.items())}
        if digest in own:
            return digest
        if name in self._bundled and (not digest or self.get(name).digest == digest):
            return name
        fitting = [key for key, known in own.items() if known == name and not digest]
        if not fitting:
            raise Refusal(
                422,
                f"The episode was searched on map '{name[:60]}', which is not here as it was then; "
                "open the map's file first, then the episode",
            )
        return fitting[-1]

    def names(self) -> list[dict[str, str]]:
        """Return key and name of each map, the server's own first."""
        with self._lock:
            own = {k: c.name for k, c in self._loaded.items() if k not in self._bundled}
            dropped = {k: c.name for k, c in self._dropped.items()}
        named = {**own, **dropped, **{name: _title(name) for name in sorted(self._bundled)}}
        return [{"key": key, "name": name} for key, name in named.items()]

    def take_in(self, content: bytes, name: str) -> tuple[str, str]:
        """Read a map file in a process of its own and keep the map.

        Parameters
        ----------
        content
            The file, of any kind that ``sloop map import`` reads, or a map file.
        name
            What to call the map; it names nothing on the disk.

        Returns
        -------
        tuple of str
            Key of the map, and what is to be said of it.

        Raises
        ------
        Refusal
            When it cannot be read.
        """
        shown = shown_name(name, "dropped map")
        read = read_dropped_file(read_map_file, content, shown, "Map")
        city = from_geojson(read["map"], source=shown)
        with self._lock:
            self._dropped[city.digest] = city
            while len(self._dropped) > _limits.MOST_UPLOADS:
                self._dropped.popitem(last=False)
        return city.digest, read["note"]


def shown_name(name: str, otherwise: str) -> str:
    """Return what a dropped file is called on the page; it names nothing on the disk."""
    return " ".join(name.split())[:60] or otherwise


def _title(name: str) -> str:
    return name.replace("_", " ").title().replace(" Dc", " DC")
