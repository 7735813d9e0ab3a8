"""`sloop map import` and `sloop map fetch`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli.options import Json
from sloop_ppl.cli.output import print_data, print_json, progress

__all__ = ["fetch", "import_"]

Side = Annotated[float | None, typer.Option(help="Side of the square patch, metres.")]
Cell = Annotated[float, typer.Option(help="Side of a cell, metres.")]
Out = Annotated[Path, typer.Option(help="The map file to write, .geojson.", show_default=False)]
Name = Annotated[
    str | None, typer.Option(help="What to call the map; the file's name if left out.")
]


def import_(
    file: Annotated[Path, typer.Argument(help="An .osm or .osm.pbf file.", show_default=False)],
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
        name=name or out.stem, progress=progress,
    )  # fmt: skip
    write_map(city, out)
    print_json(summary(city)) if json else print_data(f"{out}: {city}", *report.lines())


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
