"""Give the frame of a term its prior: certain, spread around a prediction, fixed, or uniform."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from sloop_ppl.models.frames.distribution import (
    ABSOLUTE_ANGLE_RAD,
    FrameDistribution,
    FramePart,
)
from sloop_ppl.models.frames.predictor import NEAREST_STREET, FramePredictor
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.registry import Registry

__all__ = [
    "FRAME_PRIORS",
    "FixedFrame",
    "FramePrior",
    "PredictedPoint",
    "PredictedSpread",
    "UniformFrame",
]


class FramePrior(Protocol):
    """What is believed about a frame before anything is said."""

    def __call__(self, term: GroundedRelation) -> FrameDistribution:
        """Return the distribution of the direction the term's ground faces."""


@dataclass(frozen=True)
class PredictedPoint:
    """The likeliest predicted front taken as certain; left and right are those of the map.

    Notes
    -----
    Source: SLOOP sec. III-D, published code. Fronts that are equally likely share the weight: a
    street as ground of front or behind uses its two normals.
    """

    predictor: FramePredictor = NEAREST_STREET

    def __call__(self, term: GroundedRelation) -> FrameDistribution:
        """Return the points the frame may lie at."""
        if term.record.absolute:
            return FrameDistribution.points((ABSOLUTE_ANGLE_RAD,))
        return FrameDistribution.points(self.predictor(term).modes())


@dataclass(frozen=True)
class PredictedSpread:
    """The predicted fronts with a speaker's scatter, a uniform lapse, and a share of the map's.

    Parameters
    ----------
    predictor
        Gives the distribution of the front.
    kappa
        Concentration of the speaker's frame around the ground's true front, > 0; infinite to take
        the prediction as it is.
    lapse
        Probability that the prediction says nothing, in [0, 1].
    absolute
        Probability that left and right are those of the map, in [0, 1].
    absolute_kappa
        Concentration around the map's frame, > 0.

    Notes
    -----
    Source: ours; the paper takes the prediction as certain. Each predicted part stays a von Mises
    distribution; its concentration k and the speaker's combine as variances add, 1/(1/k + 1/kappa),
    which is exact for a point and close for any other part. `kappa` and `absolute` can be learnt
    from descriptions of known places: see :mod:`sloop_ppl.inference._frame_tuning`.
    """

    predictor: FramePredictor = NEAREST_STREET
    # Set by hand. Deviations are about 1 / sqrt(kappa): 29 degrees round the front, 8 round north.
    kappa: float = 4.0
    lapse: float = 0.15
    absolute: float = 0.8
    absolute_kappa: float = 50.0

    def __call__(self, term: GroundedRelation) -> FrameDistribution:
        """Return the mixture of absolute frame, predicted frames and lapse."""
        absolute = self.absolute if term.record.absolute else 0.0
        parts = [FramePart(ABSOLUTE_ANGLE_RAD, self.absolute_kappa, absolute)] if absolute else []
        relative = (1 - absolute) * (1 - self.lapse)
        parts += [
            FramePart(part.mean_rad, self._scattered(part.kappa), relative * part.weight)
            for part in self.predictor(term).parts
        ]
        return FrameDistribution(tuple(parts), lapse=1 - sum(part.weight for part in parts))

    def _scattered(self, kappa: float) -> float:
        return self.kappa if math.isinf(kappa) else kappa / (1 + kappa / self.kappa)


@dataclass(frozen=True)
class FixedFrame:
    """The same front for every ground.

    Parameters
    ----------
    front_rad
        The front, radians anticlockwise from east; north unless told otherwise.
    kappa
        Concentration around it, > 0; infinite for a point.
    """

    front_rad: float = ABSOLUTE_ANGLE_RAD
    kappa: float = math.inf

    def __call__(self, term: GroundedRelation) -> FrameDistribution:  # noqa: ARG002
        """Return the front, whatever the ground."""
        return FrameDistribution((FramePart(self.front_rad, self.kappa),))


@dataclass(frozen=True)
class UniformFrame:
    """Nothing is known of any front."""

    def __call__(self, term: GroundedRelation) -> FrameDistribution:  # noqa: ARG002
        """Return the uniform distribution."""
        return FrameDistribution((), lapse=1.0)


FRAME_PRIORS: Registry[FramePrior] = Registry("frame prior")
"""Frame priors by name."""

FRAME_PRIORS.add("point", PredictedPoint())
FRAME_PRIORS.add("spread", PredictedSpread(absolute=0.0))
FRAME_PRIORS.add("absolute-relative", PredictedSpread())
FRAME_PRIORS.add("fixed", FixedFrame())
FRAME_PRIORS.add("uniform", UniformFrame())
