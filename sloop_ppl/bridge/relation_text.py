"""Put relations and directions into a few words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from sloop_ppl.language import HEARER, NOT_ON_MAP, RELATIONS, WHOLE_MAP, SpatialRelation
from sloop_ppl.language._part_words import part_in_words
from sloop_ppl.language._place_names import PlaceNames
from sloop_ppl.maps._whereabouts import COMPASS_POINTS

if TYPE_CHECKING:
    from sloop_ppl.inference import GroundPosterior, Posterior
    from sloop_ppl.language import Reading

__all__ = [
    "distance_in_words",
    "facing",
    "ground_label",
    "meant_lines",
    "names_of",
    "percent",
    "reading_in_words",
    "reading_lines",
    "relation_in_words",
    "relations_in_words",
]

# Grounds that are named one by one; of more, "any of 7 places".
_MOST_LABELS = 3
_MOST_PLACES = 4
# Share of the places that a mention may be, from which the first one alone is named.
_SURE = 0.9
# Cosine of the greatest angle between a compass word and the bearing of "upper left" (45 degrees).
_ALIKE = 0.7
# Readings that are less probable, before and after, are not reported.
_LEAST_READING = 0.01


def relations_in_words(posterior: Posterior, target: str) -> tuple[str, ...]:
    """Return each relation of a target in words, such as "behind Velvet Dog"; no two the same."""
    phrases: list[str] = []
    names = names_of(posterior)
    for relation in posterior.relations(target):
        words = relation_in_words(relation, names)
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


def meant_lines(posterior: Posterior, target: str) -> list[str]:
    """Return a line for each mention whose place is open: what it probably is.

    Such as ``"a bank": Chase 0.71, KeyBank 0.22, not on this map 0.07``.
    """
    lines: dict[str, None] = {}
    names = names_of(posterior)
    texts = _texts_of(posterior, target)
    for ground in posterior.grounds(target):
        if not ground.is_open or ground.relation.each or ground.relation.negated:
            continue
        words = _mention(ground, texts[ground.index], names)
        shares = [
            f"{_place(candidate.ground, names)} {candidate.p:.2f}"
            for candidate in ground.candidates[:_MOST_PLACES]
        ]
        rest = ground.candidates[_MOST_PLACES:]
        if rest:
            shares.append(f"{len(rest)} others {sum(c.p for c in rest):.2f}")
        lines[f"{words}: {', '.join(shares)}"] = None
    return list(lines)


def reading_lines(posterior: Posterior) -> list[str]:
    """Return a line for each description with several readings: which was probably meant."""
    lines = []
    names = names_of(posterior)
    for which, description in enumerate(posterior.descriptions):
        readings = [
            one for one in posterior.readings(which) if max(one.p, one.prior) >= _LEAST_READING
        ]
        if len(readings) > 1:
            several = len(description.targets) > 1
            shares = [
                f"{reading_in_words(one.reading, names, several)} {one.p:.2f} (was {one.prior:.2f})"
                for one in sorted(readings, key=lambda one: -one.p)
            ]
            lines.append(f"reading: {', '.join(shares)}")
    return lines


def reading_in_words(reading: Reading, names: PlaceNames, several: bool) -> str:
    """Return what a reading says, the sides of an alternative with "or" between them."""
    words = ""
    before: tuple[int, int] | None = None
    for relation in reading.relations:
        either = relation.either
        is_other = either is not None and before is not None and either[0] == before[0]
        link = " or " if is_other and either != before else ", "
        figure = f"{relation.figure} " if several else ""
        words += f"{link if words else ''}{figure}{relation_in_words(relation, names)}"
        before = either
    return f"“{words}”" if words else "nothing of it"


def _texts_of(posterior: Posterior, target: str) -> list[str]:
    """Return the text of each relation of a target."""
    return [
        description.text
        for factor in posterior.factors
        if target in factor.log_factors
        for description in factor.descriptions
        for _ in description.about(target)
    ]


def _mention(ground: GroundPosterior, text: str, names: PlaceNames) -> str:
    """Return the words of a mention, or else the relation it stands in."""
    spans = ground.relation.spans
    if spans is not None and ground.slot < len(spans.grounds):
        start, end = spans.grounds[ground.slot]
        return f"“{text[start:end]}”"
    return f"“{relation_in_words(ground.relation, names)}”"


def _place(ground: str | None, names: PlaceNames) -> str:
    return "not on this map" if ground is None else ground_label(names, ground)


def relation_in_words(relation: SpatialRelation, names: PlaceNames) -> str:
    """Return a relation in words, such as "not 20 m north of Velvet Dog".

    A mention that may be several places is called by those that it may be, "Ivy or Barley House",
    or "Ivy or one of 6 others": by its first one alone it would read as if that were known.
    """
    if relation.each:
        labels = [ground_label(names, ground) for ground in relation.grounds]
    else:
        labels = [_mentioned(relation, i, names) for i in range(len(relation.grounds))]
    grounds = (" or " if relation.each else " and ").join(labels)
    if relation.each and len(labels) > _MOST_LABELS:
        grounds = f"any of {len(labels)} places, such as {labels[0]}"
    denied = "not " if relation.negated else ""
    far = f"{words} " if (words := distance_in_words(relation)) else ""
    phrase = RELATIONS[relation.relation].phrase
    if relation.part is None:
        return f"{denied}{far}{phrase} {grounds}"
    if _is_side_of(relation):
        phrase = "on"
    if relation.part.kind != "number":
        phrase = f"{phrase} the"
    return f"{denied}{far}{phrase} {part_in_words(relation.part, grounds)}"


def _mentioned(relation: SpatialRelation, index: int, names: PlaceNames) -> str:
    """Return what one mention of a relation may be, or is where that is all but certain."""
    places = [c for c in relation.slot(index) if c.ground is not None]
    label = ground_label(names, relation.grounds[index])
    if len(places) < 2 or places[0].probability >= _SURE * sum(c.probability for c in places):
        return label
    others = [c.ground for c in places if c.ground != relation.grounds[index]]
    if len(others) == 1:
        return f"{label} or {ground_label(names, str(others[0]))}"
    return f"{label} or one of {len(others)} others"


def _is_side_of(relation: SpatialRelation) -> bool:
    """Whether the direction of a relation is that of its part: "north" of "the north side of"."""
    record, part = RELATIONS[relation.relation], relation.part
    if part is None or part.bearing_rad is None or part.kind == "number":
        return False
    return record.is_compass and math.cos((record.bearing_rad or 0.0) - part.bearing_rad) > _ALIKE


def names_of(posterior: Posterior) -> PlaceNames:
    """Return what the places of a posterior's map are called to who described it."""
    return PlaceNames(posterior.city, posterior.descriptions)


def ground_label(names: PlaceNames, ground: str) -> str:
    """Return what a ground is called: a landmark, the map, who listens, or another target."""
    if ground in names.city:
        return names.of(ground)
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
