"""Predict which way a ground faces: the protocol, its registry, and what needs no network."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from sloop_ppl.models.frames.distribution import (
    ABSOLUTE_ANGLE_RAD,
    FrameDistribution,
    FramePart,
)
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.registry import Registry
from sloop_ppl.rng import child

__all__ = [
    "FRAME_PREDICTORS",
    "NEAREST_STREET",
    "AddressFrame",
    "FramePredictor",
    "NearestStreet",
    "RandomFrame",
    "unpredicted_frame",
]


class FramePredictor(Protocol):
    """Anything that tells which way a ground faces, and how sure that is."""

    def __call__(self, term: GroundedRelation) -> FrameDistribution:
        """Return the distribution of the ground's front; uniform when nothing is known."""


@dataclass(frozen=True)
class NearestStreet:
    """A building faces the nearest street; a street faces both ways across itself.

    Notes
    -----
    Source: heuristic of the baselines; the paper trains networks on annotations (sec. IV-C).
    """

    def __call__(self, term: GroundedRelation) -> FrameDistribution:
        """Return one point for a building, two for a street, uniform on a map without streets."""
        plain = unpredicted_frame(term)
        if plain is not None:
            return plain
        city, ground = term.city, term.ground
        angle = city.derived(f"front of {ground}", lambda: city.bearing_to_nearest_path(ground))
        return FrameDistribution.points(() if angle is None else (angle,))


def unpredicted_frame(term: GroundedRelation) -> FrameDistribution | None:
    """Return the front of a ground that needs no prediction; None when it needs one.

    The map itself faces north. A street, or any other line, faces both ways across itself.
    """
    if term.is_map:
        return FrameDistribution.points((ABSOLUTE_ANGLE_RAD,))
    if term.is_line:
        normal = term.line_normal_rad
        return FrameDistribution.points((normal, math.remainder(normal + math.pi, 2 * math.pi)))
    return None


FRAME_PREDICTORS: Registry[FramePredictor] = Registry("frame predictor")
"""Frame predictors by name."""

NEAREST_STREET = FRAME_PREDICTORS.add("nearest-street", NearestStreet())


@dataclass(frozen=True)
class AddressFrame:
    """A building faces the street of its address, else out of its main entrance.

    Parameters
    ----------
    otherwise
        Tells of what has neither.
    kappa
        Concentration around the address's street or the door's wall, > 0.
    lapse
        Probability that a building faces elsewhere, in [0, 1].

    Notes
    -----
    Of 33 real buildings with an address and a main entrance two thirds have both within 5 degrees;
    the lapse is the one that fits these best (`docs/frames.md`).
    """

    otherwise: FramePredictor = NEAREST_STREET
    kappa: float = 100.0
    lapse: float = 0.4

    def __call__(self, term: GroundedRelation) -> FrameDistribution:
        """Return the distribution of the ground's front."""
        plain = unpredicted_frame(term)
        if plain is not None:
            return plain
        facing = term.city.frontage(term.ground)
        known = facing.by_address or facing.by_entrance
        if known is None:
            return self.otherwise(term)
        part = FramePart(known.bearing_rad, self.kappa, 1 - self.lapse)
        return FrameDistribution((part,), lapse=self.lapse)


@dataclass(frozen=True)
class RandomFrame:
    """Any direction, the same for a landmark each time: what chance is worth.

    Parameters
    ----------
    seed
        Seed of the directions.
    kappa
        Concentration around them, > 0.

    Notes
    -----
    Source: SLOOP fig. 6, Random.
    """

    seed: int = 0
    kappa: float = 1.0

    def __call__(self, term: GroundedRelation) -> FrameDistribution:
        """Return a von Mises distribution around a direction drawn for this ground."""
        rng = child(np.random.default_rng(self.seed), term.city.name, term.ground)
        angle = math.remainder(float(rng.uniform(-math.pi, math.pi)), 2 * math.pi)
        return FrameDistribution((FramePart(angle, self.kappa),))


FRAME_PREDICTORS.add("address", AddressFrame())
FRAME_PREDICTORS.add("random", RandomFrame())
