"""The paper's tables: rewards by preposition, by number of relations, and by good frames."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from sloop_ppl.eval import _paper as paper
from sloop_ppl.eval._facts import RelationFacts, plain_word
from sloop_ppl.eval._significance import t_estimate
from sloop_ppl.eval._tables import Cell, Estimate, Table
from sloop_ppl.eval.results import Results, TargetKey
from sloop_ppl.language import RELATIONS

__all__ = ["frame_table", "table_one", "table_two"]

_T = (
    "Brackets: 95 % t-intervals over described targets, none below five; the starts of a target "
    "are averaged."
)


def table_one(results: Results) -> Table:
    """Return the paper's Table I: discounted reward by preposition.

    A target counts once for each preposition that is said of it. Front and behind are split
    into good and bad ones; see :class:`sloop_ppl.eval._facts.TargetFacts`.
    """
    compass = {record.relation_class for record in RELATIONS.values() if record.is_compass}
    framed = {record.relation_class for record in RELATIONS.values() if record.needs_frame}
    rows: list[tuple[Cell, ...]] = []
    for title, wanted in (
        ("general", lambda r: r.relation_class not in (*compass, *framed)),
        ("compass", lambda r: r.relation_class in compass),
        ("frame", lambda r: r.relation_class in framed),
    ):
        found = _by_word(results, wanted)
        if found:
            rows.append((title, *[None] * (1 + len(_shown(results)))))
        rows += [_row(results, word, targets) for word, targets in found.items()]
    split = []
    for word in ("front", "behind"):
        for good in (True, False):
            targets = [
                key
                for key, facts in results.facts.items()
                if facts.good is good and any(r.relation_class == word for r in facts.relations)
            ]
            if targets:
                split.append(_row(results, f"{word}, {'good' if good else 'bad'}", targets))
    if split:
        rows += [("front and behind, split", *[None] * (1 + len(_shown(results)))), *split]
    return Table(
        "table1",
        f"Discounted reward by preposition, range {results.table_range:g}, "
        f"{results.manifest['relations']} relations (the paper's Table I)",
        ("preposition", "n", *_heads(results)),
        tuple(rows),
        (
            _T,
            (
                "A target counts once for each preposition that is said of it. The figures of the "
                "paper's own Table I were not at hand; those of its Table II stand beside ours."
            ),
        ),
    )


def table_two(results: Results) -> Table:
    """Return the paper's Table II: discounted reward by number of relations, the paper's beside."""
    groups = (("1", 1, 1), ("2", 2, 2), ("3 or more", 3, None))
    compared = [model for model in _shown(results) if model in paper.TABLE_TWO]
    rows: list[tuple[Cell, ...]] = []
    for place, (name, low, high) in enumerate(groups):
        targets = [
            key
            for key, facts in results.facts.items()
            if low <= len(facts.relations) <= (high or len(facts.relations))
        ]
        theirs = [paper.TABLE_TWO[model][place] for model in compared]
        row = (*_row(results, name, targets), paper.TABLE_TWO_TRIALS[place], *theirs)
        if targets:
            rows.append(row)
    none = [key for key, facts in results.facts.items() if not facts.relations]
    if none:
        rows.append((*_row(results, "none", none), *[None] * (1 + len(compared))))
    trials = sum(paper.TABLE_TWO_TRIALS)
    means = [
        float(round(np.average(paper.TABLE_TWO[model], weights=paper.TABLE_TWO_TRIALS)))
        for model in compared
    ]
    rows.append((*_row(results, "all", list(results.facts)), trials, *means))
    return Table(
        "table2",
        f"Discounted reward by number of relations, range {results.table_range:g}, "
        f"{results.manifest['relations']} relations (the paper's Table II)",
        (
            "relations",
            "n",
            *_heads(results),
            "paper: n",
            *(f"paper: {paper.NAMES[model]}" for model in compared),
        ),
        tuple(rows),
        (
            _T,
            (
                "The paper's trials were on five cities, with other maps and starts; its third row "
                "has exactly three relations."
            ),
        ),
    )


def frame_table(results: Results) -> Table:
    """Return the rewards where the frames were predicted as the speaker meant them, or not."""
    rows = [
        _row(results, name, targets)
        for name, good in (
            ("all frame relations good", True),
            ("some frame relation bad", False),
            ("no frame relation", None),
        )
        if (targets := [key for key, facts in results.facts.items() if facts.good is good])
    ]
    return Table(
        "frames",
        f"Discounted reward with good and bad frames, range {results.table_range:g}",
        ("trials", "n", *_heads(results)),
        tuple(rows),
        (
            _T,
            (
                "Good: for every front, behind, left and right of the trial, the bearing of the "
                "target from the ground's centroid has a positive cosine with the predicted "
                "direction (fronts from the nearest street, left and right those of the map)."
            ),
        ),
    )


def _shown(results: Results) -> tuple[str, ...]:
    """Return the models of the paper's tables, or all where none of them was run."""
    return tuple(m for m in paper.SHOWN if m in results.models) or results.models


def _heads(results: Results) -> list[str]:
    return [paper.NAMES.get(model, model) for model in _shown(results)]


def _by_word(
    results: Results, wanted: Callable[[RelationFacts], bool]
) -> dict[str, list[TargetKey]]:
    """Return word (or compass or frame class) -> targets, the most frequent first."""
    found: dict[str, dict[TargetKey, None]] = {}
    for key, facts in results.facts.items():
        for relation in facts.relations:
            if wanted(relation):
                found.setdefault(plain_word(relation.relation), {})[key] = None
    order = sorted(found, key=lambda word: (-len(found[word]), word))
    return {word: list(found[word]) for word in order}


def _row(results: Results, name: str, targets: Iterable[TargetKey]) -> tuple[Cell, ...]:
    targets = list(targets)
    cells: list[Estimate | None] = []
    for model in _shown(results):
        values = results.rewards(model, results.table_range, targets)
        cells.append(t_estimate(list(values.values())) if values else None)
    return (name, len(targets), *cells)
