"""Read a point as people give it: metres from the map's centre, or degrees marked as such."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from sloop_ppl.errors import InputError, OutsideMap
from sloop_ppl.maps.grid import Grid

__all__ = ["DEGREES", "GivenPoint", "are_degrees_of", "read_lat_lon", "read_point"]

DEGREES = "@LAT,LON in degrees, such as @41.4993,-81.6944 or 41.4993N,81.6944W"
"""How degrees are written, for messages; a bare pair of numbers is in metres."""

_BY_THE_MAP_M = 2000.0
"""How far beyond the map numbers count as its degrees: who slips a little asks the same."""

# Degrees alone, with minutes, or with minutes and seconds, as receivers write them.
_ANGLE = (
    r"(\d+(?:\.\d*)?)\s*°?\s*"
    r"(?:(\d+(?:\.\d*)?)\s*['′’]\s*(?:(\d+(?:\.\d*)?)\s*(?:[\"″”]|'')\s*)?)?"
)
_LETTERED = re.compile(rf"(?:([NSEW])\s*{_ANGLE}|{_ANGLE}([NSEW]))", re.IGNORECASE | re.ASCII)


@dataclass(frozen=True)
class GivenPoint:
    """A point as it was given, not yet on a map.

    Parameters
    ----------
    first, second
        x and y in metres, or latitude and longitude in degrees.
    in_degrees
        Which of the two.
    """

    first: float
    second: float
    in_degrees: bool = False

    def on(self, grid: Grid, *, may_be_outside: bool = False) -> tuple[float, float]:
        """Return x and y in the frame of a map, metres.

        Parameters
        ----------
        grid
            The map's grid.
        may_be_outside
            Take degrees outside the map, too; metres are always taken as they are.

        Raises
        ------
        OutsideMap
            For degrees that are outside the map.
        InputError
            When the map's place on earth is unknown, or latitude and longitude are swapped.
        """
        if not self.in_degrees:
            return self.first, self.second
        lat, lon = self.first, self.second
        x, y = (float(v) for v in grid.from_lonlat(lon, lat))
        if math.isfinite(x + y) and grid.contains(x, y):
            return x, y
        if _contains(grid, lat=lon, lon=lat):
            raise InputError(
                f"Latitude {lat:g} and longitude {lon:g} are outside the map, and swapped they are "
                "on it; expected the latitude first"
            )
        if may_be_outside and math.isfinite(x + y):
            return x, y
        (west, east), (south, north) = grid.to_lonlat(
            [grid.west_m, grid.east_m], [grid.south_m, grid.north_m]
        )
        raise OutsideMap(
            f"Latitude {lat:.6g} and longitude {lon:.6g} are outside the map; expected a latitude "
            f"in [{south:.5f}, {north:.5f}] and a longitude in [{west:.5f}, {east:.5f}]"
        )

    def question(self, grid: Grid, written: str) -> str | None:
        """Ask about metres that would be a point of the map as degrees, too; None for others.

        Parameters
        ----------
        written
            How it was given, such as ``"--start 41.4993,-81.6944"``.
        """
        if self.in_degrees or not are_degrees_of(grid, self.first, self.second):
            return None
        lat, lon = self.first, self.second
        if not _contains(grid, lat=lat, lon=lon, beyond_m=_BY_THE_MAP_M):
            lat, lon = lon, lat
        return (
            f"note: {written} was read as metres from the map's centre; are these degrees? If so, "
            f"write @{lat:.10g},{lon:.10g}"
        )


def are_degrees_of(grid: Grid, first: float, second: float) -> bool:
    """Tell whether two numbers are latitude and longitude, in either order, on a map or by it.

    Whole and half numbers are not, such as cell centres: as degrees they would be good to 50 km.
    """
    if (2 * first).is_integer() and (2 * second).is_integer():
        return False
    return any(
        _contains(grid, lat=lat, lon=lon, beyond_m=_BY_THE_MAP_M)
        for lat, lon in ((first, second), (second, first))
    )


def read_point(text: str) -> GivenPoint | None:
    """Read ``x,y`` in metres, ``@lat,lon``, or two angles with letters; None for what is neither.

    Examples
    --------
    >>> read_point("-37.5,-72.5")
    GivenPoint(first=-37.5, second=-72.5, in_degrees=False)
    >>> read_point("81.6944W 41.4993N") == read_point("@41.4993,-81.6944")
    True
    >>> read_point("41°30'N 81°42'W")
    GivenPoint(first=41.5, second=-81.7, in_degrees=True)
    """
    marked = text.strip().removeprefix("@")
    lettered = _lettered(marked)
    if lettered is not None:
        return lettered
    try:
        numbers = [float(part) for part in marked.split(",")]
    except ValueError:
        return None
    if len(numbers) != 2 or not all(map(math.isfinite, numbers)):
        return None
    in_degrees = marked != text.strip()
    if in_degrees and not (abs(numbers[0]) <= 90 and abs(numbers[1]) <= 180):
        return None
    return GivenPoint(numbers[0], numbers[1], in_degrees)


def read_lat_lon(text: str) -> tuple[float, float] | None:
    """Return latitude and longitude of a text that marks them as degrees; None for any other."""
    point = read_point(text)
    return (point.first, point.second) if point is not None and point.in_degrees else None


def _lettered(text: str) -> GivenPoint | None:
    """Read two angles with letters, the latitude first or second."""
    one = _LETTERED.match(text)
    if one is None:
        return None
    two = _LETTERED.fullmatch(text[one.end() :].lstrip(" ,;"))
    if two is None:
        return None
    angles: dict[str, float] = {}
    for found in (one, two):
        parts = found.groups()
        letter = (parts[0] or parts[7]).upper()
        numbers = [float(part or 0) for part in (parts[1:4] if parts[0] else parts[4:7])]
        if max(numbers[1:]) >= 60:
            return None
        angle = numbers[0] + numbers[1] / 60 + numbers[2] / 3600
        angles["lat" if letter in "NS" else "lon"] = -angle if letter in "SW" else angle
    lat, lon = angles.get("lat", math.inf), angles.get("lon", math.inf)
    return GivenPoint(lat, lon, True) if abs(lat) <= 90 and abs(lon) <= 180 else None


def _contains(grid: Grid, *, lat: float, lon: float, beyond_m: float = 0.0) -> bool:
    if grid.centre is None or not (abs(lat) <= 90 and abs(lon) <= 180):
        return False
    x, y = (float(v) for v in grid.from_lonlat(lon, lat))
    west, south, east, north = grid.extent_m
    return west - beyond_m <= x <= east + beyond_m and south - beyond_m <= y <= north + beyond_m
