"""Generative models of spatial language: likelihoods, frames, components, presets, the program.

Names load on first use, because most of them bring torch with them.
"""

from typing import TYPE_CHECKING

from sloop_ppl._rooms import load_later

if TYPE_CHECKING:
    from sloop_ppl.models._program_data import ProgramData
    from sloop_ppl.models._reference_regions import REGIONS
    from sloop_ppl.models._shared_latents import latents_of
    from sloop_ppl.models.bayes import BAYES, UNFITTED_BAYES, borrowed, fitting_note, unfitted
    from sloop_ppl.models.cell_priors import (
        CELL_PRIORS,
        CellPrior,
        LearntCells,
        cell_prior,
        learn_cells,
    )
    from sloop_ppl.models.check import check_likelihood
    from sloop_ppl.models.components import COMBINATIONS, Component
    from sloop_ppl.models.frames import (
        FRAME_PREDICTORS,
        FRAME_PRIORS,
        FrameDistribution,
        FramePart,
        NearestStreet,
        PredictedPoint,
        PredictedSpread,
    )
    from sloop_ppl.models.grounded_relation import GroundedRelation, ground_relations
    from sloop_ppl.models.grounding import (
        ground_description,
        ground_target_relations,
        program_data,
        true_places,
    )
    from sloop_ppl.models.interventions import intervene
    from sloop_ppl.models.latents import Latent
    from sloop_ppl.models.likelihoods import (
        LIKELIHOODS,
        GaussianLikelihood,
        Parameter,
        RelationLikelihood,
    )
    from sloop_ppl.models.pair_kernel import PairKernel
    from sloop_ppl.models.phrase import SharedFrame
    from sloop_ppl.models.presets import PRESETS, VARIANTS, ObservationModel, preset
    from sloop_ppl.models.program import Program, build
    from sloop_ppl.models.referent_gaussian import (
        REFERENT_GAUSSIAN,
        UNFITTED_REFERENT_GAUSSIAN,
    )
    from sloop_ppl.models.simulation import SPEAKER, simulate, speaker_of
    from sloop_ppl.models.tuning import load_parameters, with_parameters
    from sloop_ppl.models.user import load_model

__all__ = [
    "BAYES",
    "CELL_PRIORS",
    "COMBINATIONS",
    "FRAME_PREDICTORS",
    "FRAME_PRIORS",
    "LIKELIHOODS",
    "PRESETS",
    "REFERENT_GAUSSIAN",
    "REGIONS",
    "SPEAKER",
    "UNFITTED_BAYES",
    "UNFITTED_REFERENT_GAUSSIAN",
    "VARIANTS",
    "CellPrior",
    "Component",
    "FrameDistribution",
    "FramePart",
    "GaussianLikelihood",
    "GroundedRelation",
    "Latent",
    "LearntCells",
    "NearestStreet",
    "ObservationModel",
    "PairKernel",
    "Parameter",
    "PredictedPoint",
    "PredictedSpread",
    "Program",
    "ProgramData",
    "RelationLikelihood",
    "SharedFrame",
    "borrowed",
    "build",
    "cell_prior",
    "check_likelihood",
    "fitting_note",
    "ground_description",
    "ground_relations",
    "ground_target_relations",
    "intervene",
    "latents_of",
    "learn_cells",
    "load_model",
    "load_parameters",
    "preset",
    "program_data",
    "simulate",
    "speaker_of",
    "true_places",
    "unfitted",
    "with_parameters",
]

_HOMES = {
    "_program_data": ("ProgramData",),
    "_reference_regions": ("REGIONS",),
    "_shared_latents": ("latents_of",),
    "bayes": ("BAYES", "UNFITTED_BAYES", "borrowed", "fitting_note", "unfitted"),
    "cell_priors": ("CELL_PRIORS", "CellPrior", "LearntCells", "cell_prior", "learn_cells"),
    "check": ("check_likelihood",),
    "components": ("COMBINATIONS", "Component"),
    "frames": (
        "FRAME_PREDICTORS",
        "FRAME_PRIORS",
        "FrameDistribution",
        "FramePart",
        "NearestStreet",
        "PredictedPoint",
        "PredictedSpread",
    ),
    "grounded_relation": ("GroundedRelation", "ground_relations"),
    "grounding": (
        "ground_description",
        "ground_target_relations",
        "program_data",
        "true_places",
    ),
    "interventions": ("intervene",),
    "latents": ("Latent",),
    "likelihoods": ("LIKELIHOODS", "GaussianLikelihood", "Parameter", "RelationLikelihood"),
    "pair_kernel": ("PairKernel",),
    "phrase": ("SharedFrame",),
    "presets": ("PRESETS", "VARIANTS", "ObservationModel", "preset"),
    "program": ("Program", "build"),
    "referent_gaussian": ("REFERENT_GAUSSIAN", "UNFITTED_REFERENT_GAUSSIAN"),
    "simulation": ("SPEAKER", "simulate", "speaker_of"),
    "tuning": ("load_parameters", "with_parameters"),
    "user": ("load_model",),
}
__getattr__ = load_later(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted(__all__)
