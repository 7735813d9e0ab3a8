"""Evaluation: description files with their truth, and what methods make of them.

Names load on first use, because some of them bring torch with them.
"""

from typing import TYPE_CHECKING

from sloop_ppl._rooms import load_later

if TYPE_CHECKING:
    from sloop_ppl.eval.crossval import examples_of
    from sloop_ppl.eval.describe import SetSummary, describe_set
    from sloop_ppl.eval.descriptions import (
        AnnotatedDescription,
        FrameAnnotation,
        Place,
        bundled_examples,
        read_descriptions,
    )
    from sloop_ppl.eval.many import InferredBeliefs, infer_many
    from sloop_ppl.eval.metrics import METRICS
    from sloop_ppl.eval.parsing import ParseScore, score_parser
    from sloop_ppl.eval.quality import BeliefQuality, ModelQuality, score_beliefs
    from sloop_ppl.eval.results import Results, read_results
    from sloop_ppl.eval.trials import Searching, Trial, TrialKey

__all__ = [
    "METRICS",
    "AnnotatedDescription",
    "BeliefQuality",
    "FrameAnnotation",
    "InferredBeliefs",
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
    "examples_of",
    "infer_many",
    "read_descriptions",
    "read_results",
    "score_beliefs",
    "score_parser",
]

_HOMES = {
    "crossval": ("examples_of",),
    "describe": ("SetSummary", "describe_set"),
    "descriptions": (
        "AnnotatedDescription",
        "FrameAnnotation",
        "Place",
        "bundled_examples",
        "read_descriptions",
    ),
    "many": ("InferredBeliefs", "infer_many"),
    "metrics": ("METRICS",),
    "parsing": ("ParseScore", "score_parser"),
    "quality": ("BeliefQuality", "ModelQuality", "score_beliefs"),
    "results": ("Results", "read_results"),
    "trials": ("Searching", "Trial", "TrialKey"),
}
__getattr__ = load_later(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted(__all__)
