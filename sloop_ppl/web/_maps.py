"""The maps that pages may choose from: the bundled ones, the server's own, and those dropped in."""

from __future__ import annotations

import json
import tempfile
import threading
from collections import OrderedDict
from collections.abc import Sequence
from pathlib import Path

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap, load_map, map_names
from sloop_ppl.maps.geojson import from_geojson
from sloop_ppl.web import _limits
from sloop_ppl.web._map_worker import read_in_worker
from sloop_ppl.web._refusal import Refusal
from sloop_ppl.web._workers import Worker

__all__ = ["MapShelf"]


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
        shown = " ".join(name.split())[:60] or "dropped map"
        with tempfile.TemporaryDirectory(prefix="sloop-") as folder:
            path = Path(folder) / "map"
            path.write_bytes(content)
            worker = Worker(read_in_worker, str(path), shown)
            try:
                answer = worker.receive(_limits.SECONDS_FOR_A_MAP)
            finally:
                worker.stop()
        if answer is None:
            raise Refusal(
                422, f"Map '{shown}' takes too long or too much to read; try a smaller one"
            )
        read = json.loads(answer)
        if "error" in read:
            raise Refusal(422, read["error"])
        city = from_geojson(read["map"], source=shown)
        with self._lock:
            self._dropped[city.digest] = city
            while len(self._dropped) > _limits.MOST_UPLOADS:
                self._dropped.popitem(last=False)
        return city.digest, read["note"]


def _title(name: str) -> str:
    return name.replace("_", " ").title().replace(" Dc", " DC")
