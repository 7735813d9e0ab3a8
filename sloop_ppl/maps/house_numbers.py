"""House numbers along a street, and places between those that the map has."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from sloop_ppl.maps._along import nearest_on_lines
from sloop_ppl.maps.city import CityMap
from sloop_ppl.maps.frontage import street_key
from sloop_ppl.maps.landmark import PATH_KINDS, Landmark
from sloop_ppl.maps.street_network import StreetNetwork, street_network

__all__ = ["HouseNumbers", "house_numbers"]

_FIRST_NUMBER = re.compile(r"\d{1,5}")
_NUMBER_FIRST = re.compile(r"(\d{1,5})\S*\s+(\D.*)")
_NUMBER_LAST = re.compile(r"(.*\D)\s+(\d{1,5})\S*")
# A door stands this far from the edge of the carriageway, metres: a pavement and a step.
_DOOR_M = 6.0
# A door farther from the street, or from its end, is not on the part of it that the map has.
_REACH_M = 60.0
_END_M = 15.0
# So many of the numbers must lie on their side for the sides to count as odd and even.
_AGREEMENT = 0.75


@dataclass(frozen=True, eq=False)
class HouseNumbers:
    """The house numbers of a street that the map has, by their place along it.

    Parameters
    ----------
    line
        The spine of the street, metres.
    offset_m
        How far beside the spine a door is, metres.
    numbers
        The numbers, ascending, at least one, shape (n,).
    along_m
        Where they are along the spine, metres, shape (n,).
    on_left
        Whether they are on the left of its direction, shape (n,).
    even_on_left
        True where even numbers are on the left of the spine's direction and odd ones on the right,
        False where they are the other way round, None where the map does not tell.
    """

    line: shapely.LineString
    offset_m: float
    numbers: NDArray[np.int64]
    along_m: NDArray[np.float64]
    on_left: NDArray[np.bool_]
    even_on_left: bool | None

    def locate(self, number: int) -> tuple[float, float] | None:
        """Return x and y of a number, metres, or None where the map's numbers do not reach.

        Parameters
        ----------
        number
            The house number. It lies on its side of the street where the sides are known, else on
            the axis. Numbers between two known ones are interpolated along the street, from those
            of its side when there are two of them.
        """
        numbers, along = self._running(number % 2 if self.even_on_left is not None else None)
        if not numbers[0] <= number <= numbers[-1]:
            return None
        at = float(np.interp(number, numbers, along))
        here, ahead = (shapely.line_interpolate_point(self.line, m) for m in (at, at + 0.5))
        if at + 0.5 > self.line.length:
            here, ahead = (shapely.line_interpolate_point(self.line, m) for m in (at - 0.5, at))
        foot = shapely.line_interpolate_point(self.line, at)
        if self.even_on_left is None:
            return float(foot.x), float(foot.y)
        way = np.array([ahead.x - here.x, ahead.y - here.y])
        way /= max(float(np.hypot(*way)), 1e-12)
        left = (number % 2 == 0) == self.even_on_left
        side = self.offset_m if left else -self.offset_m
        return float(foot.x - way[1] * side), float(foot.y + way[0] * side)

    def at(self, along_m: NDArray[np.float64], on_left: NDArray[np.bool_]) -> NDArray[np.float64]:
        """Return the number that places beside the spine would have, nan where none is known.

        Parameters
        ----------
        along_m
            Metres from the start of the spine, any shape.
        on_left
            Whether they are on the left of its direction, same shape.

        Returns
        -------
        numpy.ndarray
            Numbers interpolated between those of the same side where the sides are known, not
            rounded, same shape.
        """
        if self.even_on_left is None:
            return self._number_at(along_m, None)
        even, odd = (self._number_at(along_m, parity) for parity in (0, 1))
        return np.where(on_left == self.even_on_left, even, odd)

    def _number_at(self, along_m: NDArray[np.float64], parity: int | None) -> NDArray[np.float64]:
        numbers, along = self._running(parity)
        if len(numbers) < 2:
            return np.full_like(along_m, np.nan)
        if along[0] > along[-1]:
            numbers, along = numbers[::-1], along[::-1]
        interpolated: NDArray[np.float64] = np.interp(
            along_m, along, numbers.astype(float), left=np.nan, right=np.nan
        )
        return interpolated

    def _running(self, parity: int | None) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the numbers that run one way along the street, of one parity if it has two."""
        chosen = np.ones(len(self.numbers), dtype=np.bool_)
        if parity is not None and (self.numbers % 2 == parity).sum() >= 2:
            chosen = self.numbers % 2 == parity
        numbers, first = np.unique(self.numbers[chosen], return_inverse=True)
        along = np.bincount(first, self.along_m[chosen]) / np.bincount(first)
        up, down = _longest_rising(along), _longest_rising(-along)
        kept = up if len(up) >= len(down) else down
        return numbers[kept], along[kept]


