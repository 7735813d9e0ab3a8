"""Frames of reference: which way a ground faces, and how sure that is."""

from sloop_ppl.models.frames.distribution import FrameDistribution, FramePart
from sloop_ppl.models.frames.predictor import (
    FRAME_PREDICTORS,
    FramePredictor,
    NearestStreet,
    plain_front,
)
from sloop_ppl.models.frames.prior import (
    FRAME_PRIORS,
    FixedFront,
    FramePrior,
    PredictedPoint,
    PredictedSpread,
    UniformFront,
)

__all__ = [
    "FRAME_PREDICTORS",
    "FRAME_PRIORS",
    "FixedFront",
    "FrameDistribution",
    "FramePart",
    "FramePredictor",
    "FramePrior",
    "NearestStreet",
    "PredictedPoint",
    "PredictedSpread",
    "UniformFront",
    "plain_front",
]
