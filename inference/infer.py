"""Infer where targets are from a description: the one road from words to a posterior."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from sloop_ppl.errors import DescriptionError, InputError
from sloop_ppl.inference.collapse import check_possible
from sloop_ppl.inference.engine import ENGINES, InferenceInfo
from sloop_ppl.inference.posterior import Posterior
from sloop_ppl.inference.prior import log_priors
from sloop_ppl.inference.said import Said
from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap
from sloop_ppl.models import Preset, ground_description, intervene, preset

__all__ = ["infer_description"]


def infer_description(
    description: Description,
    city: CityMap,
    model: str | Preset = "bayes",
    engine: str = "exact",
    *,
    prior: Any = None,
    truth: Mapping[str, tuple[float, float]] | None = None,
    do: Mapping[str, Any] | None = None,
    rng: np.random.Generator | None = None,
) -> tuple[Posterior, InferenceInfo]:
    """Return the posterior over the cell of each target, and how it was found.

    Parameters are those of :func:`sloop_ppl.infer`, which refuses a description without relations;
    here a target of which nothing is said keeps its prior.

    Raises
    ------
    UnknownName : for an unknown model, engine, relation or ground.
    DescriptionError : when there is no target, or a relation is about no declared one.
    InputError : for a prior that is not one, a missing truth, or a description of another map.
    BeliefCollapse : when the prior excludes all that the description allows.
    """
    started = time.perf_counter()
    if rng is not None and not isinstance(rng, np.random.Generator):
        raise InputError(
            f"rng is a {type(rng).__name__}; expected a generator: numpy.random.default_rng(seed)"
        )
    chosen, run = intervene(preset(model), do), ENGINES[engine]
    targets = tuple(target.id for target in description.targets)
    if not targets:
        raise DescriptionError("The description has no target; expected at least one")
    if description.map and description.map != city.name:
        raise InputError(
            f"The description was read on map '{description.map}'; expected '{city.name}': the "
            "same id is another landmark there"
        )
    for relation in description.relations:
        if relation.figure not in targets:
            raise DescriptionError(
                f"Relation '{relation.relation}' is about '{relation.figure}', which is no target "
                f"of the description; expected one of {', '.join(targets)}"
            )
    terms = list(ground_description(description, city, chosen).values())
    log_prior = log_priors(prior, targets, city)
    factors = run(
        terms,
        city,
        chosen,
        log_prior=np.stack([log_prior[target] for target in targets]),
        truths=_truths(truth, targets, chosen),
        rng=rng,
    )
    heard = [bool(said) or chosen.needs_truth for said in terms]
    posterior = Posterior(
        city=city,
        model=chosen,
        engine=engine,
        log_prior=log_prior,
        said={
            target: (
                Said(
                    description,
                    factors.components,
                    factors.log_factor[i],
                    terms[i],
                    factors.shared,
                ),
            )
            if heard[i]
            else ()
            for i, target in enumerate(targets)
        },
        log_sensed=dict.fromkeys(targets, np.zeros(city.grid.size)),
    )
    check_possible(posterior, description)
    info = InferenceInfo(
        engine=engine,
        seconds=time.perf_counter() - started,
        log_evidence=posterior.log_evidence,
        not_located=tuple(t for t, had in zip(targets, heard, strict=True) if not had),
    )
    return replace(posterior, info=info), info


def _truths(
    truth: Mapping[str, tuple[float, float]] | None, targets: tuple[str, ...], model: Preset
) -> list[tuple[float, float]] | None:
    if not model.needs_truth:
        return None
    for target in targets:
        if truth is None or target not in truth:
            raise InputError(
                f"Model '{model.name}' needs to be told where '{target}' is; give its place "
                f"(truth={{'{target}': (x_m, y_m)}} in Python; --place {target}=x,y to search)"
            )
    return [(truth or {})[target] for target in targets]
