"""Carry out what ``sloop search`` asks for: infer, search, tell of it and write it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from sloop_ppl.bridge._formatting import (
    asked_line,
    outcome_line,
    step_line,
    unresolved_lines,
    why_lines,
)
from sloop_ppl.bridge._replay import draw_episode
from sloop_ppl.bridge._requests import posterior_of, saved_posterior
from sloop_ppl.bridge._timed_utterances import read_utterances
from sloop_ppl.bridge._trees import TREE_DEPTH, TreeKeeper, check_tree
from sloop_ppl.bridge._typed import (
    point_questions,
    read_hearer,
    read_places,
    read_settings,
    read_start,
)
from sloop_ppl.bridge.posterior_episode import PosteriorEpisode
from sloop_ppl.bridge.searching import Places, search
from sloop_ppl.errors import InputError
from sloop_ppl.inference import Posterior
from sloop_ppl.maps._given_point import GivenPoint
from sloop_ppl.models import fitting_note
from sloop_ppl.outputs import check_output
from sloop_ppl.planning import (
    Environment,
    SearchConfig,
    SearchInterrupted,
    Sensor,
    write_episode,
)
from sloop_ppl.planning.episode import Step
from sloop_ppl.planning.planners import planner_of
from sloop_ppl.planning.questions import AskedQuestion
from sloop_ppl.plots import check_figure_path
from sloop_ppl.rng import child

if TYPE_CHECKING:
    from sloop_ppl.bridge.asking import Dialogue

__all__ = [
    "Prepared",
    "SearchRequest",
    "SearchResult",
    "Stage",
    "Staged",
    "prepared",
    "run_request",
]


@dataclass(frozen=True)
class SearchRequest:
    """What ``sloop search`` asks for; see its options."""

    text: str | None
    map_name: str | None
    places: tuple[str, ...] = ()
    start: str | None = None
    targets: Path | None = None
    model: str = "bayes"
    variant: str = "published"
    engine: str = "exact"
    frames: str | None = None
    params: Path | None = None
    prior: str | None = None
    viewpoint: str = "map"
    hearer: str | None = None
    area: str | None = None
    posterior: Path | None = None
    utterances: tuple[str, ...] = ()
    planner: str = "fast"
    sensor: str | None = None
    sensor_range_cells: float = 3
    fov_deg: float = 90
    sims: int = 1000
    max_steps: int | None = None
    rollout: str | None = None
    find_each: bool = False
    one_at_a_time: bool = False
    explain: bool = False
    settings: tuple[str, ...] = ()
    seed: int = 0
    out: Path | None = None
    posterior_out: Path | None = None
    tree: Path | None = None
    tree_step: int | None = None
    figure: Path | None = None
    animation: Path | None = None
    keep_beliefs: bool = False
    answers: str | None = None
    questions: int = 1
    question_cost: float = 10.0
    question_steps: int = 0
    answer_error: float = 0.1


@dataclass(frozen=True)
class Staged:
    """A search that is set in a world of its own.

    Parameters
    ----------
    posterior
        What is believed, on the map of that world.
    environment
        Where the search takes place; it begins where this is.
    config
        The settings it is planned with.
    places
        True place of each target.
    imagined
        Those of them that were drawn.
    sensor
        What the planner takes the sensor to be; the fan of the settings when None.
    on_step
        Called after each step, before it is told.
    """

    posterior: Posterior
    environment: Environment
    config: SearchConfig
    places: Places
    imagined: tuple[str, ...] = ()
    sensor: Sensor | None = None
    on_step: Callable[[Step], None] | None = None


class Stage(Protocol):
    """What sets a search in a world of its own."""

    def __call__(
        self,
        posterior: Posterior,
        places: Places,
        config: SearchConfig,
        start: tuple[float, ...] | None,
    ) -> Staged:
        """Return the search in its world."""
        ...


@dataclass(frozen=True)
class SearchResult:
    """What came of a request: the posterior before it, the episode, and how to tell of them."""

    posterior: Posterior
    episode: PosteriorEpisode
    report: dict[str, Any]
    summary: tuple[str, ...]


def run_request(
    request: SearchRequest,
    notify: Callable[[str], None],
    on_posterior: Callable[[Posterior], None] | None = None,
    stage: Stage | None = None,
) -> SearchResult:
    """Infer, search and write what was asked for.

    Parameters
    ----------
    on_posterior
        Called with the posterior before the search.
    stage
        What sets the search in a world of its own; on the grid when None.

    Raises
    ------
    SloopError
        For any mistake in the request, before anything is searched.
    SearchInterrupted
        On Ctrl-C, once what was done until then has been written.
    """
    utterances = read_utterances(request.utterances)
    planner = planner_of(request.planner)
    _check_outputs(request)
    posterior, places, config, begin = prepared(request, notify)
    if on_posterior is not None:
        on_posterior(posterior)
    staged = None if stage is None else stage(posterior, places, config, begin)
    if staged is not None:
        posterior, config, places = staged.posterior, staged.config, dict(staged.places)
        begin = None  # the world has it

    def on_step(step: Step) -> None:
        if staged is not None and staged.on_step is not None:
            staged.on_step(step)
        for line in why_lines(step) if request.explain else ():
            notify(line)
        notify(step_line(step))
        if step.index + 1 in utterances:
            notify(f"     told: “{utterances[step.index + 1]}”")
        if keeper is not None:
            keeper.keep(step)

    def on_question(question: AskedQuestion) -> None:
        if request.explain:
            notify(asked_line(question))

    keeper = TreeKeeper(request.tree, request.tree_step) if request.tree is not None else None
    try:
        episode = search(
            posterior,
            posterior.city,
            places,
            planner=planner,
            sensor=request.sensor if staged is None else staged.sensor,
            sims=request.sims,
            sensor_range_cells=config.sensor_range_cells,
            start=begin,
            rng=np.random.default_rng(request.seed),
            config=config,
            on_step=on_step,
            notify=notify,
            keep_beliefs=request.keep_beliefs or request.animation is not None,
            said=utterances,
            one_at_a_time=request.one_at_a_time,
            dialogue=_dialogue(request),
            on_question=on_question,
            environment=None if staged is None else staged.environment,
        )
    except SearchInterrupted as stopped:
        if staged is not None:
            stopped.episode = replace(stopped.episode, imagined=staged.imagined)
        if isinstance(stopped.episode, PosteriorEpisode):
            _write(request, posterior, stopped.episode)
        if keeper is not None and keeper.kept:
            keeper.write()
        raise
    if staged is not None:
        episode = replace(episode, imagined=staged.imagined)
    for step in episode.pending_steps:
        notify(
            f"never said, for the search ended after {episode.steps} steps: “{utterances[step]}”"
        )
    _write(request, posterior, episode)
    if keeper is not None:
        keeper.write()
    report = {**_named(request, posterior, episode), **episode.to_json()}
    return SearchResult(posterior, episode, report, (outcome_line(episode),))


class Prepared(NamedTuple):
    """What a search begins with: the posterior, places that are given, settings, a start."""

    posterior: Posterior
    places: dict[str, tuple[float, float]]
    config: SearchConfig
    start: tuple[float, ...] | None


def prepared(request: SearchRequest, notify: Callable[[str], None]) -> Prepared:
    """Infer where the targets are, and read the places, settings and start that were given.

    Raises
    ------
    SloopError
        For any mistake in the request.
    """
    given, start = read_places(request.places), read_start(request.start)
    config = _config(request)
    posterior = _posterior(request, given)
    grid = posterior.city.grid
    places = {name: point.on(grid) for name, point in given.items()}
    questions = point_questions(grid, request.places, request.start, request.hearer)
    for line in (*questions, fitting_note(posterior.model), *unresolved_lines(posterior)):
        if line:
            notify(line)
    begin = None if start is None else (*start[0].on(grid), *start[1])
    return Prepared(posterior, places, config, begin)


def _posterior(request: SearchRequest, places: Mapping[str, GivenPoint]) -> Posterior:
    # A stream of its own: the search is the same with an engine that draws and one that does not.
    rng = child(np.random.default_rng(request.seed), "infer")
    if request.posterior is not None:
        return saved_posterior(request.posterior, request.map_name, request.text, rng)
    if request.text is None:
        raise InputError("Missing argument 'TEXT'; say where something is, or give --posterior")
    if request.map_name is None:
        raise InputError("Missing option '--map'; give a bundled map's name or a .geojson file")
    return posterior_of(
        request.text, request.map_name, targets=request.targets, model=request.model,
        variant=request.variant, engine=request.engine, frames=request.frames,
        params=request.params, prior=request.prior, viewpoint=request.viewpoint,
        hearer=read_hearer(request.hearer), truth=places, rng=rng, area=request.area,
    )  # fmt: skip


def _dialogue(request: SearchRequest) -> Callable[[Places], Dialogue] | None:
    """Return what makes the dialogue of a search, once all true places are known."""
    if request.answers is None:
        return None
    from sloop_ppl.bridge.asking import AnswererModel, Dialogue
    from sloop_ppl.bridge.asking.answerers import answerer_of

    is_simulated = request.answers == "simulated"
    person = AnswererModel.exact if is_simulated else AnswererModel
    made = Dialogue(  # refuses what cannot be used before anything is searched
        answerer_of(request.answers, {}, error=request.answer_error, rng=np.random.default_rng(0)),
        most=request.questions,
        cost=request.question_cost,
        steps=request.question_steps,
        person=person(error=request.answer_error),
    )
    rng = child(np.random.default_rng(request.seed), "answers")

    def with_places(places: Places) -> Dialogue:
        if not is_simulated:
            return made
        answerer = answerer_of("simulated", places, error=request.answer_error, rng=rng)
        return replace(made, answerer=answerer)

    return with_places


def _config(request: SearchRequest) -> SearchConfig:
    others = read_settings(request.settings)
    if request.tree is not None:
        others.setdefault("tree_depth", TREE_DEPTH)
    return SearchConfig(
        sensor_range_cells=request.sensor_range_cells,
        fov_deg=request.fov_deg,
        sims=request.sims,
        max_steps=request.max_steps,
        rollout=request.rollout,
        find_each=request.find_each,
        **others,
    )


def _check_outputs(request: SearchRequest) -> None:
    check_tree(request.tree, request.tree_step, request.planner)
    if request.out:
        check_output(request.out, (".json",))
    if request.posterior_out:
        check_output(request.posterior_out, (".nc",))
    if request.figure:
        check_figure_path(request.figure)
    if request.animation:
        check_figure_path(request.animation, animation=True)


def _named(
    request: SearchRequest, posterior: Posterior, episode: PosteriorEpisode
) -> dict[str, Any]:
    utterances = {str(step): d.text for step, d in episode.utterances.items()}
    return {
        "map": episode.map_name,
        "model": posterior.model.name,
        "planner": episode.planner,
        "seed": request.seed,
        **({"said": utterances} if utterances else {}),
    }


def _write(request: SearchRequest, posterior: Posterior, episode: PosteriorEpisode) -> None:
    if request.out:
        write_episode(
            replace(episode, beliefs=()) if not request.animation else episode,
            request.out,
            text=" ".join(posterior.texts),
            **_named(request, posterior, episode),
        )
    if request.posterior_out and episode.posterior is not None:
        episode.posterior.save(request.posterior_out)
    draw_episode(episode, posterior.city, request.figure, request.animation)
