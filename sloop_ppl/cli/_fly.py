"""`sloop fly`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli import _options as opt
from sloop_ppl.cli._output import progress
from sloop_ppl.cli._search import show_search

__all__ = ["fly"]


def fly(
    context: typer.Context,
    text: opt.MaybeText = None,
    map_: opt.MaybeMap = None,
    place: opt.TruePlaces = None,
    start: opt.Start = None,
    targets: opt.Targets = None,
    model: opt.Model = "bayes",
    variant: opt.Variant = "published",
    engine: opt.Engine = "exact",
    frames: opt.Frames = None,
    params: opt.Params = None,
    prior: opt.Prior = None,
    viewpoint: opt.Viewpoint = "map",
    hearer: opt.Hearer = None,
    area: opt.Area = None,
    utterances: opt.Say = None,
    altitude: Annotated[float, typer.Option(help="How high the drone flies, metres.")] = 14.0,
    wind: Annotated[
        float, typer.Option(help="Speed of the wind, m/s; its gusts are a third of it.")
    ] = 2.0,
    detector: Annotated[
        str,
        typer.Option(
            help="What sees the targets: camera (colour and size in the picture), segmentation, "
            "rays (needs no graphics) or oracle."
        ),
    ] = "camera",
    battery: Annotated[
        int | None,
        typer.Option(
            min=1, help="Steps that the battery lasts; else for ever.", show_default=False
        ),
    ] = None,
    planner: opt.Planner = "fast",
    sims: opt.Sims = 1000,
    steps: opt.Steps = None,
    settings: opt.Settings = None,
    answers: opt.Answers = None,
    questions: opt.Questions = 1,
    question_cost: opt.QuestionCost = 10,
    question_steps: opt.QuestionSteps = 0,
    answer_error: opt.AnswerError = 0.1,
    explain: opt.Explain = False,
    seed: opt.Seed = 0,
    out: opt.EpisodeOut = None,
    figure: opt.Figure = None,
    video: Annotated[
        Path | None, typer.Option(help="Film the flight, its camera and the belief, .gif or .mp4.")
    ] = None,
    mjcf: Annotated[
        Path | None, typer.Option(help="Write the city as MuJoCo reads it, .xml.")
    ] = None,
    html: opt.PlayedPage = None,
    serve: Annotated[
        int | None,
        typer.Option(
            min=0,
            max=65535,
            help="Search nothing; AirSim's clients fly the drone from this port (0: a free one).",
            show_default=False,
        ),
    ] = None,
    json: opt.Json = False,
) -> None:
    """Infer where the targets of a sentence are and fly a drone through the city to find them.

    Ctrl-C ends the flight and leaves what was done in the files asked for.
    """
    from sloop_ppl.simulation import need_simulator

    need_simulator()
    from sloop_ppl.bridge._fly_request import FlyRequest, run_fly_request, serve_flight
    from sloop_ppl.bridge._search_request import SearchRequest
    from sloop_ppl.outputs import check_output

    opt.refuse_options_of_answers(context, answers)
    request = SearchRequest(
        text=text, map_name=map_, places=tuple(place or ()), start=start, targets=targets,
        model=model, variant=variant, engine=engine, frames=frames, params=params, prior=prior,
        viewpoint=viewpoint, hearer=hearer, area=area, utterances=tuple(utterances or ()),
        planner=planner, sims=sims, max_steps=steps, settings=tuple(settings or ()), seed=seed,
        out=out, figure=figure, explain=explain, answers=answers, questions=questions,
        question_cost=question_cost, question_steps=question_steps, answer_error=answer_error,
        keep_beliefs=html is not None,
    )  # fmt: skip
    if html:
        check_output(html, (".html",))
    flight = FlyRequest(request, altitude, wind, detector, video, battery, mjcf)
    if serve is not None:
        serve_flight(flight, serve, notify=progress)
        return
    show_search(context, run_fly_request(flight, notify=progress), html, json=json)
