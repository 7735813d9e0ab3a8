"""`sloop eval`: how well texts are read, and what beliefs and searches are worth."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli.options import Json, Nlp, Params
from sloop_ppl.cli.output import print_data, print_json, progress

__all__ = ["app", "parse", "quality"]

app = typer.Typer(help="Score parsers, beliefs and searches on descriptions.", no_args_is_help=True)


@app.command()
def parse(
    files: Annotated[
        list[Path], typer.Argument(help="Description files, .jsonl.", show_default=False)
    ],
    maps: Annotated[
        Path | None, typer.Option(help="Folder of map files; else the bundled maps.")
    ] = None,
    parser: Annotated[
        str, typer.Option(help="rules, dependency_paths, or module:name of a parser of yours.")
    ] = "rules",
    nlp: Nlp = None,
    merge_maps: Annotated[
        bool, typer.Option("--merge-maps", help="Read on the landmarks of all maps at once.")
    ] = False,
    misspell: Annotated[
        float, typer.Option(help="Share of the words of five letters or more to misspell.")
    ] = 0.0,
    seed: Annotated[int, typer.Option(help="Seed of the misspelling.")] = 0,
    json: Json = False,
) -> None:
    """Read descriptions and compare with their gold relations."""
    from sloop_ppl.eval.parse_files import parse_score_lines, score_files

    score = score_files(
        files, maps=maps, parser=parser, nlp=nlp, merged=merge_maps, misspelt=misspell, seed=seed
    )
    if json:
        print_json(score.to_json())
    else:
        print_data(*parse_score_lines(score))


@app.command()
def quality(
    files: Annotated[
        list[Path], typer.Argument(help="Description files, .jsonl.", show_default=False)
    ],
    maps: Annotated[
        Path | None, typer.Option(help="Folder of map files; else the bundled maps.")
    ] = None,
    gold: Annotated[
        bool, typer.Option("--gold/--parsed", help="Gold relations, or those the parser reads.")
    ] = True,
    models: Annotated[
        str | None,
        typer.Option(help="Models, separated by commas; else all.", show_default=False),
    ] = None,
    params: Params = None,
    cv: Annotated[
        str | None,
        typer.Option(help="city: refit parameters without the line's city.", show_default=False),
    ] = None,
    json: Json = False,
) -> None:
    """Score what models believe against where the targets are."""
    from sloop_ppl.eval.quality_files import quality_lines, score_quality

    found = score_quality(
        files, maps=maps, gold=gold, models=models, params=params, cv=cv, progress=progress
    )
    if json:
        print_json(found.to_json())
    else:
        print_data(*quality_lines(found))
