"""Predictors that need no network: what the map knows, and chance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sloop_ppl.models.frames.distribution import FrameDistribution, FramePart
from sloop_ppl.models.frames.predictor import (
    FRAME_PREDICTORS,
    NEAREST_STREET,
    FramePredictor,
    plain_front,
)
from sloop_ppl.models.terms import RelationTerm
from sloop_ppl.rng import child

__all__ = ["AddressFront", "RandomFront"]


@dataclass(frozen=True)
class AddressFront:
    """A building faces the street of its address, else out of its main entrance.

    Parameters
    ----------
    otherwise : tells of what has neither.
    kappa : concentration around the address's street or the door's wall, > 0.
    lapse : probability that a building faces elsewhere, in [0, 1].

    Notes
    -----
    Of 33 real buildings with an address and a main entrance two thirds have both within 5 degrees;
    the lapse is the one that fits these best (`docs/frames.md`).
    """

    otherwise: FramePredictor = NEAREST_STREET
    kappa: float = 100.0
    lapse: float = 0.4

    def __call__(self, term: RelationTerm) -> FrameDistribution:
        """Return the distribution of the ground's front."""
        plain = plain_front(term)
        if plain is not None:
            return plain
        facing = term.city.frontage(term.ground)
        known = facing.by_address or facing.by_entrance
        if known is None:
            return self.otherwise(term)
        part = FramePart(known.bearing_rad, self.kappa, 1 - self.lapse)
        return FrameDistribution((part,), lapse=self.lapse)


@dataclass(frozen=True)
class RandomFront:
    """Any direction, the same for a landmark each time: what chance is worth.

    Parameters
    ----------
    seed : of the directions.
    kappa : concentration around them, > 0.

    Notes
    -----
    Source: SLOOP fig. 6, Random.
    """

    seed: int = 0
    kappa: float = 1.0

    def __call__(self, term: RelationTerm) -> FrameDistribution:
        """Return a von Mises distribution around a direction drawn for this ground."""
        rng = child(np.random.default_rng(self.seed), term.city.name, term.ground)
        angle = math.remainder(float(rng.uniform(-math.pi, math.pi)), 2 * math.pi)
        return FrameDistribution((FramePart(angle, self.kappa),))


FRAME_PREDICTORS.add("address", AddressFront())
FRAME_PREDICTORS.add("random", RandomFront())
