"""Score a parser on description files, and word the score."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.eval._calibration import Calibration
from sloop_ppl.eval._inventory import all_maps, map_finder
from sloop_ppl.eval.descriptions import read_descriptions
from sloop_ppl.eval.parsing import Miss, ParseScore, score_parser
from sloop_ppl.language.parsers import Parser, find_parser

if TYPE_CHECKING:
    from rich.console import RenderableType

__all__ = ["parse_score_lines", "score_files"]

_COUNTS = ("n", "read", "wholly_right", "false_positives")


def score_files(
    files: Sequence[str | Path],
    *,
    maps: str | Path | None = None,
    parser: str | Parser = "rules",
    nlp: str | None = None,
    merged: bool = False,
    misspelt: float = 0.0,
    annotations: str | Path | None = None,
    confidence: bool = False,
    seed: int = 0,
) -> ParseScore:
    """Read the descriptions of some files with a parser and score it.

    Parameters
    ----------
    files
        Description files.
    maps
        Folder of map files; None for the bundled maps.
    parser
        Name of a parser, ``"module:name"`` of one of yours, or a parser.
    nlp
        spaCy pipeline for the parser ``dependency_paths``, which it selects.
    merged
        Whether all maps' landmarks are put into one inventory.
    misspelt
        Share of the words of five letters or more that are misspelt, in [0, 1].
    annotations
        File with the gold of lines whose own files have none.
    confidence
        Whether the parser's confidence is to be judged.
    seed
        Seed of the misspelling and of intervals.

    Raises
    ------
    InputError
        When a file, the pipeline or a value cannot be used.
    """
    if nlp is not None:
        from sloop_ppl.language import dependency_parser

        parser = dependency_parser(nlp)
    elif isinstance(parser, str):
        parser = find_parser(parser)
    if seed < 0:
        raise InputError(f"The seed is {seed}; expected 0 or more")
    find = map_finder(maps)
    return score_parser(
        read_descriptions(files, find, annotations),
        find,
        parser,
        merged=all_maps(maps) if merged else None,
        misspelt=misspelt,
        confidence=confidence,
        rng=np.random.default_rng(seed),
    )


def parse_score_lines(score: ParseScore, *, misses: bool = False) -> list[RenderableType]:
    """Return a score for printing.

    Parameters
    ----------
    score
        The score.
    misses
        Whether each description that was not wholly read right is listed.

    Returns
    -------
    list
        The misses, tables, and the figures.
    """
    shown: list[RenderableType] = []
    if misses:
        shown += [line for miss in score.misses for line in _miss_lines(miss)]
    shown.append(_table("relation", ("n", "precision", "recall", "f1"), score.per_relation))
    read = {name: rates for name, rates in score.statuses.items() if "f1" in rates}
    if set(read) - {"asserted"}:
        shown.append(_table("status", ("n", "precision", "recall", "f1"), read))
    unread = {name: rates for name, rates in score.statuses.items() if "read" in rates}
    if unread:
        shown.append(_table("not to be read", ("n", "read"), unread))
    if score.phenomena:
        names = ("n", "wholly_right", "f1", "false_positives")
        shown.append(_table("phenomenon", names, score.phenomena))
    if score.classes:
        shown.append(_table("ground", ("n", "read_right", "wrong_among_read"), score.classes))
    if score.parts:
        shown.append(_table("part", ("n", "read_right"), score.parts))
    if score.confidence is not None:
        shown += _confidence_lines(score.confidence)
    if score.not_scored:
        shown.append(f"{score.not_scored} lines without relations: not scored")
    shown.append(
        f"{score.n} descriptions: tuple F1 {score.tuple_f1:.4f} (precision {score.precision:.4f}, "
        f"recall {score.recall:.4f}), class F1 {score.class_f1:.4f}, pair F1 {score.pair_f1:.4f}"
    )
    shown.append(
        f"class and polarity F1 {score.polarity_f1:.4f}, {score.wholly_right} of {score.n} wholly "
        f"right, {score.false_positives} false positives, linking recall {score.linking_recall:.4f}"
    )
    return shown


def _table(
    first: str, columns: Sequence[str], rows: Mapping[str, Mapping[str, float]]
) -> RenderableType:
    """Return named numbers as a table: counts whole, shares with three decimals."""
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column(first)
    for name in columns:
        table.add_column(name.replace("_", " "), justify="right")
    for row, values in rows.items():
        cells = (
            ""
            if name not in values
            else f"{values[name]:g}"
            if name in _COUNTS
            else f"{values[name]:.3f}"
            for name in columns
        )
        table.add_row(row, *cells)
    return table


def _confidence_lines(found: Calibration) -> list[RenderableType]:
    bins = {
        f"{one.stated:.3f}": {"n": one.n, "stated": one.stated, "right": one.right}
        for one in found.bins
    }
    slope = "none" if found.slope is None else f"{found.slope:.2f}"
    if found.slope_ci95 is not None:
        slope += f" [{found.slope_ci95[0]:.2f}, {found.slope_ci95[1]:.2f}]"
    auc = "none" if found.auc is None else f"{found.auc:.3f}"
    summary = (
        f"confidence of {found.n} relations, {found.right:.3f} of them right: slope {slope}, Brier "
        f"score {found.brier:.4f} (a constant's {found.brier_constant:.4f}), AUC {auc}"
    )
    return [_table("confidence", ("n", "right"), bins), summary]


def _miss_lines(miss: Miss) -> list[str]:
    return [
        f"{miss.id}: {' '.join(miss.text.split())}",
        *(f"  missed  {' '.join(entry)}" for entry in miss.missed),
        *(f"  wrong   {' '.join(entry)}" for entry in miss.spurious),
    ]
