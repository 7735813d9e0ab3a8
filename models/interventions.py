"""Interventions: fix a frame or a component from outside, whatever its prior."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.models.frames import FrameDistribution, FramePart, FramePrior
from sloop_ppl.models.presets import Preset
from sloop_ppl.models.terms import RelationTerm

__all__ = ["FixedFronts", "intervene"]


@dataclass(frozen=True)
class FixedFronts:
    """A frame prior in which some grounds' fronts are set from outside."""

    otherwise: FramePrior
    fronts_rad: tuple[tuple[str | None, float], ...]

    def __call__(self, term: RelationTerm) -> FrameDistribution:
        """Return which way the ground faces: as it was set, else as was believed."""
        for ground, front in self.fronts_rad:
            if ground is None or ground == term.ground:
                return FrameDistribution((FramePart(front, math.inf),))
        return self.otherwise(term)


def intervene(model: Preset, do: Mapping[str, Any] | None) -> Preset:
    """Return a model with some latents set from outside.

    Parameters
    ----------
    model
        The observation model.
    do
        ``{"frame": front}`` sets the front of every ground, ``{"frame": {ground: front}}`` of some,
        in radians anticlockwise from east; ``{"component": name}`` sets the component. None changes
        nothing.

    Raises
    ------
    UnknownName
        For another key, or a component the model has not.
    InputError
        For a front that is not a finite number.
    """
    for key, value in (do or {}).items():
        if key == "component":
            names = [part.name for part in model.components]
            if value not in names:
                raise UnknownName(f"component of model {model.name}", str(value), names)
            chosen = tuple(part for part in model.components if part.name == value)
            model = replace(model, components=chosen)
        elif key == "frame":
            fronts = value.items() if isinstance(value, Mapping) else [(None, value)]
            fixed = tuple((ground, _front(front)) for ground, front in fronts)
            model = replace(model, frame_prior=FixedFronts(model.frame_prior, fixed))
        else:
            raise UnknownName("intervention", str(key), ("frame", "component"))
    return model


def _front(value: Any) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
        raise InputError(f"Front is {value!r}; expected a finite number of radians")
    return float(value)
