"""Put relations and directions into a few words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from sloop_ppl.language import RELATIONS, SpatialRelation
from sloop_ppl.maps import CityMap
from sloop_ppl.maps._whereabouts import COMPASS_POINTS

if TYPE_CHECKING:
    from sloop_ppl.inference import Posterior

__all__ = ["facing", "percent", "relations_in_words"]

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
    labels = [
        city.landmark(ground).label if ground in city else "the map" for ground in relation.grounds
    ]
    grounds = (" or " if relation.each else " and ").join(labels)
    if relation.each and len(labels) > _MOST_LABELS:
        grounds = f"any of {len(labels)} places, such as {labels[0]}"
    denied = "not " if relation.negated else ""
    far = f"{relation.distance_m:g} m " if relation.distance_m is not None else ""
    return f"{denied}{far}{RELATIONS[relation.relation].phrase} {grounds}"


def percent(p: float, places: int = 0) -> str:
    """Return a probability in percent; what is little but possible is not called 0%."""
    # The smallest number that shows at so many places; below half of it the text would round to 0.
    least = 10.0 ** -(places + 2)
    return f"<{least:.{places}%}" if 0 < p <= least / 2 else f"{p:.{places}%}"
