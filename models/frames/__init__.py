"""Frames of reference: which way a ground faces, and how sure that is."""

from sloop_ppl.models.frames._network import (
    FrameNetwork,
    NetworkShape,
    Outputs,
    TrainedFrames,
    load_weights,
    log_density,
    save_weights,
)
from sloop_ppl.models.frames._pictures import VIEWS, context_image, context_planes, pictures_of
from sloop_ppl.models.frames._streets import choices_of
from sloop_ppl.models.frames.distribution import FrameDistribution, FramePart
from sloop_ppl.models.frames.learned import (
    LearnedFrames,
    frame_predictor,
    padded_choices,
    predict_frames,
    shipped_weights,
)
from sloop_ppl.models.frames.predictor import (
    FRAME_PREDICTORS,
    AddressFrame,
    FramePredictor,
    NearestStreet,
    RandomFrame,
    unpredicted_frame,
)
from sloop_ppl.models.frames.prior import (
    FRAME_PRIORS,
    FixedFrame,
    FramePrior,
    PredictedPoint,
    PredictedSpread,
    UniformFrame,
)

__all__ = [
    "FRAME_PREDICTORS",
    "FRAME_PRIORS",
    "VIEWS",
    "AddressFrame",
    "FixedFrame",
    "FrameDistribution",
    "FrameNetwork",
    "FramePart",
    "FramePredictor",
    "FramePrior",
    "LearnedFrames",
    "NearestStreet",
    "NetworkShape",
    "Outputs",
    "PredictedPoint",
    "PredictedSpread",
    "RandomFrame",
    "TrainedFrames",
    "UniformFrame",
    "choices_of",
    "context_image",
    "context_planes",
    "frame_predictor",
    "load_weights",
    "log_density",
    "padded_choices",
    "pictures_of",
    "predict_frames",
    "save_weights",
    "shipped_weights",
    "unpredicted_frame",
]
