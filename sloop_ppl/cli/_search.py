"""`sloop search`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sloop_ppl.cli import _options as opt
from sloop_ppl.cli._output import print_data, print_json, progress

if TYPE_CHECKING:
    from sloop_ppl.bridge._search_request import SearchResult

__all__ = ["search", "show_search"]

_WITH_REPLAY = ("replay", "map_", "figure", "animation", "json")
_OF_THE_POSTERIOR = (
    "model", "variant", "engine", "frames", "params", "prior", "targets", "viewpoint",
    "hearer", "area",
)  # fmt: skip


def search(
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
    posterior: Annotated[
        Path | None, typer.Option(help="A saved posterior to go on from; TEXT adds to it.")
    ] = None,
    utterances: opt.Say = None,
    planner: opt.Planner = "fast",
    sensor: Annotated[
        str | None,
        typer.Option(
            help="A sensor of your own, FILE.py:NAME, in place of the fan.", show_default=False
        ),
    ] = None,
    range_: opt.Range = 3,
    fov: opt.Fov = 90,
    sims: opt.Sims = 1000,
    steps: opt.Steps = None,
    rollout: opt.Rollout = None,
    settings: opt.Settings = None,
    find_each: opt.FindEach = False,
    one_at_a_time: Annotated[
        bool,
        typer.Option("--one-at-a-time", help="One target after the other, as in the paper."),
    ] = False,
    answers: opt.Answers = None,
    questions: opt.Questions = 1,
    question_cost: opt.QuestionCost = 10,
    question_steps: opt.QuestionSteps = 0,
    answer_error: opt.AnswerError = 0.1,
    explain: opt.Explain = False,
    replay: Annotated[
        Path | None, typer.Option(help="Draw a saved episode again (--figure, --animation).")
    ] = None,
    seed: opt.Seed = 0,
    out: opt.EpisodeOut = None,
    posterior_out: opt.PosteriorOut = None,
    tree: Annotated[Path | None, typer.Option(help="Save the tree of one decision, .json.")] = None,
    tree_step: Annotated[
        int | None, typer.Option(help="Whose tree, from 1; else the last.", show_default=False)
    ] = None,
    figure: opt.Figure = None,
    animation: opt.Animation = None,
    html: opt.PlayedPage = None,
    json: opt.Json = False,
) -> None:
    """Infer where the targets of a sentence are and search for them.

    Ctrl-C ends the search and leaves what was done in the files asked for.
    """
    from sloop_ppl.bridge._replay import replay_report
    from sloop_ppl.bridge._search_request import SearchRequest, run_request
    from sloop_ppl.outputs import check_output

    if replay is not None:
        others = [n for n in opt.given(context) if n not in _WITH_REPLAY]
        opt.refuse_options(others, "--replay", "an episode is drawn as it was")
        payload, line = replay_report(replay, map_, figure=figure, animation=animation)
        print_json(payload) if json else print_data(line)
        return
    if posterior is not None:
        others = [n for n in opt.given(context) if n in _OF_THE_POSTERIOR]
        opt.refuse_options(others, "--posterior", "a saved posterior keeps its own")
    opt.refuse_options_of_answers(context, answers)
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
    show_search(context, run_request(request, notify=progress), html, json=json)


def show_search(
    context: typer.Context, result: SearchResult, html: Path | None, *, json: bool
) -> None:
    """Write the page of a search that was run and print what came of it."""
    if html:
        from sloop_ppl.web import write_page

        write_page(html, result.posterior, result.episode, seed=context.params["seed"])
    for line in opt.unused_options(context, context.params["planner"]):
        progress(line)
    print_json(result.report) if json else print_data(*result.summary)