def house_numbers(city: CityMap, street_id: str) -> HouseNumbers | None:
    """Return the house numbers of a street; None where the map has none.

    Parameters
    ----------
    city
        The map.
    street_id
        Id of any landmark of the street.

    Notes
    -----
    A number belongs to the street of its address (``addr:street`` or `addresses`), else to the
    street its building faces. Numbers run one way along a street: those outside the longest
    sequence that does, such as one of the other street at a corner, are left out.

    Examples
    --------
    >>> from sloop_ppl.maps import load_map
    >>> numbers = house_numbers(load_map("cleveland"), "West6thSt")
    >>> [round(metres) for metres in numbers.locate(1250)]  # x and y
    [-38, 13]
    """
    network = street_network(city)
    at = network.position(street_id)
    if at is None:
        return None
    every = city.derived("house numbers", lambda: _by_street(city, network))
    return every.get(at)


def _by_street(city: CityMap, network: StreetNetwork) -> dict[int, HouseNumbers]:
    by_key = {street_key(axis.label): i for i, axis in enumerate(network.streets) if axis.named}
    found: dict[int, list[tuple[int, float, float]]] = {}
    for landmark in city.landmarks:
        for number, street in _addresses(landmark):
            at = by_key.get(street_key(street)) if street else _faced(city, network, landmark)
            if at is not None:
                point = landmark.geometry.centroid
                found.setdefault(at, []).append((number, point.x, point.y))
    made = {i: _numbers(network, i, sorted(set(doors))) for i, doors in sorted(found.items())}
    return {i: numbers for i, numbers in made.items() if numbers is not None}


def _addresses(landmark: Landmark) -> Iterator[tuple[int, str | None]]:
    """Yield the numbers a landmark has and the names of their streets, where they are given."""
    listed = landmark.properties.get("addresses")
    known = False
    for text in listed if isinstance(listed, list | tuple) else ():
        if not isinstance(text, str):
            continue
        if match := _NUMBER_FIRST.fullmatch(text.strip()):
            known = True
            yield int(match[1]), match[2]
        elif match := _NUMBER_LAST.fullmatch(text.strip()):
            known = True
            yield int(match[2]), match[1]
    number = landmark.properties.get("house_number", landmark.properties.get("addr:housenumber"))
    first = _FIRST_NUMBER.match(str(number)) if number is not None else None
    street = landmark.properties.get("addr:street")
    if first is not None and not known and landmark.kind not in PATH_KINDS:
        yield int(first[0]), street if isinstance(street, str) else None


def _faced(city: CityMap, network: StreetNetwork, landmark: Landmark) -> int | None:
    street = city.frontage(landmark.id).street
    return None if street is None else network.position(street.id)


def _numbers(
    network: StreetNetwork, street: int, doors: list[tuple[int, float, float]]
) -> HouseNumbers | None:
    axis = network.streets[street]
    if not axis.spines:
        return None
    places = np.array([(x, y) for _, x, y in doors])
    nearest = nearest_on_lines(axis.spines, places)
    away = np.hypot(*nearest.offset_m.T)
    length = np.array([spine.length for spine in axis.spines])[nearest.line]
    beyond = (nearest.along_m <= 0) | (nearest.along_m >= length)
    # A door off the end of the street says nothing of places along it, unless it is at the end.
    counts = away <= np.where(beyond, axis.width_m / 2 + _END_M, _REACH_M)
    if not counts.any():
        return None
    # The spine with most of the numbers: elsewhere they may start again.
    spine = int(np.bincount(nearest.line[counts]).argmax())
    here = counts & (nearest.line == spine)
    numbers = np.array([number for number, _, _ in doors])[here]
    on_left = nearest.on_left[here]
    agree = float((on_left == (numbers % 2 == 0)).mean())
    is_clear = len(numbers) > 1 and max(agree, 1 - agree) >= _AGREEMENT
    return HouseNumbers(
        line=axis.spines[spine],
        offset_m=axis.width_m / 2 + _DOOR_M,
        numbers=numbers,
        along_m=nearest.along_m[here],
        on_left=on_left,
        even_on_left=agree >= 0.5 if is_clear else None,
    )


def _longest_rising(values: NDArray[np.float64]) -> list[int]:
    """Return the positions of the longest sequence of values that rises, the first of equals."""
    best: list[list[int]] = []
    for i, value in enumerate(values):
        before = [run for run in best if values[run[-1]] < value]
        best.append([*max(before, key=len, default=[]), i])
    return max(best, key=len)
