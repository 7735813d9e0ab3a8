"""Score a parser on description files, and word the score."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.eval._inventory import all_maps, map_finder
from sloop_ppl.eval.descriptions import read_descriptions
from sloop_ppl.eval.parsing import Miss, ParseScore, score_parser
from sloop_ppl.language.parsers import Parser, find_parser

if TYPE_CHECKING:
    from rich.console import RenderableType

__all__ = ["parse_score_lines", "score_files"]


def score_files(
    files: Sequence[str | Path],
    *,
    maps: str | Path | None = None,
    parser: str | Parser = "rules",
    nlp: str | None = None,
    merged: bool = False,
    misspelt: float = 0.0,
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
    seed
        Seed of the misspelling.

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
        read_descriptions(files, find),
        find,
        parser,
        merged=all_maps(maps) if merged else None,
        misspelt=misspelt,
        rng=np.random.default_rng(seed),
    )


def parse_score_lines(score: ParseScore) -> list[RenderableType]:
    """Return the misses, a table per relation, and the figures, for printing."""
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in ("relation", "n", "precision", "recall", "f1"):
        table.add_column(name, justify="left" if name == "relation" else "right")
    for relation, rates in score.per_relation.items():
        table.add_row(
            relation,
            f"{rates['n']:g}",
            *(f"{rates[name]:.3f}" for name in ("precision", "recall", "f1")),
        )
    figures = (
        f"{score.n} descriptions: tuple F1 {score.tuple_f1:.4f} (precision {score.precision:.4f}, "
        f"recall {score.recall:.4f}), class F1 {score.class_f1:.4f}, pair F1 {score.pair_f1:.4f}"
    )
    missed: list[RenderableType] = [line for miss in score.misses for line in _miss_lines(miss)]
    return [*missed, table, figures]


def _miss_lines(miss: Miss) -> list[str]:
    return [
        f"{miss.id}: {' '.join(miss.text.split())}",
        *(f"  missed    {' '.join(entry)}" for entry in miss.missed),
        *(f"  spurious  {' '.join(entry)}" for entry in miss.spurious),
    ]
