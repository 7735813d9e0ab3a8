"""`sloop parse`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli._options import Hearer, Json, Map, Nlp, Targets, Text, Viewpoint
from sloop_ppl.cli._output import print_data, print_json, progress
from sloop_ppl.outputs import check_output, written_whole

__all__ = ["parse"]


def parse(
    text: Text,
    map_: Map,
    targets: Targets = None,
    nlp: Nlp = None,
    viewpoint: Viewpoint = "map",
    hearer: Hearer = None,
    html: Annotated[
        Path | None, typer.Option(help="Also write the coloured sentence as a page, .html.")
    ] = None,
    json: Json = False,
) -> None:
    """Read spatial relations from a sentence."""
    import sloop_ppl as sloop
    from sloop_ppl import language
    from sloop_ppl.bridge._formatting import relation_table
    from sloop_ppl.bridge._typed import point_questions, read_hearer

    place = read_hearer(hearer)
    page = check_output(html, (".html", ".htm")) if html else None
    city = sloop.load_map(map_)
    declared = language.load_targets(targets) if targets else None
    parser = language.dependency_parser(nlp) if nlp else "rules"
    seen_from = language.check_viewpoint(viewpoint)
    listens = None if place is None else place.on(city.grid, may_be_outside=True)
    for line in point_questions(city.grid, hearer=hearer):
        progress(line)
    parsed = language.parse(text, city, declared, parser, seen_from, hearer=listens)
    if page:
        with written_whole(page) as path:
            path.write_text(language.html_page(parsed), encoding="utf-8")
    if json:
        print_json(parsed.to_json())
    elif parsed.relations:
        print_data(language.coloured_text(parsed), "", relation_table(parsed))
    if not parsed.relations:
        raise language.no_relation_found(parsed, city, declared)
