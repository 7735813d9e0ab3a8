"""Score what a parser reads against gold relations."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.eval._corruption import merge_maps, misspell
from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.language import RELATIONS, Description, SpatialRelation, parse
from sloop_ppl.language.parsers import Parser
from sloop_ppl.maps import CityMap, load_map
from sloop_ppl.rng import child

__all__ = ["Miss", "ParseScore", "score_parser"]

Entry = tuple[str, str, str]


@dataclass(frozen=True)
class Miss:
    """A description that was not read as its gold says.

    Parameters
    ----------
    id, text
        The description, as it was given to the parser.
    missed, spurious
        (figure, relation, ground) that only the gold, or only the parser, has.
    """

    id: str
    text: str
    missed: tuple[Entry, ...]
    spurious: tuple[Entry, ...]


@dataclass(frozen=True)
class ParseScore:
    """How well a parser read a set of descriptions.

    Parameters
    ----------
    n
        Number of descriptions.
    tuple_f1, class_f1, pair_f1
        Micro F1 in [0, 1] of (figure, relation, ground), of the same with the relation's class, and
        of (figure, ground).
    precision, recall
        Precision and recall of the tuples, in [0, 1].
    per_relation
        Relation -> ``n`` (in the gold), ``precision``, ``recall``, ``f1``.
    misses
        The descriptions that were read otherwise, in order.
    """

    n: int
    tuple_f1: float
    class_f1: float
    pair_f1: float
    precision: float
    recall: float
    per_relation: dict[str, dict[str, float]] = field(default_factory=dict)
    misses: tuple[Miss, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Return the value that ``sloop eval parse --json`` prints."""
        return {
            "n": self.n,
            "tuple_f1": self.tuple_f1,
            "class_f1": self.class_f1,
            "pair_f1": self.pair_f1,
            "precision": self.precision,
            "recall": self.recall,
            "per_relation": self.per_relation,
        }


def score_parser(
    descriptions: Sequence[AnnotatedDescription],
    find_map: Callable[[str], CityMap] = load_map,
    parser: str | Parser = "rules",
    *,
    merged: Iterable[CityMap] | None = None,
    misspelt: float = 0.0,
    rng: np.random.Generator | None = None,
) -> ParseScore:
    """Read every description with a parser and compare with its gold relations.

    Parameters
    ----------
    descriptions
        The descriptions; those that declare targets are read for these alone.
    find_map
        Gives the map of a description by name.
    parser
        Name of a registered parser, or a parser.
    merged
        Maps whose landmarks are put into one inventory, which every description is then read on;
        each description's own map is among them. None reads it on its own map.
    misspelt
        Share of the words of five letters or more that get one wrong letter, in [0, 1].
    rng
        Draws the slips; needed when `misspelt` is not 0. Each description has a stream of its own,
        so that it is spelt the same whichever others there are.

    Returns
    -------
    ParseScore
        Entries are counted as sets per description and figure: a relation with several grounds
        is one entry per ground.

    Raises
    ------
    InputError
        When there is no description, when `misspelt` is outside [0, 1], or when it is not 0 and no
        `rng` is given.
    """
    if not descriptions:
        raise InputError("There is no description to score; expected at least one")
    if not 0.0 <= misspelt <= 1.0:
        raise InputError(f"The share of misspelt words is {misspelt:g}; expected 0 to 1")
    if misspelt and rng is None:
        raise InputError("Misspelling draws at random and no rng was given; give one")
    one_map = None if merged is None else merge_maps(merged)
    maps: dict[str, CityMap] = {}
    pairs = []
    for annotated in descriptions:
        text = annotated.text
        if rng is not None and misspelt:
            text = misspell(text, misspelt, rng=child(rng, "misspell", annotated.id))
        city = (
            one_map
            or maps.get(annotated.map)
            or maps.setdefault(annotated.map, find_map(annotated.map))
        )
        read = parse(text, city, annotated.objects or None, parser, annotated.viewpoint)
        gold = _entries(annotated.relations, "" if one_map is None else f"{annotated.map}/")
        pairs.append((annotated.id, gold, read))
    return _score(pairs)


def _entries(relations: Iterable[SpatialRelation], prefix: str = "") -> set[Entry]:
    return {(r.figure, r.relation, prefix + ground) for r in relations for ground in r.grounds}


def _score(pairs: Sequence[tuple[str, set[Entry], Description]]) -> ParseScore:
    """Count true and false entries over all descriptions."""
    counts = {"tuple": Counter[str](), "class": Counter[str](), "pair": Counter[str]()}
    by_relation: dict[str, Counter[str]] = {}
    misses = []
    for name, gold, read in pairs:
        found = _entries(read.relations)
        _count(counts["tuple"], gold, found)
        _count(counts["class"], _classes(gold), _classes(found))
        _count(counts["pair"], {(f, g) for f, _, g in gold}, {(f, g) for f, _, g in found})
        for relation in {r for _, r, _ in gold | found}:
            _count(
                by_relation.setdefault(relation, Counter()),
                {e for e in gold if e[1] == relation},
                {e for e in found if e[1] == relation},
            )
        if found != gold:
            missed, spurious = sorted(gold - found), sorted(found - gold)
            misses.append(Miss(name, read.text, tuple(missed), tuple(spurious)))
    tuples = _rates(counts["tuple"])
    order = [r for r in RELATIONS if r in by_relation]
    return ParseScore(
        n=len(pairs),
        tuple_f1=tuples["f1"],
        class_f1=_rates(counts["class"])["f1"],
        pair_f1=_rates(counts["pair"])["f1"],
        precision=tuples["precision"],
        recall=tuples["recall"],
        per_relation={r: _rates(by_relation[r]) for r in order},
        misses=tuple(misses),
    )


def _classes(entries: set[Entry]) -> set[Entry]:
    return {(f, RELATIONS[r].relation_class, g) for f, r, g in entries}


def _count(counter: Counter[str], gold: set[Any], found: set[Any]) -> None:
    counter["true"] += len(gold & found)
    counter["gold"] += len(gold)
    counter["found"] += len(found)


def _rates(counter: Counter[str]) -> dict[str, float]:
    """Return precision, recall and F1; 1 where there was nothing to find and nothing found."""
    true, gold, found = counter["true"], counter["gold"], counter["found"]
    return {
        "n": gold,
        "precision": round(true / found, 6) if found else float(not gold),
        "recall": round(true / gold, 6) if gold else float(not found),
        "f1": round(2 * true / (gold + found), 6) if gold + found else 1.0,
    }
