"""Generative models of spatial language: likelihoods, frames, components, presets, the program."""

from sloop_ppl.models.components import COMBINATIONS, Component
from sloop_ppl.models.evidence import Evidence, gather_evidence
from sloop_ppl.models.frames import (
    FRAME_PREDICTORS,
    FrameDistribution,
    FramePart,
    NearestStreet,
    PredictedPoint,
    PredictedSpread,
)
from sloop_ppl.models.likelihoods import LIKELIHOODS, GaussianLikelihood, RelationLikelihood
from sloop_ppl.models.observation import observation_model
from sloop_ppl.models.phrases import log_phrase, log_phrase_given_front
from sloop_ppl.models.presets import PRESETS, VARIANTS, Preset, preset
from sloop_ppl.models.shared import SharedFrames, share_frames
from sloop_ppl.models.terms import RelationTerm, ground_relations
from sloop_ppl.models.truth import TruthValue

__all__ = [
    "COMBINATIONS",
    "FRAME_PREDICTORS",
    "LIKELIHOODS",
    "PRESETS",
    "VARIANTS",
    "Component",
    "Evidence",
    "FrameDistribution",
    "FramePart",
    "GaussianLikelihood",
    "NearestStreet",
    "PredictedPoint",
    "PredictedSpread",
    "Preset",
    "RelationLikelihood",
    "RelationTerm",
    "SharedFrames",
    "TruthValue",
    "gather_evidence",
    "ground_relations",
    "log_phrase",
    "log_phrase_given_front",
    "observation_model",
    "preset",
    "share_frames",
]
