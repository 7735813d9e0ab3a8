"""`sloop search`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli._options import (
    Animation,
    AnswerError,
    Answers,
    Area,
    Engine,
    EpisodeOut,
    Explain,
    Figure,
    FindEach,
    Fov,
    Frames,
    Hearer,
    Json,
    MaybeMap,
    MaybeText,
    Model,
    Params,
    Planner,
    PlayedPage,
    PosteriorOut,
    Prior,
    QuestionCost,
    Questions,
    QuestionSteps,
    Range,
    Rollout,
    Say,
    Seed,
    Settings,
    Sims,
    Start,
    Steps,
    Targets,
    TruePlaces,
    Variant,
    Viewpoint,
    given,
    refuse_options,
    refuse_options_of_answers,
    unused_options,
)
from sloop_ppl.cli._output import print_data, print_json, progress

__all__ = ["search"]

_WITH_REPLAY = ("replay", "map_", "figure", "animation", "json")
_OF_THE_POSTERIOR = (
    "model", "variant", "engine", "frames", "params", "prior", "targets", "viewpoint",
    "hearer", "area",
)  # fmt: skip


def search(
    context: typer.Context,
    text: MaybeText = None,
    map_: MaybeMap = None,
    place: TruePlaces = None,
    start: Start = None,
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
    utterances: Say = None,
    planner: Planner = "fast",
    sensor: Annotated[
        str | None,
        typer.Option(
            help="A sensor of your own, FILE.py:NAME, in place of the fan.", show_default=False
        ),
    ] = None,
    range_: Range = 3,
    fov: Fov = 90,
    sims: Sims = 1000,
    steps: Steps = None,
    rollout: Rollout = None,
    settings: Settings = None,
    find_each: FindEach = False,
    one_at_a_time: Annotated[
        bool,
        typer.Option("--one-at-a-time", help="One target after the other, as in the paper."),
    ] = False,
    answers: Answers = None,
    questions: Questions = 1,
    question_cost: QuestionCost = 10,
    question_steps: QuestionSteps = 0,
    answer_error: AnswerError = 0.1,
    explain: Explain = False,
    replay: Annotated[
        Path | None, typer.Option(help="Draw a saved episode again (--figure, --animation).")
    ] = None,
    seed: Seed = 0,
    out: EpisodeOut = None,
    posterior_out: PosteriorOut = None,
    tree: Annotated[Path | None, typer.Option(help="Save the tree of one decision, .json.")] = None,
    tree_step: Annotated[
        int | None, typer.Option(help="Whose tree, from 1; else the last.", show_default=False)
    ] = None,
    figure: Figure = None,
    animation: Animation = None,
    html: PlayedPage = None,
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
        refuse_options(others, "--replay", "an episode is drawn as it was")
        payload, line = replay_report(replay, map_, figure=figure, animation=animation)
        print_json(payload) if json else print_data(line)
        return
    if posterior is not None:
        others = [n for n in given(context) if n in _OF_THE_POSTERIOR]
        refuse_options(others, "--posterior", "a saved posterior keeps its own")
    refuse_options_of_answers(context, answers)
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
