"""`sloop eval frames`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli.options import Json
from sloop_ppl.cli.output import print_data, print_json, progress

__all__ = ["frames"]


def frames(
    maps: Annotated[
        Path | None,
        typer.Option(help="Folder of .osm, .osm.pbf or .geojson files; else the bundled maps."),
    ] = None,
    recipes: Annotated[
        str, typer.Option(help="Recipes to train, separated by commas; `paper` is one too.")
    ] = "ego-ctx,ctx,ego",
    descriptions: Annotated[
        list[Path] | None,
        typer.Option(help="Description file, .jsonl, to score fronts on too; may be repeated."),
    ] = None,
    epochs: Annotated[
        int | None, typer.Option(min=1, help="At most so many passes.", show_default="recipe's")
    ] = None,
    patience: Annotated[
        int | None,
        typer.Option(min=1, help="Stop after so many without gain.", show_default="recipe's"),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all that is drawn.")] = 0,
    figure: Annotated[
        Path | None, typer.Option(help="Draw the deviations, .png .pdf .svg.")
    ] = None,
    json: Json = False,
) -> None:
    """Hold cities out in turn and score which way their buildings are said to face."""
    from sloop_ppl.eval._frame_files import frame_lines, score_frames
    from sloop_ppl.plots import check_figure_path, save_figure

    if figure:
        check_figure_path(figure)
    found = score_frames(
        maps, recipes=recipes, descriptions=descriptions or (), epochs=epochs, patience=patience,
        seed=seed, progress=progress,
    )  # fmt: skip
    if figure:
        save_figure(found.figure(), figure)
    print_json(found.to_json()) if json else print_data(*frame_lines(found))
