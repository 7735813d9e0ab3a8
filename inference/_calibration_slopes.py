"""Slopes that calibration tests, and faults planted in inference to see whether it catches them.

Truth should slope in the direction of a posterior's widths as it is believed to. Ranks of a cell
hardly tell a width half as great again from the right one: far from every ground a width changes
nothing. So targets are placed near a cluster of grounds and described at length, and what is
compared is the quantity that a wrong width moves most.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.inference.infer import infer_batch
from sloop_ppl.language import RELATIONS, Description
from sloop_ppl.maps import CityMap
from sloop_ppl.models import ObservationModel, PredictedSpread
from sloop_ppl.models._vocabulary import speakable_grounds
from sloop_ppl.models.likelihoods import parameters_of, with_values
from sloop_ppl.models.simulation import simulate
from sloop_ppl.registry import Registry
from sloop_ppl.rng import child

__all__ = [
    "FAULTS",
    "STEP",
    "Fault",
    "cluster",
    "mirrored",
    "near_slopes",
    "residual",
    "sharper_frames",
    "wider",
]

STEP = 1.1  # ratio of two values whose beliefs make a slope: 10 % of a width or concentration
_GROUNDS = 6  # landmarks near one another that are spoken of; targets lie within the reach of one,
_REACH_M = 15.0  # metres, where a width matters most
_TOGETHER = 2000  # targets of one simulated description
_FLOOR = 1e-300

Table = NDArray[np.float64]


@dataclass(frozen=True)
class Fault:
    """Something wrong with inference, planted to see whether calibration catches it.

    Parameters
    ----------
    model
        Changes the model that infers.
    perturb
        Changes what it is told.
    see
        Changes its belief, shape (H, W).
    """

    model: Callable[[ObservationModel], ObservationModel] = lambda model: model
    perturb: Callable[[Description], Description] = lambda description: description
    see: Callable[[Table], Table] = lambda belief: belief


def sharper_frames(model: ObservationModel, times: float) -> ObservationModel:
    """Return a model whose frames are so many times as concentrated.

    Raises
    ------
    InputError
        When its frames are not spread.
    """
    prior = model.frame_prior
    if not isinstance(prior, PredictedSpread):
        raise InputError(f"The frames of model '{model.name}' have no kappa to change")
    return replace(model, frame_prior=replace(prior, kappa=times * prior.kappa))


def wider(model: ObservationModel, times: float) -> ObservationModel:
    """Return a model all of whose widths are so many times as great."""
    likelihood = model.likelihood
    widths = [p.name for p in parameters_of(likelihood) if p.unit == "m"]
    changed = {name: times * getattr(likelihood, name) for name in widths}
    return replace(model, likelihood=with_values(likelihood, changed))


def mirrored(description: Description) -> Description:
    """Return a description with left and right swapped."""
    sides = {word: record.converse for word, record in RELATIONS.items() if record.absolute}
    swapped = tuple(
        replace(r, relation=sides.get(r.relation) or r.relation) for r in description.relations
    )
    return replace(description, relations=swapped)


FAULTS: Registry[Fault] = Registry("fault")
"""Planted faults by name."""
FAULTS.add("kappa", Fault(model=lambda model: sharper_frames(model, 2.0)))
FAULTS.add("sigma", Fault(model=lambda model: wider(model, 1.5)))
FAULTS.add("left-right", Fault(perturb=mirrored))
FAULTS.add("rows", Fault(see=lambda belief: belief[::-1]))


def near_slopes(
    city: CityMap, n: int, *, rng: np.random.Generator, model: ObservationModel, fault: Fault
) -> dict[str, Table]:
    """Return how far the truth's slope is from what is believed of it, and the variance of that.

    Parameters
    ----------
    n
        Number of descriptions, > 0.
    model
        What they are drawn from.
    fault
        What is wrong with inference.

    Returns
    -------
    dict of numpy.ndarray
        ``width`` and ``mirror``: residual and variance of each description, shape (n, 2).

    Notes
    -----
    The slope of a cell is how much its log belief grows when all widths grow by a tenth, up to a
    constant of the description. Under a posterior that is right, the slope at the true cell has
    the mean and the variance that the posterior gives it, so the residuals sum to zero within the
    root of the summed variances. A slope depends on what was said as well as on the cell, as the
    test quantities of Modrak et al. 2023 do; for small errors of the parameter none based on the
    cell is more powerful, for the sum is the derivative of the log belief at the true cells.
    Descriptions that tell nothing add nothing, whereas their ranks would drown the others.
    ``mirror`` does the same with the log belief had left and right been heard the other way.
    """
    believed = fault.model(model)
    moved = wider(believed, STEP)
    grounds = cluster(city, _GROUNDS)
    distance_m = np.min([city.fields(ground).distance_m for ground in grounds], axis=0)
    prior = (distance_m <= _REACH_M) * 1.0
    found: dict[str, list[tuple[float, float]]] = {"width": [], "mirror": []}
    for start in range(0, n, _TOGETHER):
        names = [f"T{i}" for i in range(start, min(n, start + _TOGETHER))]
        drawn = simulate(
            city,
            names,
            child(rng, "slopes", start),
            model=model,
            phrases=len(grounds),
            grounds=grounds,
            prior=prior,
        )
        utterance = replace(fault.perturb(drawn.description), text="")

        other = mirrored(utterance)
        before, after, turned = (
            infer_batch([description], city, by, prior=prior)[0]
            for description, by in ((utterance, believed), (utterance, moved), (other, believed))
        )
        for name in names:
            cell, belief = drawn.latents[name].cell, fault.see(before[name])
            found["width"].append(residual(belief, fault.see(after[name]), cell))
            found["mirror"].append(residual(belief, fault.see(turned[name]), cell))
    return {name: np.array(rows) for name, rows in found.items()}


def residual(belief: Table, moved: Table, true: int | tuple[int, ...]) -> tuple[float, float]:
    """Return the slope at the truth less what is expected of it, and its variance.

    Parameters
    ----------
    belief
        Probabilities, of any shape.
    moved
        What they become when a parameter grows; the same shape, up to a constant.
    true
        Index of the truth.
    """
    slope = np.log(np.maximum(moved, _FLOOR)) - np.log(np.maximum(belief, _FLOOR))
    mean = float((belief * slope).sum())
    return float(slope[true]) - mean, float((belief * (slope - mean) ** 2).sum())


def cluster(city: CityMap, count: int) -> tuple[str, ...]:
    """Return the landmarks that may be spoken of which lie closest together, nearest first."""
    names = speakable_grounds(city)
    centres = [city.footprint(name).centroid for name in names]
    apart = np.array([[one.distance(other) for other in centres] for one in centres])
    near = np.sort(apart, axis=1)[:, : min(count, len(names))]
    around = int(near[:, -1].argmin())
    return tuple(names[i] for i in apart[around].argsort(kind="stable")[:count])
