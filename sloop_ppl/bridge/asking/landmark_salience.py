"""Which landmarks a person can be asked about: how well one is named, how much it stands out."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.maps import CityMap, Landmark

__all__ = ["askable_landmarks", "salience", "saliences"]

_PROMINENCE: Mapping[str, float] = {
    "park": 1.0,
    "square": 1.0,
    "water": 1.0,
    "building": 0.9,
    "poi": 0.8,
    "street": 0.8,
    "pedestrian": 0.6,
    "parking": 0.6,
    "service": 0.4,
}
_LEAST = 0.3
_FULL_SIZE_M = 30.0
_LONG_NAME = 4


def salience(city: CityMap, landmark_id: str) -> float:
    """Return how well a person can be asked about a landmark, in [0, 1].

    Parameters
    ----------
    city
        The map.
    landmark_id
        Id of the landmark.

    Raises
    ------
    UnknownName
        When there is no such landmark.

    Notes
    -----
    ``nameability * prominence``. Nameability is 0 without a name; else 1, times .5 for a name that
    is guessed, .4 for one that another landmark has too, .7 for one of more than four words or
    without a letter. Prominence is that of the kind (park, square, water 1, building .9, poi and
    street .8, parking and walk .6, driveway .4), times .5 to 1 with the longer side of what it
    covers, up to 30 m. Not measured on people: an order for asking, stated so that it can be
    changed.
    """
    landmark = city.landmark(landmark_id)
    return _nameability(city, landmark) * _prominence(city, landmark)


def _nameability(city: CityMap, landmark: Landmark) -> float:
    name = landmark.name
    if not name:
        return 0.0
    counts = city.derived(
        "asking: names", lambda: Counter(m.name.casefold() for m in city.landmarks if m.name)
    )
    score = 0.5 if landmark.properties.get("name_is_guess") else 1.0
    score *= 0.4 if counts[name.casefold()] > 1 else 1.0
    is_long = len(name.split()) > _LONG_NAME or not any(letter.isalpha() for letter in name)
    return float(score * (0.7 if is_long else 1.0))


def _prominence(city: CityMap, landmark: Landmark) -> float:
    west, south, east, north = city.footprint(landmark.id).bounds
    size = min(float(max(east - west, north - south)) / _FULL_SIZE_M, 1.0)
    return _PROMINENCE.get(landmark.kind, 0.5) * (0.5 + 0.5 * size)


def askable_landmarks(
    city: CityMap, belief: NDArray[np.float64], mentioned: Collection[str] = (), most: int = 14
) -> tuple[str, ...]:
    """Return the ids of the landmarks to ask about: those nearest to the belief's mean.

    Parameters
    ----------
    city
        The map.
    belief
        Where the target is believed to be, shape (H, W).
    mentioned
        Landmarks that the person has spoken of, which they know.
    most
        How many, > 0.

    Returns
    -------
    tuple of str
        Those with a `salience` of at least .3 and those that were mentioned and have a name.
    """
    grid = city.grid
    x = float(belief.sum(0) @ grid.x_m)
    y = float(belief.sum(1) @ grid.y_m)
    scores = saliences(city)
    usable = [m for m, score in scores.items() if score >= _LEAST or (score and m in mentioned)]

    def away(landmark_id: str) -> float:
        at = city.centroid(landmark_id)
        return math.hypot(at[0] - x, at[1] - y)

    return tuple(sorted(usable, key=lambda m: (away(m), m))[:most])


def saliences(city: CityMap) -> Mapping[str, float]:
    """Return the `salience` of every landmark, kept with the map."""
    return city.derived("asking: salience", lambda: {m.id: salience(city, m.id)
                                                     for m in city.landmarks})  # fmt: skip
