"""`sloop map` and its commands."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli import osm
from sloop_ppl.cli.options import Json
from sloop_ppl.cli.output import print_data, print_json

__all__ = ["app"]

app = typer.Typer(help="Look at maps.", no_args_is_help=True)


@app.callback()
def _maps() -> None:
    pass


@app.command("show")
def show(
    map_: Annotated[
        str, typer.Argument(metavar="MAP", help="A bundled map's name or a .geojson file.")
    ],
    figure: Annotated[Path | None, typer.Option(help="Draw the map, .png .pdf .svg.")] = None,
    grid: Annotated[bool, typer.Option("--grid", help="Draw the cells too.")] = False,
    json: Json = False,
) -> None:
    """Show what is on a map."""
    import sloop_ppl as sloop
    from sloop_ppl.maps.map_lines import map_lines
    from sloop_ppl.maps.summary import summary
    from sloop_ppl.plots import check_figure_path, plot_map, save_figure

    if figure:
        check_figure_path(figure)
    city = sloop.load_map(map_)
    if figure:
        save_figure(plot_map(city, grid=grid), figure)
    if json:
        print_json(summary(city))
    else:
        print_data(*map_lines(city))


app.command("import")(osm.import_)
app.command("fetch")(osm.fetch)
