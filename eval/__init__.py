"""Evaluation: description files with their truth, and what methods make of them."""

from sloop_ppl.eval.describe import SetSummary, describe_set
from sloop_ppl.eval.descriptions import (
    DescribedScene,
    FrameAnnotation,
    Place,
    bundled_examples,
    read_descriptions,
)
from sloop_ppl.eval.parsing import ParseScore, score_parser
from sloop_ppl.eval.quality import BeliefQuality, ModelQuality, score_beliefs
from sloop_ppl.eval.results import Results, read_results
from sloop_ppl.eval.trials import Searching, Trial, TrialKey

__all__ = [
    "BeliefQuality",
    "DescribedScene",
    "FrameAnnotation",
    "ModelQuality",
    "ParseScore",
    "Place",
    "Results",
    "Searching",
    "SetSummary",
    "Trial",
    "TrialKey",
    "bundled_examples",
    "describe_set",
    "read_descriptions",
    "read_results",
    "score_beliefs",
    "score_parser",
]
