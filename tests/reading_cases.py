"""What tests of reading share: sentences in a file, each with the relations that it says."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from sloop_ppl.language import RELATIONS, SpatialRelation, parse
from sloop_ppl.maps import load_map

DATA = Path(__file__).parent / "language" / "data"
city = cache(load_map)


@dataclass(frozen=True)
class ReadingCase:
    """One sentence, and what it says."""

    kind: str
    map: str
    text: str
    wanted: str


def cases(name: str) -> list[ReadingCase]:
    """Return the sentences of a file: kind, map, text and relations, parted by bars."""
    lines = (DATA / f"{name}.txt").read_text("utf-8").splitlines()
    return [
        ReadingCase(*(part.strip() for part in line.split("|")))
        for line in lines
        if line and not line.startswith("#")
    ]


def faults(case: ReadingCase) -> list[str]:
    """Return what was missed, read wrongly, or at another distance; empty when all is right.

    Relations of one class mean the same; those after "?" may be read or not.
    """
    read = {_key(r): r for r in parse(case.text, city(case.map)).relations}
    found, known = [], set()
    for part in filter(None, (p.strip() for p in case.wanted.split(";"))):
        figure, *words = part.lstrip("?").split()
        denied = words[0] == "not"
        relation, grounds, *distance = words[denied:]
        key = (
            figure,
            RELATIONS[relation].relation_class,
            frozenset(grounds.split("+")),
            denied,
        )
        known.add(key)
        if key not in read:
            found += [] if part.startswith("?") else [f"missed: {part}"]
        elif distance and not _at(read[key], distance[0]):
            found.append(f"{read[key].distance}, not {distance[0]}")
    return found + [f"wrong: {read[key]}" for key in read if key not in known]


def _key(relation: SpatialRelation) -> tuple[str, str, frozenset[str], bool]:
    word = RELATIONS[relation.relation].relation_class
    return relation.figure, word, frozenset(relation.grounds), relation.negated


def _at(relation: SpatialRelation, bounds: str) -> bool:
    distance = relation.distance
    if distance is None:
        return False
    low, high = (float(b) for b in bounds.split(".."))
    return math.isclose(distance.low_m, low, abs_tol=0.02) and math.isclose(
        distance.high_m, high, abs_tol=0.02
    )
