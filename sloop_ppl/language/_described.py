"""Weigh places by what is said of them: "the bar inside the Bradley", "the northern kiosk"."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from sloop_ppl.maps import CityMap

__all__ = ["fits_relation", "is_open_area", "most_towards"]

_REACH_M: Mapping[str, float] = {"next": 12.0, "adjacent": 12.0, "beside": 15.0, "by": 15.0}
"""Metres within which a place is "next to" another; half the weight is lost every 0.7 of it."""

_NEAR_M = 25.0
_ACROSS_M = 30.0
_DIRECTED_M = 60.0
_INSIDE_M = 4.0
_AT_M = 8.0
_SIDE_M = 20.0
_SPREAD = 4.0
"""The share of its span, one quarter, over which the northernmost place is e times as probable."""

_COMPASS = {
    "north": 90.0, "northeast": 45.0, "east": 0.0, "southeast": -45.0, "south": -90.0,
    "southwest": -135.0, "west": 180.0, "northwest": 135.0, "top": 90.0, "up": 90.0,
    "above": 90.0, "below": -90.0, "down": -90.0, "under": -90.0, "left": 180.0, "right": 0.0,
}  # fmt: skip
_CONTAINING = frozenset(("in", "inside", "within"))
_TOUCHING = frozenset(("on", "at", "along", "side"))
_AREAS = frozenset(("parking", "park", "street", "service", "pedestrian", "square", "water"))


def is_open_area(landmark_ids: Sequence[str], city: CityMap) -> bool:
    """Whether places are areas in the open, such as car parks and alleys."""
    return bool(landmark_ids) and all(city.landmark(i).kind in _AREAS for i in landmark_ids)


def fits_relation(relation: str, place: str, ground: str, city: CityMap) -> float:
    """Return how well a place stands in a relation to another, in [0, 1].

    A plain score on what the two cover, for choosing among places of a kind only: exp(-d / reach)
    of the distance d between them, times the cosine from the direction that was said.

    Parameters
    ----------
    relation
        Canonical relation.
    place, ground
        Ids of the two landmarks.
    city
        Their map.
    """
    if place == ground:
        return 0.0
    a, b = city.landmark(place), city.landmark(ground)
    whole = city.footprint(ground) if a.kind == "building" else b.geometry
    if relation not in _CONTAINING and b.kind == "poi" and whole.equals(a.geometry):
        return 0.05  # what a shop stands in is not next to it
    between_m = float(a.geometry.distance(whole))
    if relation in _CONTAINING:
        if a.within == ground:
            return 1.0
        return math.exp(-between_m / _INSIDE_M) if _may_hold(ground, city) else 0.0
    if relation in _TOUCHING:
        return math.exp(-between_m / _AT_M)
    if relation in _COMPASS:
        return math.exp(-between_m / _DIRECTED_M) * _towards(place, ground, relation, city)
    if relation in ("front", "behind"):
        return math.exp(-between_m / _SIDE_M)
    if relation == "across":
        return math.exp(-abs(between_m - _ACROSS_M) / _ACROSS_M)
    return math.exp(-between_m / _REACH_M.get(relation, _NEAR_M))


def _may_hold(ground: str, city: CityMap) -> bool:
    return city.landmark(ground).kind != "poi"


def _towards(place: str, ground: str, relation: str, city: CityMap) -> float:
    (x, y), (gx, gy) = city.centroid(place), city.centroid(ground)
    away = math.atan2(y - gy, x - gx) - math.radians(_COMPASS[relation])
    return max(0.0, math.cos(away))


def most_towards(direction: str, places: Mapping[str, float], city: CityMap) -> dict[str, float]:
    """Return the weights of places where the one farthest in a direction is meant.

    Parameters
    ----------
    direction
        Canonical relation of a direction; others leave the weights as they are.
    places
        Id -> weight.
    city
        The map.

    Returns
    -------
    dict
        Id -> weight times exp(-4 d / s): d is how far it lies behind the farthest one in that
        direction, s the span of all.
    """
    if direction not in _COMPASS or len(places) < 2:
        return dict(places)
    angle = math.radians(_COMPASS[direction])
    along = {}
    for place in places:
        x, y = city.centroid(place)
        along[place] = x * math.cos(angle) + y * math.sin(angle)
    farthest = max(along.values())
    span = max(farthest - min(along.values()), 1e-9)
    return {p: w * math.exp(-_SPREAD * (farthest - along[p]) / span) for p, w in places.items()}
