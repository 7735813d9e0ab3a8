"""`sloop infer`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli._options import (
    Area,
    Engine,
    Frames,
    Hearer,
    Json,
    Map,
    Model,
    Params,
    Prior,
    Targets,
    Text,
    Variant,
    Viewpoint,
)
from sloop_ppl.cli._output import print_data, print_json, progress

__all__ = ["infer"]


def infer(
    text: Text,
    map_: Map,
    targets: Targets = None,
    model: Model = "bayes",
    variant: Variant = "published",
    engine: Engine = "exact",
    frames: Frames = None,
    params: Params = None,
    prior: Prior = None,
    viewpoint: Viewpoint = "map",
    hearer: Hearer = None,
    area: Area = None,
    out: Annotated[Path | None, typer.Option(help="Save the posterior, .nc.")] = None,
    figure: Annotated[
        Path | None, typer.Option(help="Draw the beliefs and what explains them, .png .pdf .svg.")
    ] = None,
    export: Annotated[
        Path | None, typer.Option(help="Write the cells with their probability, .geojson.")
    ] = None,
    explain: Annotated[
        bool, typer.Option("--explain", help="Say why the belief is where it is.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of engines that draw.")] = 0,
    json: Json = False,
) -> None:
    """Infer where the targets of a sentence are."""
    from sloop_ppl.outputs import check_output

    if out:
        check_output(out, (".nc",))
    if figure:
        from sloop_ppl.plots import check_figure_path, save_figure

        check_figure_path(figure)
    if export:
        check_output(export, (".geojson", ".json"))
    import numpy as np

    from sloop_ppl.bridge._formatting import belief_lines, belief_report, unresolved_lines
    from sloop_ppl.bridge._requests import posterior_of
    from sloop_ppl.bridge._typed import point_questions, read_hearer
    from sloop_ppl.models import fitting_note

    posterior = posterior_of(
        text, map_, targets=targets, model=model, variant=variant, engine=engine, frames=frames,
        params=params, prior=prior, viewpoint=viewpoint, hearer=read_hearer(hearer),
        rng=np.random.default_rng(seed), area=area,
    )  # fmt: skip
    questions = point_questions(posterior.city.grid, hearer=hearer)
    for line in (*questions, fitting_note(posterior.model), *unresolved_lines(posterior)):
        if line:
            progress(line)
    if out:
        posterior.save(out)
    if figure:
        from sloop_ppl.bridge.sheets import figure_of

        save_figure(figure_of(posterior, rng=np.random.default_rng(seed)), figure)
    if export:
        from sloop_ppl.inference import write_geojson

        write_geojson(posterior, export)
    why = []
    if explain:
        from sloop_ppl.bridge.explain import explain_lines

        why = explain_lines(posterior, rng=np.random.default_rng(seed))
    if json:
        print_json(belief_report(posterior))
        for line in why:
            progress(line)
    else:
        print_data(*(why or belief_lines(posterior)))
