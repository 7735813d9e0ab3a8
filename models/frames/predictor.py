"""Predict which way a ground faces: the protocol, its registry, and the nearest street."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from sloop_ppl.models.directions import ABSOLUTE_FRONT_RAD
from sloop_ppl.models.frames.distribution import FrameDistribution
from sloop_ppl.models.terms import RelationTerm
from sloop_ppl.registry import Registry

__all__ = ["FRAME_PREDICTORS", "NEAREST_STREET", "FramePredictor", "NearestStreet", "plain_front"]


class FramePredictor(Protocol):
    """Anything that tells which way a ground faces, and how sure that is."""

    def __call__(self, term: RelationTerm) -> FrameDistribution:
        """Return the distribution of the ground's front; uniform when nothing is known."""


@dataclass(frozen=True)
class NearestStreet:
    """A building faces the nearest street; a street faces both ways across itself.

    Notes
    -----
    Source: heuristic of the baselines; the paper trains networks on annotations (sec. IV-C).
    """

    def __call__(self, term: RelationTerm) -> FrameDistribution:
        """Return one point for a building, two for a street, uniform on a map without streets."""
        plain = plain_front(term)
        if plain is not None:
            return plain
        city, ground = term.city, term.ground
        front = city.derived(f"front of {ground}", lambda: city.bearing_to_nearest_path(ground))
        return FrameDistribution.points(() if front is None else (front,))


def plain_front(term: RelationTerm) -> FrameDistribution | None:
    """Return the front of a ground that needs no prediction; None when it needs one.

    The map itself faces north. A street, or any other line, faces both ways across itself.
    """
    if term.is_map:
        return FrameDistribution.points((ABSOLUTE_FRONT_RAD,))
    if term.is_line:
        normal = term.line_normal_rad
        return FrameDistribution.points((normal, math.remainder(normal + math.pi, 2 * math.pi)))
    return None


FRAME_PREDICTORS: Registry[FramePredictor] = Registry("frame predictor")
"""Frame predictors by name."""

NEAREST_STREET = FRAME_PREDICTORS.add("nearest-street", NearestStreet())
