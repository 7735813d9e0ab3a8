"""Give the frame of a term its prior: fixed, or spread around a predictor with a lapse."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from sloop_ppl.models.directions import ABSOLUTE_FRONT_RAD
from sloop_ppl.models.frames.distribution import FrameDistribution, FramePart
from sloop_ppl.models.frames.predictor import NEAREST_STREET, FramePredictor
from sloop_ppl.models.terms import RelationTerm

__all__ = ["FramePrior", "PredictedPoint", "PredictedSpread"]


class FramePrior(Protocol):
    """What is believed about a frame before anything is said."""

    def __call__(self, term: RelationTerm) -> FrameDistribution:
        """Return the distribution of the direction the term's ground faces."""


@dataclass(frozen=True)
class PredictedPoint:
    """The predicted frame taken as certain; left and right are those of the map.

    Notes
    -----
    Source: SLOOP sec. III-D, published code. A street as ground of front or behind uses its two
    normals with equal weight.
    """

    predictor: FramePredictor = NEAREST_STREET

    def __call__(self, term: RelationTerm) -> FrameDistribution:
        """Return the points the frame may lie at."""
        if term.relation_class in ("left", "right"):
            return FrameDistribution((FramePart(ABSOLUTE_FRONT_RAD, math.inf),))
        fronts = self.predictor(term)
        if not fronts:
            return FrameDistribution((), lapse=1.0)
        return FrameDistribution(
            tuple(FramePart(front, math.inf, 1 / len(fronts)) for front in fronts)
        )


@dataclass(frozen=True)
class PredictedSpread:
    """A von Mises around each predicted front, a uniform lapse, and a share of the map's frame.

    Parameters
    ----------
    predictor : gives the fronts.
    kappa : concentration around each of them, > 0.
    lapse : probability that the prediction says nothing, in [0, 1].
    absolute : probability that left and right are those of the map, in [0, 1].
    absolute_kappa : concentration around the map's frame, > 0.

    Notes
    -----
    Source: ours; the paper takes the prediction as certain.
    """

    predictor: FramePredictor = NEAREST_STREET
    kappa: float = 4.0
    lapse: float = 0.15
    absolute: float = 0.8
    absolute_kappa: float = 50.0

    def __call__(self, term: RelationTerm) -> FrameDistribution:
        """Return the mixture of absolute frame, predicted frames and lapse."""
        absolute = self.absolute if term.relation_class in ("left", "right") else 0.0
        parts = [FramePart(ABSOLUTE_FRONT_RAD, self.absolute_kappa, absolute)] if absolute else []
        fronts = self.predictor(term)
        relative = (1 - absolute) * (1 - self.lapse)
        parts += [FramePart(front, self.kappa, relative / len(fronts)) for front in fronts]
        return FrameDistribution(tuple(parts), lapse=1 - sum(part.weight for part in parts))
