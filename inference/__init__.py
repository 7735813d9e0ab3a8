"""Inference: engines, the posterior, and what sums it up.

Names load on first use, because they bring torch and Pyro with them.
"""

from typing import TYPE_CHECKING

from sloop_ppl._rooms import load_later

if TYPE_CHECKING:
    from sloop_ppl.inference._enumeration import PYRO_LOCK
    from sloop_ppl.inference._log_evidence import LogEvidence
    from sloop_ppl.inference.answers import AnswerFactor, CheckedAnswer
    from sloop_ppl.inference.belief_comparison import BeliefComparison
    from sloop_ppl.inference.comparison import (
        EngineComparison,
        EngineRun,
        ModelScore,
        compare,
        rank_models,
    )
    from sloop_ppl.inference.engines import (
        ENGINES,
        Engine,
        Enumerate,
        Exact,
        Importance,
        InferenceInfo,
    )
    from sloop_ppl.inference.export_geojson import cells_geojson, write_geojson
    from sloop_ppl.inference.factors import DescriptionFactor
    from sloop_ppl.inference.frames import Framed, FrameSummary, modes_of
    from sloop_ppl.inference.hierarchical import sample_parameters
    from sloop_ppl.inference.infer import infer_batch, infer_description
    from sloop_ppl.inference.influence import Influence
    from sloop_ppl.inference.joint import JointPosterior
    from sloop_ppl.inference.lapses import Lapse
    from sloop_ppl.inference.learning import Example, Fitted, fit
    from sloop_ppl.inference.parameter_draws import ParameterDraws, ParameterSummary
    from sloop_ppl.inference.posterior import Posterior
    from sloop_ppl.inference.predictive import PhraseCheck
    from sloop_ppl.inference.prior import log_priors
    from sloop_ppl.inference.referents import GroundPosterior, ReadingPosterior, Referent
    from sloop_ppl.inference.refined import RefinedPosterior, infer_refined
    from sloop_ppl.inference.sampling import Nuts, Svi
    from sloop_ppl.inference.summaries import (
        Place,
        entropy_nats,
        expected_distance_m,
        expected_m,
        hpd_cells,
        hpd_places,
        mode_m,
        probability_in,
    )

__all__ = [
    "ENGINES",
    "PYRO_LOCK",
    "AnswerFactor",
    "BeliefComparison",
    "CheckedAnswer",
    "DescriptionFactor",
    "Engine",
    "EngineComparison",
    "EngineRun",
    "Enumerate",
    "Exact",
    "Example",
    "Fitted",
    "FrameSummary",
    "Framed",
    "GroundPosterior",
    "Importance",
    "InferenceInfo",
    "Influence",
    "JointPosterior",
    "Lapse",
    "LogEvidence",
    "ModelScore",
    "Nuts",
    "ParameterDraws",
    "ParameterSummary",
    "PhraseCheck",
    "Place",
    "Posterior",
    "ReadingPosterior",
    "Referent",
    "RefinedPosterior",
    "Svi",
    "cells_geojson",
    "compare",
    "entropy_nats",
    "expected_distance_m",
    "expected_m",
    "fit",
    "hpd_cells",
    "hpd_places",
    "infer_batch",
    "infer_description",
    "infer_refined",
    "log_priors",
    "mode_m",
    "modes_of",
    "probability_in",
    "rank_models",
    "sample_parameters",
    "write_geojson",
]

_HOMES = {
    "_enumeration": ("PYRO_LOCK",),
    "_log_evidence": ("LogEvidence",),
    "answers": ("AnswerFactor", "CheckedAnswer"),
    "belief_comparison": ("BeliefComparison",),
    "comparison": ("EngineComparison", "EngineRun", "ModelScore", "compare", "rank_models"),
    "engines": ("ENGINES", "Engine", "Enumerate", "Exact", "Importance", "InferenceInfo"),
    "export_geojson": ("cells_geojson", "write_geojson"),
    "factors": ("DescriptionFactor",),
    "frames": ("Framed", "FrameSummary", "modes_of"),
    "hierarchical": ("sample_parameters",),
    "infer": ("infer_batch", "infer_description"),
    "influence": ("Influence",),
    "joint": ("JointPosterior",),
    "lapses": ("Lapse",),
    "learning": ("Example", "Fitted", "fit"),
    "parameter_draws": ("ParameterDraws", "ParameterSummary"),
    "posterior": ("Posterior",),
    "predictive": ("PhraseCheck",),
    "prior": ("log_priors",),
    "referents": ("GroundPosterior", "ReadingPosterior", "Referent"),
    "refined": ("RefinedPosterior", "infer_refined"),
    "sampling": ("Nuts", "Svi"),
    "summaries": (
        "Place",
        "entropy_nats",
        "expected_distance_m",
        "expected_m",
        "hpd_cells",
        "hpd_places",
        "mode_m",
        "probability_in",
    ),
}
__getattr__ = load_later(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted(__all__)
