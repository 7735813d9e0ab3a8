"""Evaluation: description files with their truth, and what methods make of them."""

from sloop_ppl.eval.descriptions import (
    DescribedScene,
    FrameAnnotation,
    Place,
    bundled_examples,
    read_descriptions,
)

__all__ = [
    "DescribedScene",
    "FrameAnnotation",
    "Place",
    "bundled_examples",
    "read_descriptions",
]
