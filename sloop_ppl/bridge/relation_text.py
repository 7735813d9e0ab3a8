"""Put relations and directions into a few words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from sloop_ppl.language import HEARER, NOT_ON_MAP, RELATIONS, WHOLE_MAP, SpatialRelation
from sloop_ppl.maps import CityMap
from sloop_ppl.maps._whereabouts import COMPASS_POINTS

if TYPE_CHECKING:
    from sloop_ppl.inference import Posterior

__all__ = ["distance_in_words", "facing", "ground_label", "percent", "relations_in_words"]

# Grounds that are named one by one; of more, "any of 7 places".
_MOST_LABELS = 3


def relations_in_words(posterior: Posterior, target: str) -> tuple[str, ...]:
    """Return each relation of a target in words, such as "behind Velvet Dog"; no two the same."""
    phrases: list[str] = []
    for relation in posterior.relations(target):
        words = _in_words(relation, posterior.city)
        again = sum(t == words or t.startswith(f"{words} (") for t in phrases)
        phrases.append(f"{words} ({again + 1})" if again else words)
    return tuple(phrases)


def facing(angle_rad: float) -> str:
    """Return the compass word nearest to an angle from east, anticlockwise.

    Examples
    --------
    >>> facing(-1.6)
    'south'
    """
    return COMPASS_POINTS[round(angle_rad / (math.pi / 4)) % 8]


def _in_words(relation: SpatialRelation, city: CityMap) -> str:
    labels = [ground_label(city, ground) for ground in relation.grounds]
    grounds = (" or " if relation.each else " and ").join(labels)
    if relation.each and len(labels) > _MOST_LABELS:
        grounds = f"any of {len(labels)} places, such as {labels[0]}"
    denied = "not " if relation.negated else ""
    far = f"{words} " if (words := distance_in_words(relation)) else ""
    return f"{denied}{far}{RELATIONS[relation.relation].phrase} {grounds}"


def ground_label(city: CityMap, ground: str) -> str:
    """Return what a ground is called: a landmark, the map, who listens, or another target."""
    if ground in city:
        return city.landmark(ground).label
    return {WHOLE_MAP: "the map", HEARER: "the hearer", NOT_ON_MAP: "no place here"}.get(
        ground, ground
    )


def distance_in_words(relation: SpatialRelation) -> str:
    """Return the distance that was said, such as "20 m" or "within 50 m"; empty when none was."""
    distance = relation.distance
    if distance is None or distance.stated_m is not None:
        return "" if distance is None else f"{distance.low_m:g} m"
    if math.isinf(distance.high_m):
        return f"at least {distance.low_m:g} m"
    if not distance.low_m:
        return f"within {distance.high_m:g} m"
    return f"{distance.low_m:g} to {distance.high_m:g} m"


def percent(p: float, places: int = 0) -> str:
    """Return a probability in percent; what is little but possible is not called 0%."""
    # The smallest number that shows at so many places; below half of it the text would round to 0.
    least = 10.0 ** -(places + 2)
    return f"<{least:.{places}%}" if 0 < p <= least / 2 else f"{p:.{places}%}"
