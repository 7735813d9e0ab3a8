"""Carry out what a command line asks for: from a sentence and names to a posterior or a search."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from sloop_ppl.bridge.facade import infer, parse
from sloop_ppl.bridge.places import read_places, read_start
from sloop_ppl.bridge.report import outcome_line, step_line, unresolved_lines
from sloop_ppl.bridge.searching import search
from sloop_ppl.errors import InputError
from sloop_ppl.inference import ENGINES, Posterior
from sloop_ppl.language import load_targets, no_relation_found
from sloop_ppl.maps import load_map
from sloop_ppl.models import FRAME_PREDICTORS, PredictedPoint, PredictedSpread, Preset, preset
from sloop_ppl.models.tuning import load_parameters, with_parameters
from sloop_ppl.models.user import is_user_model, load_model
from sloop_ppl.outputs import check_output, written_whole
from sloop_ppl.plots import animate_search, check_figure_path, plot_search, save_figure
from sloop_ppl.search import Episode, SearchConfig
from sloop_ppl.search.names import check_planner

__all__ = ["SearchRequest", "SearchResult", "model_of", "posterior_of", "run_request"]


def model_of(
    name: str,
    variant: str = "published",
    frames: str | None = None,
    params: Path | None = None,
) -> Preset:
    """Return a model by name, with other parameters and frame predictor if they are given.

    Parameters
    ----------
    name : a registered model, or ``FILE.py:NAME``; see :func:`sloop_ppl.models.user.load_model`.
    variant, frames : names.
    params : file of parameters; see :func:`sloop_ppl.models.tuning.load_parameters`.

    Raises
    ------
    UnknownName : when there is no such model, variant, frame predictor or parameter.
    InputError : when the model's frame prior takes no predictor, or a file is not what it should
        be.
    """
    if is_user_model(name) and variant != "published":
        raise InputError(f"Model '{name}' has no variant '{variant}'; leave --variant out")
    model = load_model(name) if is_user_model(name) else preset(name, variant)
    if params is not None:
        model = with_parameters(model, load_parameters(params))
    if frames is None:
        return model
    predictor = FRAME_PREDICTORS[frames]
    prior = model.frame_prior
    if not isinstance(prior, PredictedPoint | PredictedSpread):
        raise InputError(f"Model '{name}' has a frame prior of its own; leave --frames out")
    return replace(model, frame_prior=replace(prior, predictor=predictor))


def posterior_of(
    text: str,
    map_name: str,
    *,
    targets: Path | None = None,
    model: str = "bayes",
    variant: str = "published",
    engine: str = "exact",
    frames: str | None = None,
    params: Path | None = None,
    prior: Path | None = None,
    truth: dict[str, tuple[float, float]] | None = None,
) -> Posterior:
    """Return the posterior of a sentence on a map, everything given by name or path.

    Parameters
    ----------
    text : what was said.
    map_name : a bundled map's name or a map file.
    targets : file that declares the objects.
    model, variant, engine, frames : names; see :func:`sloop_ppl.bridge.catalogue.names_of`.
    params : file of parameters.
    prior : a saved posterior; its beliefs are the prior of the targets it holds.
    truth : true places, for models that need them.

    Raises
    ------
    SloopError : for any mistake in these; names are checked before the work.
    """
    chosen, _ = model_of(model, variant, frames, params), ENGINES[engine]
    city = load_map(map_name)
    declared = load_targets(targets) if targets else None
    said = parse(text, city, targets=declared)
    if not said.relations:
        raise no_relation_found(said, city, declared)
    if prior is None:
        return infer(said, city, model=chosen, engine=engine, truth=truth)
    before = Posterior.load(prior)
    if before.city.digest != city.digest:
        raise InputError(
            f"Prior '{prior}' was made on another map ('{before.city.name}'); expected "
            f"'{city.name}' as it is now; infer it again on this map"
        )
    spoken = {target.id for target in said.targets}
    tables = {t: before.belief(t) for t in before.targets if t in spoken}
    return infer(said, city, model=chosen, engine=engine, prior=tables, truth=truth)


@dataclass(frozen=True)
class SearchRequest:
    """What ``sloop search`` asks for; see its options."""

    text: str
    map_name: str
    places: tuple[str, ...] = ()
    start: str | None = None
    targets: Path | None = None
    model: str = "bayes"
    variant: str = "published"
    engine: str = "exact"
    frames: str | None = None
    params: Path | None = None
    planner: str = "pouct"
    sensor_range_cells: float = 3
    fov_deg: float = 90
    sims: int = 1000
    max_steps: int = 200
    rollout: str = "published"
    find_each: bool = False
    seed: int = 0
    out: Path | None = None
    figure: Path | None = None
    animation: Path | None = None


@dataclass(frozen=True)
class SearchResult:
    """What came of a request: the posterior, the episode, and how to tell of them."""

    posterior: Posterior
    episode: Episode
    report: dict[str, Any]
    summary: tuple[str, ...]


def run_request(
    request: SearchRequest,
    tell: Callable[[str], None],
    on_posterior: Callable[[Posterior], None] | None = None,
) -> SearchResult:
    """Infer, search and write what was asked for.

    Parameters
    ----------
    request : names, paths and numbers as they were typed.
    tell : takes each line of progress.
    on_posterior : called with the posterior before the search.

    Raises
    ------
    SloopError : for any mistake in the request, before anything is searched.
    """
    places, start = read_places(request.places), read_start(request.start)
    check_planner(request.planner)
    config = SearchConfig(
        sensor_range_cells=request.sensor_range_cells,
        fov_deg=request.fov_deg,
        sims=request.sims,
        max_steps=request.max_steps,
        rollout=request.rollout,
        find_each=request.find_each,
    )
    if request.out:
        check_output(request.out, (".json",))
    if request.figure:
        check_figure_path(request.figure)
    if request.animation:
        check_figure_path(request.animation, animation=True)
    posterior = posterior_of(
        request.text, request.map_name, targets=request.targets, model=request.model,
        variant=request.variant, engine=request.engine, frames=request.frames,
        params=request.params, truth=places,
    )  # fmt: skip
    for line in unresolved_lines(posterior):
        tell(line)
    if on_posterior is not None:
        on_posterior(posterior)
    episode = search(
        posterior,
        posterior.city,
        places,
        planner=request.planner,
        sims=request.sims,
        sensor_range_cells=request.sensor_range_cells,
        start=start,
        rng=np.random.default_rng(request.seed),
        config=config,
        on_step=lambda step: tell(step_line(step)),
        keep_beliefs=request.animation is not None,
    )
    report = {
        "map": episode.map_name,
        "model": posterior.model.name,
        "planner": episode.planner,
        "seed": request.seed,
        **episode.to_json(),
    }
    _write(request, posterior, episode, report)
    return SearchResult(posterior, episode, report, (outcome_line(episode),))


def _write(
    request: SearchRequest, posterior: Posterior, episode: Episode, report: dict[str, Any]
) -> None:
    if request.out:
        with written_whole(request.out) as path:
            path.write_text(json.dumps(report, ensure_ascii=False) + "\n", encoding="utf-8")
    if request.figure:
        save_figure(plot_search(episode, posterior.city), request.figure)
    if request.animation:
        animate_search(episode, posterior.city, request.animation, beliefs=episode.beliefs)
