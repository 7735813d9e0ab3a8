"""`sloop map` and its commands."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli._options import Json
from sloop_ppl.cli._output import print_data, print_json, progress

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
    from sloop_ppl.maps.summary import map_lines, summary
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


Side = Annotated[float | None, typer.Option(help="Side of the square patch, metres.")]
Cell = Annotated[float, typer.Option(help="Side of a cell, metres.")]
Out = Annotated[Path, typer.Option(help="The map file to write, .geojson.", show_default=False)]
Name = Annotated[
    str | None, typer.Option(help="What to call the map; the file's name if left out.")
]


@app.command("import")
def import_(
    file: Annotated[
        Path,
        typer.Argument(
            help="OpenStreetMap XML, .osm.pbf, Overpass JSON or GeoJSON with tags.",
            show_default=False,
        ),
    ],
    out: Out,
    center: Annotated[
        str | None, typer.Option(metavar="LAT,LON", help="Middle of a patch, with --side-m.")
    ] = None,
    side_m: Side = None,
    bbox: Annotated[
        str | None, typer.Option(metavar="WEST,SOUTH,EAST,NORTH", help="Borders of a patch.")
    ] = None,
    all_: Annotated[bool, typer.Option("--all", help="Take all that is in the file.")] = False,
    cell_m: Cell = 5.0,
    name: Name = None,
    allow_incomplete: Annotated[
        bool, typer.Option("--allow-incomplete", help="Go on when much lacks its nodes.")
    ] = False,
    json: Json = False,
) -> None:
    """Import a patch of an OpenStreetMap file, offline."""
    from sloop_ppl.maps import check_map_path, summary, write_map
    from sloop_ppl.maps.osm import import_osm, read_degrees

    check_map_path(out)
    middle = read_degrees(center, "LAT,LON") if center else None
    box = read_degrees(bbox, "WEST,SOUTH,EAST,NORTH") if bbox else None
    city, report = import_osm(
        file, centre=middle, side_m=side_m, bbox=box, everything=all_, cell_m=cell_m,
        name=name or out.stem, allow_incomplete=allow_incomplete, progress=progress,
    )  # fmt: skip
    write_map(city, out)
    print_json(summary(city)) if json else print_data(f"{out}: {city}", *report.lines())


@app.command("fetch")
def fetch(
    place: Annotated[str, typer.Argument(help="What to search for.", show_default=False)],
    out: Out,
    side_m: Side = 200.0,
    cell_m: Cell = 5.0,
    name: Name = None,
    json: Json = False,
) -> None:
    """Fetch a patch round a place over the network."""
    from sloop_ppl.maps import check_map_path, summary, write_map
    from sloop_ppl.maps.osm import fetch_place

    check_map_path(out)
    city, report = fetch_place(
        place, side_m=side_m or 200.0, cell_m=cell_m, name=name or out.stem, progress=progress
    )
    write_map(city, out)
    print_json(summary(city)) if json else print_data(f"{out}: {city}", *report.lines())
