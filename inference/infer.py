"""Infer where targets are: from one description, or from many in one run of the program."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from sloop_ppl.errors import BeliefCollapse, InputError
from sloop_ppl.inference.engines import Engine, Exact, InferenceInfo, engine_of
from sloop_ppl.inference.factors import check_description, weigh
from sloop_ppl.inference.posterior import Posterior, check_possible
from sloop_ppl.inference.prior import log_priors
from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap, search_area
from sloop_ppl.models import (
    GroundedRelation,
    ObservationModel,
    ground_description,
    ground_target_relations,
    intervene,
    latents_of,
    preset,
    program_data,
)

__all__ = ["infer_batch", "infer_description"]

_TOGETHER = 50
"""Targets in one run of the program, so that few tables are held at once."""


def infer_description(
    description: Description,
    city: CityMap,
    model: str | ObservationModel = "bayes",
    engine: str | Engine = "exact",
    *,
    prior: Any = None,
    truth: Mapping[str, tuple[float, float]] | None = None,
    do: Mapping[str, Any] | None = None,
    rng: np.random.Generator | None = None,
    area: Any = None,
) -> tuple[Posterior, InferenceInfo]:
    """Return the posterior over the cell of each target, and how it was found.

    Parameters are those of :func:`sloop_ppl.infer`, which refuses a description without relations;
    here a target of which nothing is said keeps its prior.

    Raises
    ------
    UnknownName
        For an unknown model, engine, relation or ground.
    DescriptionError
        When there is no target, or a relation is about no declared one.
    InputError
        For a prior that is not one, a missing truth, or a description of another map.
    BeliefCollapse
        When the prior excludes all that the description allows.
    """
    started = time.perf_counter()
    chosen, method = intervene(preset(model), do), engine_of(engine)
    check_description(description, city)
    targets = tuple(target.id for target in description.targets)
    searched = None if area is None else search_area(area, city.grid)
    log_prior = log_priors(prior, targets, city, searched)
    factor = weigh((description,), city, chosen, method, log_prior, truth=truth, rng=rng)
    posterior = Posterior(
        city=city,
        model=chosen,
        method=method,
        log_prior=log_prior,
        factors=(factor,),
        log_sensed=dict.fromkeys(targets, np.zeros(city.grid.size)),
        area=searched,
    )
    check_possible(posterior, description)
    info = InferenceInfo(
        engine=method.name,
        seconds=time.perf_counter() - started,
        log_evidence=posterior.log_evidence,
        not_located=tuple(
            target
            for target in targets
            if target not in factor.log_factors and target not in posterior.related
        ),
    )
    return posterior.noted(info), info


def infer_batch(
    descriptions: Sequence[Description],
    city: CityMap,
    model: str | ObservationModel = "bayes",
    *,
    prior: Any = None,
    area: Any = None,
) -> tuple[dict[str, NDArray[np.float64]], ...]:
    """Return the beliefs that each description alone gives, by the exact engine.

    Parameters
    ----------
    descriptions
        What was said, each on its own; all on this map.
    city
        The map.
    model
        A model's name, or an ObservationModel.
    prior
        The same belief before each; see :func:`sloop_ppl.inference.log_priors`.
    area
        Where targets are searched for; see :func:`sloop_ppl.maps.search_area`.

    Returns
    -------
    tuple of dict
        For each description, target -> probability of each cell, shape (H, W), summing to one.

    Raises
    ------
    InputError
        When the model has to be told the true places, or a map is another.
    BeliefCollapse
        When the prior excludes all that a description allows.

    Notes
    -----
    Descriptions and targets become the targets of one program, which makes the table of a phrase
    once however often it is said. Where phrases share frames or latents, or relate targets to each
    other, targets are coupled, and each description is inferred by itself.

    Examples
    --------
    >>> import sloop_ppl as sloop
    >>> city = sloop.load_map("cleveland")
    >>> said = [sloop.parse(f"the red bike is near {name}", city) for name in ("Ivy", "Rumor")]
    >>> [list(beliefs) for beliefs in infer_batch(said, city)]
    [['RedBike'], ['RedBike']]
    """
    chosen = preset(model)
    if chosen.needs_truth:
        raise InputError(
            f"Model '{chosen.name}' needs to be told where the targets are; infer each description "
            "by itself"
        )
    searched = None if area is None else search_area(area, city.grid)
    coupled = chosen.shared_frames or bool(latents_of(chosen))
    coupled = coupled or any(ground_target_relations((d,), city, chosen) for d in descriptions)
    if coupled or not all(description.is_certain for description in descriptions):
        each = [
            infer_description(description, city, chosen, prior=prior, area=searched)[0]
            for description in descriptions
        ]
        return tuple({target: p.belief(target) for target in p.targets} for p in each)
    for description in descriptions:
        if description.map and description.map != city.name:
            raise InputError(
                f"A description was read on map '{description.map}'; expected '{city.name}'"
            )
    rows: dict[str, tuple[GroundedRelation, ...]] = {}
    priors: list[NDArray[np.float64]] = []
    for d, description in enumerate(descriptions):
        grounded = ground_description(description, city, chosen)
        rows |= {f"{d}:{target}": relations for target, relations in grounded.items()}
        priors += list(log_priors(prior, tuple(grounded), city, searched).values())
    if not rows:
        return ()
    data = program_data(rows, city, chosen, torch.from_numpy(np.stack(priors)))
    found: list[NDArray[np.float64]] = []
    for start in range(0, len(rows), _TOGETHER):
        some = data.some(range(start, min(start + _TOGETHER, len(rows))))
        for table, before in zip(Exact().weigh(some), some.log_prior, strict=True):
            log_p = torch.logsumexp(torch.from_numpy(table), 0) + before
            found.append(torch.softmax(log_p, -1).numpy().reshape(city.grid.shape))
    beliefs = iter(found)
    result = tuple(
        {t.id: next(beliefs) for t in description.targets} for description in descriptions
    )
    for by_target, description in zip(result, descriptions, strict=True):
        for target, belief in by_target.items():
            if not np.isfinite(belief).all():
                raise BeliefCollapse(
                    f"What was said of '{target}' is impossible under the prior; expected some "
                    f"cell to remain: '{description.text}'; widen the prior",
                    observation=description,
                )
    return result
