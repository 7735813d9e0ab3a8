"""From a sentence and the names that a user types to a posterior."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from sloop_ppl.bridge._timed_utterances import follow_up
from sloop_ppl.bridge.facade import infer, parse
from sloop_ppl.errors import InputError
from sloop_ppl.inference import ENGINES, Posterior
from sloop_ppl.language import check_viewpoint, load_targets, no_relation_found
from sloop_ppl.maps import load_map, search_area
from sloop_ppl.maps._given_point import GivenPoint
from sloop_ppl.models import (
    ObservationModel,
    PredictedPoint,
    PredictedSpread,
    cell_prior,
    preset,
)
from sloop_ppl.models.frames import frame_predictor
from sloop_ppl.models.tuning import load_parameters, with_parameters
from sloop_ppl.models.user import load_model
from sloop_ppl.user_file import is_user_file

__all__ = ["model_of", "posterior_of", "saved_posterior"]


def model_of(
    name: str,
    variant: str = "published",
    frames: str | None = None,
    params: Path | None = None,
) -> ObservationModel:
    """Return a model by name, with other parameters and frame predictor if they are given.

    Parameters
    ----------
    name
        A registered model, or ``FILE.py:NAME``; see :func:`sloop_ppl.models.user.load_model`.
    frames
        Name of a frame predictor, or the path of its weights.
    params
        File of parameters; see :func:`sloop_ppl.models.tuning.load_parameters`.

    Raises
    ------
    UnknownName
        When there is no such model, variant, frame predictor or parameter.
    InputError
        When the model's frame prior takes no predictor, or a file is not what it should be.
    """
    if is_user_file(name) and variant != "published":
        raise InputError(f"Model '{name}' has no variant '{variant}'; leave --variant out")
    model = load_model(name) if is_user_file(name) else preset(name, variant)
    if params is not None:
        model = with_parameters(model, load_parameters(params))
    if frames is None:
        return model
    predictor = frame_predictor(frames)
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
    prior: str | None = None,
    viewpoint: str = "map",
    hearer: GivenPoint | None = None,
    truth: Mapping[str, GivenPoint] | None = None,
    rng: np.random.Generator | None = None,
    area: str | None = None,
) -> Posterior:
    """Return the posterior of a sentence on a map, everything given by name or path.

    Parameters
    ----------
    map_name
        A bundled map's name or a map file.
    prior
        A name or file; see :func:`sloop_ppl.models.cell_prior`.
    viewpoint
        Where who speaks looks from; see :class:`sloop_ppl.language.Description`.
    hearer
        Where who listens is.
    truth
        Target -> its true place, for models that know it.
    area
        Where the targets are searched for, ``W,S,E,N`` or a GeoJSON file; see
        :func:`sloop_ppl.maps.search_area`.

    Raises
    ------
    SloopError
        For any mistake in these; names are checked before the work.
    """
    chosen, _ = model_of(model, variant, frames, params), ENGINES[engine]
    before = None if prior is None else cell_prior(prior)
    city = load_map(map_name)
    searched = None if area is None else search_area(area, city.grid)
    declared = load_targets(targets) if targets else None
    utterance = parse(
        text, city, targets=declared, viewpoint=check_viewpoint(viewpoint),
        hearer=None if hearer is None else hearer.on(city.grid, may_be_outside=True),
    )  # fmt: skip
    if not utterance.relations:
        raise no_relation_found(utterance, city, declared)
    places = {name: point.on(city.grid) for name, point in (truth or {}).items()}
    return infer(
        utterance, city, model=chosen, engine=engine, prior=before, rng=rng, area=searched,
        truth=None if truth is None else places,
    )  # fmt: skip


def saved_posterior(
    path: Path,
    map_name: str | None = None,
    text: str | None = None,
    rng: np.random.Generator | None = None,
) -> Posterior:
    """Return a saved posterior, told one more thing if there is a text.

    Parameters
    ----------
    path
        A posterior that ``sloop infer --out`` saved.
    map_name
        The map it should be of; its own when None.
    text
        English, read in the light of what was said before.

    Raises
    ------
    InputError
        When the file is no posterior, or one of another map.
    NoRelationFound
        When the text says nothing of a target.
    """
    posterior = Posterior.load(path)
    if map_name is not None:
        city = load_map(map_name)
        if posterior.city.digest != city.digest:
            raise InputError(
                f"Posterior '{path}' was made on another map ('{posterior.city.name}'); expected "
                f"'{city.name}' as it is now; infer it again on this map"
            )
    return posterior if text is None else posterior.update(follow_up(posterior, text), rng=rng)
