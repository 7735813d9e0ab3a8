"""`sloop search`."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli._options import (
    Area,
    Engine,
    Fov,
    Frames,
    Hearer,
    Json,
    Model,
    Params,
    Prior,
    Seed,
    Sims,
    Targets,
    Variant,
    Viewpoint,
    as_typed,
    given,
    unused_options,
)
from sloop_ppl.cli._output import print_data, print_json, progress
from sloop_ppl.errors import InputError

__all__ = ["search"]

_WITH_REPLAY = ("replay", "map_", "figure", "animation", "json")
_OF_THE_POSTERIOR = (
    "model", "variant", "engine", "frames", "params", "prior", "targets", "viewpoint",
    "hearer", "area",
)  # fmt: skip

_OF_ANSWERS = ("questions", "question_cost", "question_steps", "answer_error")


def search(
    context: typer.Context,
    text: Annotated[
        str | None, typer.Argument(help="What was said, in English.", show_default=False)
    ] = None,
    map_: Annotated[
        str | None,
        typer.Option("--map", help="A bundled map's name or a .geojson file.", show_default=False),
    ] = None,
    place: Annotated[
        list[str] | None,
        typer.Option(
            help="Where a target truly is, OBJECT=x,y in metres or OBJECT=@lat,lon in degrees; "
            "else it is imagined."
        ),
    ] = None,
    start: Annotated[
        str | None,
        typer.Option(
            help="Where the search starts, x,y[,heading] or @lat,lon[,heading]; else drawn."
        ),
    ] = None,
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
    posterior: Annotated[
        Path | None, typer.Option(help="A saved posterior to go on from; TEXT adds to it.")
    ] = None,
    utterances: Annotated[
        list[str] | None,
        typer.Option(
            "--say", help="STEP=TEXT: what is said once so many steps are taken; may be repeated."
        ),
    ] = None,
    planner: Annotated[
        str, typer.Option(help="Planner, see `sloop list planners`; or FILE.py:NAME.")
    ] = "fast",
    sensor: Annotated[
        str | None,
        typer.Option(
            help="A sensor of your own, FILE.py:NAME, in place of the fan.", show_default=False
        ),
    ] = None,
    range_: Annotated[float, typer.Option("--range", help="How far the sensor sees, cells.")] = 3,
    fov: Fov = 90,
    sims: Sims = 1000,
    steps: Annotated[
        int | None,
        typer.Option(
            help="Steps after which the search ends; else 200, more on a larger map.",
            show_default=False,
        ),
    ] = None,
    rollout: Annotated[
        str | None,
        typer.Option(
            help="Rollouts: published, random, or informed (fast alone); else the planner's own.",
            show_default=False,
        ),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", help="NAME=VALUE of any other setting, such as no_fly=true."),
    ] = None,
    find_each: Annotated[
        bool, typer.Option("--find-each", help="One find action per target, as in the paper.")
    ] = False,
    one_at_a_time: Annotated[
        bool,
        typer.Option("--one-at-a-time", help="One target after the other, as in the paper."),
    ] = False,
    answers: Annotated[
        str | None,
        typer.Option(
            help="Who answers questions: human, simulated, or a file of answers; else none.",
            show_default=False,
        ),
    ] = None,
    questions: Annotated[int, typer.Option(help="How many questions may be asked.")] = 1,
    question_cost: Annotated[
        float, typer.Option(help="What a question takes from the reward.")
    ] = 10,
    question_steps: Annotated[int, typer.Option(help="How many steps a question takes.")] = 0,
    answer_error: Annotated[
        float, typer.Option(help="How often answers are wrong, or taken to be.")
    ] = 0.1,
    explain: Annotated[
        bool, typer.Option("--explain", help="Say before each step why it is taken.")
    ] = False,
    replay: Annotated[
        Path | None, typer.Option(help="Draw a saved episode again (--figure, --animation).")
    ] = None,
    seed: Seed = 0,
    out: Annotated[Path | None, typer.Option(help="Save the episode, .json.")] = None,
    posterior_out: Annotated[
        Path | None, typer.Option(help="Save what is believed after the search, .nc.")
    ] = None,
    tree: Annotated[Path | None, typer.Option(help="Save the tree of one decision, .json.")] = None,
    tree_step: Annotated[
        int | None, typer.Option(help="Whose tree, from 1; else the last.", show_default=False)
    ] = None,
    figure: Annotated[Path | None, typer.Option(help="Draw the search, .png .pdf .svg.")] = None,
    animation: Annotated[Path | None, typer.Option(help="Film the search, .gif or .mp4.")] = None,
    html: Annotated[
        Path | None, typer.Option(help="Write a page that plays it without a server, .html.")
    ] = None,
    json: Json = False,
) -> None:
    """Infer where the targets of a sentence are and search for them.

    Ctrl-C ends the search and leaves what was done in the files asked for.
    """
    from sloop_ppl.bridge._replay import replay_report
    from sloop_ppl.bridge._search_request import SearchRequest, run_request
    from sloop_ppl.outputs import check_output

    if replay is not None:
        others = [n for n in given(context) if n not in _WITH_REPLAY]
        _refuse(others, "--replay", "an episode is drawn as it was")
        payload, line = replay_report(replay, map_, figure=figure, animation=animation)
        print_json(payload) if json else print_data(line)
        return
    if posterior is not None:
        others = [n for n in given(context) if n in _OF_THE_POSTERIOR]
        _refuse(others, "--posterior", "a saved posterior keeps its own")
    if answers is None:
        _refuse((n for n in given(context) if n in _OF_ANSWERS), "a search without --answers",
                "nobody answers")  # fmt: skip
    request = SearchRequest(
        text=text, map_name=map_, places=tuple(place or ()), start=start, targets=targets,
        model=model, variant=variant, engine=engine, frames=frames, params=params,
        prior=prior, viewpoint=viewpoint, hearer=hearer, area=area, posterior=posterior,
        utterances=tuple(utterances or ()), planner=planner, sensor=sensor,
        sensor_range_cells=range_, fov_deg=fov, sims=sims, max_steps=steps, rollout=rollout,
        find_each=find_each, one_at_a_time=one_at_a_time, explain=explain,
        settings=tuple(settings or ()), seed=seed, out=out, posterior_out=posterior_out,
        tree=tree, tree_step=tree_step, figure=figure, animation=animation, answers=answers,
        questions=questions, question_cost=question_cost, question_steps=question_steps,
        answer_error=answer_error, keep_beliefs=html is not None,
    )  # fmt: skip
    if html:
        check_output(html, (".html",))
    lines = run_request(request, notify=progress)
    if html:
        from sloop_ppl.web import write_page

        write_page(html, lines.posterior, lines.episode, seed=seed)
    for line in unused_options(context, planner):
        progress(line)
    print_json(lines.report) if json else print_data(*lines.summary)


def _refuse(names: Iterable[str], option: str, reason: str) -> None:
    """Refuse the first of the options that do not go with another one."""
    for name in names:
        raise InputError(f"{as_typed(name)} does not go with {option}; leave it out: {reason}")
