"""Count what of descriptions was read right."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from sloop_ppl.eval._gold import READ_STATUSES, GoldEntry
from sloop_ppl.eval._matching import Match, ReadEntry, match, read_entries
from sloop_ppl.eval._parse_score import Entry, Miss, ParseScore
from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.language import NOT_ON_MAP, RELATIONS, Description, StreetPart

__all__ = ["ReadLine", "count_lines"]

_SAME_POINT = math.cos(math.pi / 8)
"""Compass points are 45 degrees apart; a bearing is that of the nearest."""

_HAS_TO_MATCH: Mapping[str, Callable[[Any], Hashable]] = {
    "tuple": lambda entry: (entry.figure, entry.relation),
    "class": lambda entry: (entry.figure, _class(entry)),
    "pair": lambda entry: entry.figure,
    "polarity": lambda entry: (entry.figure, _class(entry), entry.negated),
    "status": lambda entry: (entry.figure, _class(entry), entry.status),
}
"""Score -> what of an entry, beside its ground, has to be right."""


@dataclass(frozen=True)
class ReadLine:
    """One description with its gold and what was read."""

    annotated: AnnotatedDescription
    gold: tuple[GoldEntry, ...]
    read: Description

    def matched(self, score: str) -> Match[Hashable]:
        """Return what is right in one sense; what is not to be read is no gold."""
        key = _HAS_TO_MATCH[score]
        entries = [entry for entry in self.gold if entry.is_read or entry.optional]
        entries = [entry if entry.is_read else replace(entry, optional=True) for entry in entries]
        return match(entries, read_entries(self.read), key, key)


def count_lines(lines: Sequence[ReadLine]) -> ParseScore:
    """Count right and wrong entries over all descriptions."""
    counts = {score: Counter[str]() for score in _HAS_TO_MATCH}
    by_relation: dict[str, Counter[str]] = {}
    by_status: dict[str, Counter[str]] = {}
    by_phenomenon: dict[str, Counter[str]] = {}
    by_class: dict[str, Counter[str]] = {}
    by_part: dict[str, Counter[str]] = {}
    linked, grounds, false_positives = 0, 0, 0
    misses = []
    for line in lines:
        made = {score: line.matched(score) for score in _HAS_TO_MATCH}
        for score, matched in made.items():
            _count(counts[score], matched)
        _count_by(by_relation, made["tuple"], lambda entry: entry.relation)
        _count_by(by_status, made["status"], lambda entry: entry.status)
        _count_unread(by_status, line.gold, made["polarity"])
        wanted, held = _links(line)
        linked, grounds = linked + held, grounds + wanted
        polarity = made["polarity"]
        false_positives += len(polarity.wrong)
        whole = not polarity.wrong and not polarity.missed
        if not whole:
            misses.append(_miss(line, polarity))
        for name in line.annotated.phenomena:
            counter = by_phenomenon.setdefault(name, Counter())
            counter["lines"] += 1
            counter["whole"] += whole
            _count(counter, polarity)
        for entry in (*polarity.right.values(), *polarity.missed):
            if entry.ground_class is not None:
                by_class.setdefault(entry.ground_class, Counter())["n"] += 1
        for entry in polarity.right.values():
            if entry.ground_class is not None:
                by_class[entry.ground_class]["right"] += 1
        _count_parts(by_part, polarity)
    tuples = _rates(counts["tuple"])
    return ParseScore(
        n=len(lines),
        tuple_f1=tuples["f1"],
        class_f1=_rates(counts["class"])["f1"],
        pair_f1=_rates(counts["pair"])["f1"],
        precision=tuples["precision"],
        recall=tuples["recall"],
        per_relation={r: _rates(by_relation[r]) for r in RELATIONS if r in by_relation},
        misses=tuple(misses),
        polarity_f1=_rates(counts["polarity"])["f1"],
        linking_recall=round(linked / grounds, 6) if grounds else 1.0,
        wholly_right=len(lines) - len(misses),
        false_positives=false_positives,
        statuses=_status_rates(by_status),
        phenomena={
            name: {
                "n": counter["lines"],
                "wholly_right": counter["whole"],
                "f1": _rates(counter)["f1"],
                "false_positives": counter["found"] - counter["true"],
            }
            for name, counter in sorted(by_phenomenon.items())
        },
        classes=_class_rates(by_class, counts["polarity"]),
        parts={
            kind: {"n": counter["n"], "read_right": round(counter["right"] / counter["n"], 6)}
            for kind, counter in sorted(by_part.items())
        },
    )


def _class(entry: GoldEntry | ReadEntry) -> str:
    return RELATIONS[entry.relation].relation_class


def _count(counter: Counter[str], matched: Match[Hashable]) -> None:
    counter["true"] += len(matched.right)
    counter["gold"] += len(matched.right) + len(matched.missed)
    counter["found"] += len(matched.right) + len(matched.wrong)
    counter["passed"] += len(matched.passed)


def _count_by(
    counters: dict[str, Counter[str]],
    matched: Match[Hashable],
    name: Callable[[GoldEntry | ReadEntry], str],
) -> None:
    """Count apart what `name` calls differently; what is right has one name in gold and reading."""
    for entry in matched.right.values():
        counters.setdefault(name(entry), Counter()).update(("true", "gold", "found"))
    for missed in matched.missed:
        counters.setdefault(name(missed), Counter()).update(("gold",))
    for wrong in matched.wrong:
        counters.setdefault(name(wrong), Counter()).update(("found",))


def _count_unread(
    counters: dict[str, Counter[str]], gold: Iterable[GoldEntry], polarity: Match[Hashable]
) -> None:
    """Count what is asked, retracted or past, and what of it is among the wrongly read."""
    key = _HAS_TO_MATCH["class"]
    unread = [replace(e, optional=False) for e in gold if not e.is_read and not e.optional]
    found = match(unread, polarity.wrong, key, key)
    for entry in (*found.right.values(), *found.missed):
        counters.setdefault(entry.status, Counter())["gold"] += 1
    for entry in found.right.values():
        counters[entry.status]["true"] += 1


def _count_parts(counters: dict[str, Counter[str]], polarity: Match[Hashable]) -> None:
    """Count the parts that the gold gives, and which of them were read."""
    pairs = [(entry.part, read.part) for read, entry in polarity.right.items()]
    for wanted, read in (*pairs, *((entry.part, None) for entry in polarity.missed)):
        if wanted is None:
            continue
        for name in (wanted.kind, "all"):
            counters.setdefault(name, Counter()).update(n=1, right=_is_same_part(wanted, read))


def _is_same_part(wanted: StreetPart, read: StreetPart | None) -> bool:
    """Whether two parts are of one kind and number, and face the same point of the compass."""
    if read is None or (wanted.kind, wanted.number) != (read.kind, read.number):
        return False
    if wanted.bearing_rad is None or read.bearing_rad is None:
        return wanted.bearing_rad is read.bearing_rad
    return math.cos(wanted.bearing_rad - read.bearing_rad) > _SAME_POINT


def _status_rates(counters: Mapping[str, Counter[str]]) -> dict[str, dict[str, float]]:
    read = {name: _rates(counters[name]) for name in READ_STATUSES if name in counters}
    unread: dict[str, dict[str, float]] = {
        name: {"n": counter["gold"], "read": counter["true"]}
        for name, counter in sorted(counters.items())
        if name not in READ_STATUSES
    }
    return {**read, **unread}


def _class_rates(
    counters: Mapping[str, Counter[str]], all_: Counter[str]
) -> dict[str, dict[str, float]]:
    if not counters:
        return {}
    by_class = {
        name: {"n": counter["n"], "read_right": round(counter["right"] / counter["n"], 6)}
        for name, counter in sorted(counters.items())
    }
    wrong, found = all_["found"] - all_["true"], all_["found"] + all_["passed"]
    whole = {
        "n": all_["gold"],
        "read_right": _rates(all_)["recall"],
        "wrong_among_read": round(wrong / found, 6) if found else 0.0,
    }
    return {**by_class, "all": whole}


def _links(line: ReadLine) -> tuple[int, int]:
    """Return how many grounds the gold has, and how many of them are among what was linked."""
    read = line.read
    linked = {
        candidate.ground
        for reading in (read.relations, *(reading.relations for reading in read.readings))
        for relation in reading
        for slot in range(len(relation.grounds))
        for candidate in relation.slot(slot)
    }
    linked |= {candidate for one in read.unresolved for candidate in one.candidates}
    wanted = {
        entry.accepted
        for entry in line.gold
        if entry.is_read and not entry.optional and entry.ground is not None
    }
    return len(wanted), sum(bool(accepted & linked) for accepted in wanted)


def _miss(line: ReadLine, polarity: Match[Hashable]) -> Miss:
    def shown(entry: GoldEntry | ReadEntry, ground: str) -> Entry:
        return entry.figure, ("not " if entry.negated else "") + entry.relation, ground

    missed = sorted(shown(e, e.ground or f"({e.kind})") for e in polarity.missed)
    spurious = sorted(
        shown(e, f"({' '.join(sorted(e.words))})" if e.ground == NOT_ON_MAP else e.ground)
        for e in polarity.wrong
    )
    return Miss(line.annotated.id, line.read.text, tuple(missed), tuple(spurious))


def _rates(counter: Counter[str]) -> dict[str, float]:
    """Return precision, recall and F1; 1 where there was nothing to find and nothing found."""
    true, gold, found = counter["true"], counter["gold"], counter["found"]
    return {
        "n": gold,
        "precision": round(true / found, 6) if found else float(not gold),
        "recall": round(true / gold, 6) if gold else float(not found),
        "f1": round(2 * true / (gold + found), 6) if gold + found else 1.0,
    }
