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
from sloop_ppl.errors import InputError

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
    html: Annotated[
        Path | None, typer.Option(help="Write a page that needs no server, .html.")
    ] = None,
    explain: Annotated[
        bool, typer.Option("--explain", help="Say why the belief is where it is.")
    ] = False,
    ask: Annotated[
        bool,
        typer.Option(
            "--ask", help="Ask at the terminal until the 90 % region is small; 'stop' ends."
        ),
    ] = False,
    answers: Annotated[
        Path | None,
        typer.Option(help="With --ask: a file of answers instead of the terminal."),
    ] = None,
    small_m2: Annotated[
        float, typer.Option("--small", help="With --ask: how small the region is to be, m2.")
    ] = 1000,
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
    if html:
        check_output(html, (".html",))
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
    talk = None
    if ask:
        from sloop_ppl.bridge.asking import FileAnswerer, TerminalAnswerer, converse

        answerer = TerminalAnswerer() if answers is None else FileAnswerer(answers)
        talk = converse(posterior, answerer, small_m2=small_m2, notify=progress)
        progress(f"no more is asked: {talk.ended}")
        posterior = talk.posterior
    elif answers is not None:
        raise InputError("--answers does not go without --ask; add --ask, or leave it out")
    if out:
        posterior.save(out)
    if figure and talk is not None:
        from sloop_ppl.bridge.asking.before_search import figure_of_conversation

        save_figure(figure_of_conversation(talk), figure)
    elif figure:
        from sloop_ppl.bridge.sheets import figure_of

        save_figure(figure_of(posterior, rng=np.random.default_rng(seed)), figure)
    if export:
        from sloop_ppl.inference import write_geojson

        write_geojson(posterior, export)
    if html:
        from sloop_ppl.web import write_page

        write_page(html, posterior)
    why = []
    if explain:
        from sloop_ppl.bridge.explain import explain_lines

        why = explain_lines(posterior, rng=np.random.default_rng(seed))
    if json:
        asked = {} if talk is None else {"questions": talk.to_json()}
        print_json({**belief_report(posterior), **asked})
        for line in why:
            progress(line)
    else:
        print_data(*(why or belief_lines(posterior)))
