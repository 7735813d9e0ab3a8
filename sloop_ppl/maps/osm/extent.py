"""Lay the grid of a map from what the user asks for: a square, a box, or all there is."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.maps._given_point import read_lat_lon
from sloop_ppl.maps.grid import Grid
from sloop_ppl.maps.osm._window import Bounds, crossing

__all__ = ["beyond_m", "box_grid", "data_grid", "grid_bounds", "read_degrees", "square_grid"]

# A box across longitude 180 is no wider.
_ACROSS_DEG = 90.0
_LEAST_SIDE_M = 100.0


def square_grid(centre: Sequence[float], side_m: float, cell_m: float) -> Grid:
    """Return the grid of a square round a place.

    Parameters
    ----------
    centre
        Latitude and longitude, degrees.
    side_m
        Side of the square, metres, > 0.

    Raises
    ------
    InputError
        When a number cannot be used.
    """
    lat, lon = _numbers(centre, 2, "centre", "latitude,longitude")
    # At the poles longitudes meet, and an equidistant square means nothing.
    if not (-89 <= lat <= 89 and -180 <= lon <= 180):
        raise InputError(
            f"centre is {lat:g},{lon:g}; expected latitude,longitude with the latitude in "
            "[-89, 89] and the longitude in [-180, 180]; are they swapped?"
        )
    # A limit against slips: 200 km are no city.
    if not (math.isfinite(side_m) and 0 < side_m <= 200_000):
        raise InputError(f"side_m is {side_m:g}; expected metres, more than 0 and up to 200000")
    return Grid.square(side_m / 2, cell_m, (lat, lon))


def box_grid(bbox: Sequence[float], cell_m: float) -> Grid:
    """Return the grid of a box, its sides in whole centimetres.

    Parameters
    ----------
    bbox
        West, south, east and north, degrees; west > east across longitude 180.

    Raises
    ------
    InputError
        When a number cannot be used, or the box is empty.
    """
    west, south, east, north = _numbers(bbox, 4, "bbox", "west,south,east,north")
    on_earth = -180 <= west <= 180 and -180 <= east <= 180 and south >= -89 and north <= 89
    # A box across longitude 180 is narrow; one whose sides are swapped nearly goes round the earth.
    across = east + 360 if west > east and east + 360 - west <= _ACROSS_DEG else east
    if not (on_earth and west < across and south < north):
        raise InputError(
            f"bbox is {west:g},{south:g},{east:g},{north:g}; expected west,south,east,north in "
            "degrees, west < east and south < north, longitudes in [-180, 180], latitudes in "
            "[-89, 89]; are they swapped?"
        )
    middle = (west + across) / 2
    centre = ((south + north) / 2, middle - 360 if middle > 180 else middle)
    frame = Grid.square(1.0, 1.0, centre)
    x, y = frame.from_lonlat([west, east, centre[1], centre[1]], [centre[0]] * 2 + [south, north])
    # The sides through the middle of the box, in whole centimetres.
    left, bottom, right, top = (round(float(side), 2) for side in (x[0], y[2], x[1], y[3]))
    return Grid(left, bottom, right, top, cell_m, centre)


def data_grid(reached: Bounds, cell_m: float) -> Grid:
    """Return the grid of all there is, its outermost points on it, their box in degrees given.

    A side is 100 m at least: of a single point the surroundings are taken.
    """
    west, south, east, north = reached
    across = east + 360 if west > east else east
    middle = (west + across) / 2
    centre = ((south + north) / 2, middle - 360 if middle > 180 else middle)
    frame = Grid.square(1.0, 1.0, centre)
    # Sides that are straight in degrees bulge in metres: corners and middles of the sides.
    lon, lat = np.meshgrid([west, centre[1], east], [south, centre[0], north])
    x, y = frame.from_lonlat(lon.ravel(), lat.ravel())
    sides = []
    for low, high in ((float(x.min()), float(x.max())), (float(y.min()), float(y.max()))):
        spare = max(0.0, _LEAST_SIDE_M - (high - low)) / 2
        # Outwards, in whole centimetres.
        sides.append((math.floor((low - spare) * 100) / 100, math.ceil((high + spare) * 100) / 100))
    (left, right), (bottom, top) = sides
    return Grid(left, bottom, right, top, cell_m, centre)


def grid_bounds(grid: Grid) -> Bounds:
    """Return the longitudes and latitudes that a grid's extent reaches."""
    west, south, east, north = grid.extent_m
    # Nine points a side: sides that are straight in metres bulge in degrees.
    x = np.linspace(west, east, 9)
    y = np.linspace(south, north, 9)
    lon, lat = grid.to_lonlat(
        np.concatenate([x, x, np.full(9, west), np.full(9, east)]),
        np.concatenate([np.full(9, south), np.full(9, north), y, y]),
    )
    if lon.max() - lon.min() > 180:
        west, east = crossing(float((lon % 360).min()), float((lon % 360).max()))
    else:
        west, east = float(lon.min()), float(lon.max())
    return west, float(lat.min()), east, float(lat.max())


def beyond_m(grid: Grid, known: Bounds, share: float = 0.0) -> dict[str, float]:
    """Return how far a grid reaches beyond bounds in degrees, metres by side.

    Sides are left out where it is less than a metre, or less than a share of the grid's side.
    """
    if grid.centre is None:
        return {}
    west, south, east, north = known
    lat, lon = grid.centre
    x, y = grid.from_lonlat([west, east, lon, lon], [lat, lat, south, north])
    left, bottom, right, top = grid.extent_m
    over = {
        "west": float(x[0]) - left,
        "south": float(y[2]) - bottom,
        "east": right - float(x[1]),
        "north": top - float(y[3]),
    }
    least = max(1.0, share * max(right - left, top - bottom))
    return {side: metres for side, metres in over.items() if metres > least}


def read_degrees(text: str, expected: str) -> tuple[float, ...]:
    """Read numbers parted by commas, as many as are expected, or a point as 60.17N,24.94E.

    Raises
    ------
    InputError
        When there are more or fewer, or one is not a finite number.

    Examples
    --------
    >>> read_degrees("60.17,24.94", "LAT,LON")
    (60.17, 24.94)
    """
    marked = read_lat_lon(text) if expected == "LAT,LON" else None
    if marked is not None:
        return marked
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) != len(expected.split(",")) or not all(math.isfinite(n) for n in numbers):
        raise InputError(f"'{text}' is not {expected}; expected numbers in degrees, without spaces")
    return numbers


def _numbers(values: Sequence[float], count: int, name: str, expected: str) -> list[float]:
    numbers = [float(value) for value in values]
    if len(numbers) != count or not all(math.isfinite(number) for number in numbers):
        raise InputError(f"{name} is {tuple(values)}; expected {expected} in degrees")
    return numbers
