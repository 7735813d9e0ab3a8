"""Faults planted in inference, to see whether calibration catches them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.language import Description
from sloop_ppl.models import PredictedSpread, Preset
from sloop_ppl.models.likelihoods import parameters_of, with_values
from sloop_ppl.registry import Registry

__all__ = ["FAULTS", "Fault", "mirrored", "sharper_frames", "wider"]

Table = NDArray[np.float64]


@dataclass(frozen=True)
class Fault:
    """Something wrong with inference, planted to see whether calibration catches it.

    Parameters
    ----------
    model : changes the model that infers.
    hear : changes what it is told.
    see : changes its belief, shape (H, W).
    """

    model: Callable[[Preset], Preset] = lambda model: model
    hear: Callable[[Description], Description] = lambda said: said
    see: Callable[[Table], Table] = lambda belief: belief


def sharper_frames(model: Preset, times: float) -> Preset:
    """Return a model whose frames are so many times as concentrated.

    Raises
    ------
    InputError : when its frames are not spread.
    """
    prior = model.frame_prior
    if not isinstance(prior, PredictedSpread):
        raise InputError(f"The frames of model '{model.name}' have no kappa to change")
    return replace(model, frame_prior=replace(prior, kappa=times * prior.kappa))


def wider(model: Preset, times: float) -> Preset:
    """Return a model all of whose widths are so many times as great."""
    likelihood = model.likelihood
    widths = [p.name for p in parameters_of(likelihood) if p.unit == "m"]
    changed = {name: times * getattr(likelihood, name) for name in widths}
    return replace(model, likelihood=with_values(likelihood, changed))


def mirrored(said: Description) -> Description:
    """Return a description with left and right swapped."""
    other = {"left": "right", "right": "left"}
    swapped = tuple(replace(r, relation=other.get(r.relation, r.relation)) for r in said.relations)
    return replace(said, relations=swapped)


FAULTS: Registry[Fault] = Registry("fault")
"""Planted faults by name."""
FAULTS.add("kappa", Fault(model=lambda model: sharper_frames(model, 2.0)))
FAULTS.add("sigma", Fault(model=lambda model: wider(model, 1.5)))
FAULTS.add("left-right", Fault(hear=mirrored))
FAULTS.add("rows", Fault(see=lambda belief: belief[::-1]))
