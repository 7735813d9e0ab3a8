"""Frames of reference: which way a ground faces, and how sure that is."""

from sloop_ppl.models.frames.distribution import FrameDistribution, FramePart
from sloop_ppl.models.frames.predictor import FRAME_PREDICTORS, FramePredictor, NearestStreet
from sloop_ppl.models.frames.prior import FramePrior, PredictedPoint, PredictedSpread

__all__ = [
    "FRAME_PREDICTORS",
    "FrameDistribution",
    "FramePart",
    "FramePredictor",
    "FramePrior",
    "NearestStreet",
    "PredictedPoint",
    "PredictedSpread",
]
