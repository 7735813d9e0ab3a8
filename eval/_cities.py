"""Tell which maps were cut from one city, so that cross-validation leaves them out together."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

__all__ = ["cities_of"]

Degrees = tuple[float, float]

_CITY_KM = 20.0
"""How far apart the centres of maps of one city lie at most, kilometres."""


def cities_of(
    sources: Mapping[str, Collection[str]], centres: Mapping[str, Degrees | None]
) -> dict[str, str]:
    """Return map -> the name of its city.

    Parameters
    ----------
    sources
        Map -> the files whose lines name it.
    centres
        Map -> latitude and longitude of its centre, degrees; None for one that is nowhere on
        earth.

    Returns
    -------
    dict of str
        The map itself for one that is alone. Maps that hang together by steps of at most 20 km
        have the name of the file when all are in one, else that of the first of them.

    Examples
    --------
    >>> near = {"a1": ["a"], "a2": ["a"], "b": ["b"]}
    >>> cities_of(near, {"a1": (40.0, -75.0), "a2": (40.1, -75.0), "b": (44.0, -75.0)})
    {'a1': 'a', 'a2': 'a', 'b': 'b'}
    """
    groups: list[list[str]] = []
    for name in sources:
        near = [g for g in groups if any(_is_near(centres[name], centres[other]) for other in g)]
        groups = [g for g in groups if g not in near]
        groups.append([*(other for g in near for other in g), name])
    cities: dict[str, str] = {}
    for group in groups:
        files = set().union(*(sources[name] for name in group))
        city = group[0] if len(group) == 1 or len(files) > 1 else next(iter(files))
        cities |= dict.fromkeys(group, city)
    return {name: cities[name] for name in sources}


def _is_near(one: Degrees | None, other: Degrees | None) -> bool:
    """Tell whether two centres lie within a city of each other.

    A degree of latitude is 111 km, one of longitude that times the cosine of the latitude.
    """
    if one is None or other is None:
        return False
    east = (one[1] - other[1] + 180) % 360 - 180
    east_km = 111.2 * east * math.cos(math.radians((one[0] + other[0]) / 2))
    return math.hypot(east_km, 111.2 * (one[0] - other[0])) < _CITY_KM
