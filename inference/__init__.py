"""Inference: engines, the posterior, and what sums it up."""

from sloop_ppl.inference.engine import ENGINES, Engine, InferenceInfo, LogFactors
from sloop_ppl.inference.exact import enumerated_log_factors, exact
from sloop_ppl.inference.frames import FrameSummary
from sloop_ppl.inference.infer import infer_description
from sloop_ppl.inference.posterior import Posterior
from sloop_ppl.inference.prior import log_priors
from sloop_ppl.inference.said import Said
from sloop_ppl.inference.summaries import entropy_nats, expected_m, hpd_cells, mode_m

__all__ = [
    "ENGINES",
    "Engine",
    "FrameSummary",
    "InferenceInfo",
    "LogFactors",
    "Posterior",
    "Said",
    "entropy_nats",
    "enumerated_log_factors",
    "exact",
    "expected_m",
    "hpd_cells",
    "infer_description",
    "log_priors",
    "mode_m",
]
