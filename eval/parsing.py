"""Score what a parser reads against gold relations."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.eval._calibration import Calibration, calibration
from sloop_ppl.eval._corruption import merge_maps, misspell
from sloop_ppl.eval._gold import GoldEntry
from sloop_ppl.eval._parse_counts import ReadLine, count_lines
from sloop_ppl.eval._parse_score import Miss, ParseScore
from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.language import HEARER, SPEAKER, WHOLE_MAP, parse
from sloop_ppl.language.parsers import Parser
from sloop_ppl.maps import CityMap, load_map
from sloop_ppl.rng import child

__all__ = ["Miss", "ParseScore", "score_parser"]


def score_parser(
    descriptions: Sequence[AnnotatedDescription],
    find_map: Callable[[str], CityMap] = load_map,
    parser: str | Parser = "rules",
    *,
    merged: Iterable[CityMap] | None = None,
    misspelt: float = 0.0,
    confidence: bool = False,
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
    confidence
        Whether the parser's confidence is to be judged.
    rng
        Draws the slips and, for `confidence`, the bootstrap; needed by these. Each description has
        a stream of its own, so that it is spelt the same whichever others there are.

    Returns
    -------
    ParseScore
        Entries are counted as sets per description and figure: a relation with several grounds
        is one entry per ground. Where a gold entry accepts several grounds, what was read is
        assigned so that as much as possible is right. An optional entry counts only to excuse what
        was read; what is asked, retracted or past is no gold at all.

    Raises
    ------
    InputError
        When there is no description or none with gold, when `misspelt` is outside [0, 1], or when
        no `rng` is given and it is needed.
    """
    if not descriptions:
        raise InputError("There is no description to score; expected at least one")
    if not 0.0 <= misspelt <= 1.0:
        raise InputError(f"The share of misspelt words is {misspelt:g}; expected 0 to 1")
    if misspelt and rng is None:
        raise InputError("Misspelling draws at random and no rng was given; give one")
    if confidence and rng is None:
        raise InputError("Intervals are drawn at random and no rng was given; give one")
    annotated_ones = [one for one in descriptions if one.has_gold]
    if not annotated_ones:
        raise InputError(
            "No description says what is to be read in it; expected 'relations' in at least one"
        )
    one_map = None if merged is None else merge_maps(merged)
    maps: dict[str, CityMap] = {}
    lines = []
    for annotated in annotated_ones:
        text = annotated.text
        if rng is not None and misspelt:
            text = misspell(text, misspelt, rng=child(rng, "misspell", annotated.id))
        city = (
            one_map
            or maps.get(annotated.map)
            or maps.setdefault(annotated.map, find_map(annotated.map))
        )
        read = parse(
            text,
            city,
            annotated.objects or None,
            parser,
            annotated.viewpoint,
            hearer=annotated.hearer,
        )
        gold = annotated.gold if one_map is None else _in_inventory(annotated)
        lines.append(ReadLine(annotated, gold, read))
    found = count_lines(lines)
    return replace(
        found,
        not_scored=len(descriptions) - len(annotated_ones),
        confidence=_judged(lines, child(rng, "confidence")) if confidence and rng else None,
    )


def _in_inventory(annotated: AnnotatedDescription) -> tuple[GoldEntry, ...]:
    """Return the gold with the ids that its grounds have among the landmarks of several maps."""
    own = {WHOLE_MAP, HEARER, SPEAKER, *(target.id for target in annotated.objects)}

    def moved(ground: str) -> str:
        return ground if ground in own else f"{annotated.map}/{ground}"

    return tuple(
        replace(
            entry,
            ground=None if entry.ground is None else moved(entry.ground),
            also=tuple(map(moved, entry.also)),
        )
        for entry in annotated.gold
    )


def _judged(lines: Sequence[ReadLine], rng: np.random.Generator) -> Calibration:
    """Judge the confidence of every relation that was read, by class, grounds and polarity."""
    stated, right, clusters = [], [], []
    for line in lines:
        wrong = {source for one in line.matched("polarity").wrong for source in one.sources}
        for number, relation in enumerate(line.read.relations):
            stated.append(relation.confidence)
            right.append(number not in wrong)
            clusters.append(line.annotated.id)
    return calibration(stated, right, clusters, rng=rng)
