"""Predict which way a ground faces from the map around it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from sloop_ppl.models.directions import ABSOLUTE_FRONT_RAD
from sloop_ppl.models.terms import RelationTerm
from sloop_ppl.registry import Registry

__all__ = ["FRAME_PREDICTORS", "NEAREST_STREET", "FramePredictor", "NearestStreet"]


class FramePredictor(Protocol):
    """Anything that names the directions a ground may face."""

    def __call__(self, term: RelationTerm) -> tuple[float, ...]:
        """Return the predicted fronts, equally likely, radians; none when nothing is known."""


@dataclass(frozen=True)
class NearestStreet:
    """A building faces the nearest street; a street faces both ways across itself.

    Notes
    -----
    Source: heuristic of the baselines; the paper trains networks on annotations (sec. IV-C).
    """

    def __call__(self, term: RelationTerm) -> tuple[float, ...]:
        """Return one front for a building, two for a street, none on a map without streets.

        The map itself faces north.
        """
        if term.is_map:
            return (ABSOLUTE_FRONT_RAD,)
        if term.is_line:
            normal = term.line_normal_rad
            return normal, math.remainder(normal + math.pi, 2 * math.pi)
        city, ground = term.city, term.ground
        front = city.derived(f"front of {ground}", lambda: city.bearing_to_nearest_path(ground))
        return () if front is None else (front,)


FRAME_PREDICTORS: Registry[FramePredictor] = Registry("frame predictor")
"""Frame predictors by name."""

NEAREST_STREET = FRAME_PREDICTORS.add("nearest-street", NearestStreet())
