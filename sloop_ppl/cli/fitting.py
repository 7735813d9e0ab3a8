"""`sloop eval fit`: fit a model to descriptions, and choose among several."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli.options import Files, Json, Maps
from sloop_ppl.cli.output import print_data, print_json, progress

__all__ = ["fit"]


def fit(
    files: Files,
    out: Annotated[Path, typer.Option(help="The numbers to write, .json; --params reads them.")],
    models: Annotated[
        str | None,
        typer.Option(
            help="Candidates of `sloop list candidates`, models, or FILE.py:NAME, separated by "
            "commas; else the likelihood families.",
            show_default=False,
        ),
    ] = None,
    maps: Maps = None,
    json: Json = False,
) -> None:
    """Fit models with each map left out, choose inside the folds, and fit the best to all.

    Ctrl-C keeps the finished fits; the same command goes on from there.
    """
    from sloop_ppl.eval._fit_files import fit_files, fit_tables
    from sloop_ppl.eval._table_lines import table_lines

    selection, fitted = fit_files(files, out=out, models=models, maps=maps, progress=progress)
    if json:
        print_json(fitted.to_json())
    else:
        tables = fit_tables(selection, fitted)
        print_data(*(line for table in tables for line in table_lines(table)))
