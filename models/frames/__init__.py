"""Frames of reference: which way a ground faces, and how sure that is."""

from sloop_ppl.models.frames.distribution import FrameDistribution, FramePart
from sloop_ppl.models.frames.image import context_image, context_planes
from sloop_ppl.models.frames.known import AddressFront, RandomFront
from sloop_ppl.models.frames.learned import LearnedFrames
from sloop_ppl.models.frames.lookup import frame_predictor
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
from sloop_ppl.models.frames.weights import TrainedFrames, load_weights, save_weights

__all__ = [
    "FRAME_PREDICTORS",
    "FRAME_PRIORS",
    "AddressFront",
    "FixedFront",
    "FrameDistribution",
    "FramePart",
    "FramePredictor",
    "FramePrior",
    "LearnedFrames",
    "NearestStreet",
    "PredictedPoint",
    "PredictedSpread",
    "RandomFront",
    "TrainedFrames",
    "UniformFront",
    "context_image",
    "context_planes",
    "frame_predictor",
    "load_weights",
    "plain_front",
    "save_weights",
]
