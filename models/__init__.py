"""Generative models of spatial language: likelihoods, frames, components, presets, the program."""

from sloop_ppl.models.atoms import Atoms
from sloop_ppl.models.bayes import BAYES, UNFITTED_BAYES, unfitted
from sloop_ppl.models.build import OpenProgram, build, open_program
from sloop_ppl.models.cell_priors import (
    CELL_PRIORS,
    CellPrior,
    LearntCells,
    cell_prior,
    learn_cells,
)
from sloop_ppl.models.components import COMBINATIONS, Component
from sloop_ppl.models.evidence import Evidence, gather_evidence
from sloop_ppl.models.frames import (
    FRAME_PREDICTORS,
    FRAME_PRIORS,
    FrameDistribution,
    FramePart,
    NearestStreet,
    PredictedPoint,
    PredictedSpread,
)
from sloop_ppl.models.grounding import ground_description
from sloop_ppl.models.intervene import intervene
from sloop_ppl.models.likelihoods import LIKELIHOODS, GaussianLikelihood, RelationLikelihood
from sloop_ppl.models.observation import observation_model
from sloop_ppl.models.phrases import front_prior, log_phrase, log_phrase_given_front
from sloop_ppl.models.presets import PRESETS, VARIANTS, Preset, preset
from sloop_ppl.models.shared import SharedFrames, share_frames
from sloop_ppl.models.terms import RelationTerm, ground_relations
from sloop_ppl.models.truth import TruthValue

__all__ = [
    "BAYES",
    "CELL_PRIORS",
    "COMBINATIONS",
    "FRAME_PREDICTORS",
    "FRAME_PRIORS",
    "LIKELIHOODS",
    "PRESETS",
    "UNFITTED_BAYES",
    "VARIANTS",
    "Atoms",
    "CellPrior",
    "Component",
    "Evidence",
    "FrameDistribution",
    "FramePart",
    "GaussianLikelihood",
    "LearntCells",
    "NearestStreet",
    "OpenProgram",
    "PredictedPoint",
    "PredictedSpread",
    "Preset",
    "RelationLikelihood",
    "RelationTerm",
    "SharedFrames",
    "TruthValue",
    "build",
    "cell_prior",
    "front_prior",
    "gather_evidence",
    "ground_description",
    "ground_relations",
    "intervene",
    "learn_cells",
    "log_phrase",
    "log_phrase_given_front",
    "observation_model",
    "open_program",
    "preset",
    "share_frames",
    "unfitted",
]
