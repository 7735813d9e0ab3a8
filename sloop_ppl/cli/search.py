"""`sloop search`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli.options import Engine, Frames, Json, Map, Model, Params, Targets, Text, Variant
from sloop_ppl.cli.output import print_data, print_json, progress

__all__ = ["search"]


def search(
    text: Text,
    map_: Map,
    place: Annotated[
        list[str] | None,
        typer.Option(help="Where a target truly is, OBJECT=x,y in metres; else it is imagined."),
    ] = None,
    start: Annotated[
        str | None, typer.Option(help="Where the search starts, x,y[,heading]; else drawn.")
    ] = None,
    targets: Targets = None,
    model: Model = "bayes",
    variant: Variant = "published",
    engine: Engine = "exact",
    frames: Frames = None,
    params: Params = None,
    planner: Annotated[str, typer.Option(help="Planner; see `sloop list planners`.")] = "pouct",
    range_: Annotated[float, typer.Option("--range", help="How far the sensor sees, cells.")] = 3,
    fov: Annotated[float, typer.Option(help="Opening of the sensor's fan, degrees.")] = 90,
    sims: Annotated[int, typer.Option(help="Simulations per step.")] = 1000,
    steps: Annotated[int, typer.Option(help="Steps after which the search ends.")] = 200,
    rollout: Annotated[str, typer.Option(help="Rollouts: published or random.")] = "published",
    find_each: Annotated[
        bool, typer.Option("--find-each", help="One find action per target, as in the paper.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all that is drawn.")] = 0,
    out: Annotated[Path | None, typer.Option(help="Save the episode, .json.")] = None,
    figure: Annotated[Path | None, typer.Option(help="Draw the search, .png .pdf .svg.")] = None,
    animation: Annotated[Path | None, typer.Option(help="Film the search, .gif.")] = None,
    json: Json = False,
) -> None:
    """Infer where the targets of a sentence are and search for them."""
    from sloop_ppl.bridge.requests import SearchRequest, run_request

    request = SearchRequest(
        text=text, map_name=map_, places=tuple(place or ()), start=start, targets=targets,
        model=model, variant=variant, engine=engine, frames=frames, params=params, planner=planner,
        sensor_range_cells=range_, fov_deg=fov, sims=sims, max_steps=steps, rollout=rollout,
        find_each=find_each, seed=seed, out=out, figure=figure, animation=animation,
    )  # fmt: skip
    lines = run_request(request, tell=progress)
    print_json(lines.report) if json else print_data(*lines.summary)
