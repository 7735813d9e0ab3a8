"""Interventions: fix a frame or a component from outside, whatever its prior."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.models.frames import (
    FrameDistribution,
    FramePart,
    FramePrior,
    UniformFrame,
)
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.models.presets import ObservationModel

__all__ = ["GivenFrames", "intervene"]


@dataclass(frozen=True)
class GivenFrames:
    """A frame prior in which some grounds' fronts are set from outside."""

    otherwise: FramePrior
    frame_angles_rad: tuple[tuple[str | None, float], ...]

    def __call__(self, term: GroundedRelation) -> FrameDistribution:
        """Return which way the ground faces: as it was set, else as was believed."""
        for ground, angle in self.frame_angles_rad:
            if ground is None or ground == term.ground:
                return FrameDistribution((FramePart(angle, math.inf),))
        return self.otherwise(term)

    def of_point(self, term: GroundedRelation) -> FrameDistribution:
        """Return which way a point faces, such as who listens: as it was set, else any way."""
        return replace(self, otherwise=UniformFrame())(term)


def intervene(model: ObservationModel, do: Mapping[str, Any] | None) -> ObservationModel:
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
            angles = value.items() if isinstance(value, Mapping) else [(None, value)]
            fixed = tuple((ground, _angle(angle)) for ground, angle in angles)
            model = replace(model, frame_prior=GivenFrames(model.frame_prior, fixed))
        else:
            raise UnknownName("intervention", str(key), ("frame", "component"))
    return model


def _angle(value: Any) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
        raise InputError(f"Front is {value!r}; expected a finite number of radians")
    return float(value)
