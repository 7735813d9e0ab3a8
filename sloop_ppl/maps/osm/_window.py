"""Tell what lies within bounds in degrees, which may cross longitude 180."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["Bounds", "Window", "crossing"]

Bounds = tuple[float, float, float, float]
"""West, south, east and north in degrees; west > east when they cross longitude 180."""


class Window:
    """The bounds that are asked for, and how far what has been looked at reaches.

    Parameters
    ----------
    bounds
        Degrees; the whole earth when None.
    """

    def __init__(self, bounds: Bounds | None) -> None:
        self.bounds = bounds
        self._lat = [float("inf"), -float("inf")]
        # From 180 west to 180 east, and from 0 to 360 east: what crosses longitude 180 is narrower
        # in the second.
        self._lon = [float("inf"), -float("inf")]
        self._east_lon = [float("inf"), -float("inf")]

    def meets(self, corners: Sequence[tuple[float, float]]) -> bool:
        """Tell whether the bounding box of some longitudes and latitudes meets the bounds."""
        if not corners:
            return False
        lon, lat = zip(*corners, strict=True)
        west, south, east, north = min(lon), min(lat), max(lon), max(lat)
        if west < 0 <= east:
            turned = [x + 360 if x < 0 else x for x in lon]
            from_0, to_360 = min(turned), max(turned)
        else:
            turn = 360 if east < 0 else 0
            from_0, to_360 = west + turn, east + turn
        self._widen(self._lat, south, north)
        self._widen(self._lon, west, east)
        self._widen(self._east_lon, from_0, to_360)
        if self.bounds is None:
            return True
        w, s, e, n = self.bounds
        if north < s or south > n:
            return False
        if w <= e:
            return not (east < w or west > e)
        return not (to_360 < w or from_0 > e + 360)

    @property
    def reached(self) -> Bounds | None:
        """Bounds of all that has been looked at; None when there was nothing."""
        if self._lat[0] > self._lat[1]:
            return None
        west, east = self._lon
        if east - west > 180 and self._east_lon[1] - self._east_lon[0] < east - west:
            west, east = crossing(*self._east_lon)
        return west, self._lat[0], east, self._lat[1]

    @staticmethod
    def _widen(span: list[float], low: float, high: float) -> None:
        span[0], span[1] = min(span[0], low), max(span[1], high)


def crossing(west: float, east: float) -> tuple[float, float]:
    """Return longitudes between 0 and 360 as longitudes between -180 and 180.

    Examples
    --------
    >>> crossing(179.0, 181.0)
    (179.0, -179.0)
    """
    return (west - 360 if west > 180 else west), (east - 360 if east > 180 else east)
