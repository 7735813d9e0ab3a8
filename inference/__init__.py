"""Inference: engines, the posterior, and what sums it up."""

from sloop_ppl.inference.compare import EngineComparison, EngineRun, compare
from sloop_ppl.inference.engine import ENGINES, Engine, InferenceInfo, LogFactors
from sloop_ppl.inference.enumerate import enumerate_all, enumerated_joint
from sloop_ppl.inference.exact import enumerated_log_factors, exact
from sloop_ppl.inference.export_geojson import cells_geojson, write_geojson
from sloop_ppl.inference.frames import FrameSummary
from sloop_ppl.inference.hierarchical import sample_parameters
from sloop_ppl.inference.importance import importance
from sloop_ppl.inference.infer import infer_description
from sloop_ppl.inference.influence import Influence
from sloop_ppl.inference.lapses import Lapse
from sloop_ppl.inference.learning import Example, Fitted, fit
from sloop_ppl.inference.log_evidence import LogEvidence, ModelScore, rank_models
from sloop_ppl.inference.nuts import nuts
from sloop_ppl.inference.parameter_draws import ParameterDraws, ParameterSummary
from sloop_ppl.inference.posterior import Posterior
from sloop_ppl.inference.prior import log_priors
from sloop_ppl.inference.said import Said
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
from sloop_ppl.inference.svi import svi

__all__ = [
    "ENGINES",
    "Engine",
    "EngineComparison",
    "EngineRun",
    "Example",
    "Fitted",
    "FrameSummary",
    "InferenceInfo",
    "Influence",
    "Lapse",
    "LogEvidence",
    "LogFactors",
    "ModelScore",
    "ParameterDraws",
    "ParameterSummary",
    "Place",
    "Posterior",
    "Said",
    "cells_geojson",
    "compare",
    "entropy_nats",
    "enumerate_all",
    "enumerated_joint",
    "enumerated_log_factors",
    "exact",
    "expected_distance_m",
    "expected_m",
    "fit",
    "hpd_cells",
    "hpd_places",
    "importance",
    "infer_description",
    "log_priors",
    "mode_m",
    "nuts",
    "probability_in",
    "rank_models",
    "sample_parameters",
    "svi",
    "write_geojson",
]
