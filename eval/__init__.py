"""Evaluation: description files with their truth, and what methods make of them."""

from sloop_ppl.eval.descriptions import (
    DescribedScene,
    FrameAnnotation,
    Place,
    bundled_examples,
    read_descriptions,
)
from sloop_ppl.eval.parsing import ParseScore, score_parser
from sloop_ppl.eval.quality import BeliefQuality, ModelQuality, score_beliefs

__all__ = [
    "BeliefQuality",
    "DescribedScene",
    "FrameAnnotation",
    "ModelQuality",
    "ParseScore",
    "Place",
    "bundled_examples",
    "read_descriptions",
    "score_beliefs",
    "score_parser",
]
