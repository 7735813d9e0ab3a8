"""Relation likelihoods: how true a relation is of each cell."""

from sloop_ppl.models.likelihoods.base import LIKELIHOODS, RelationLikelihood
from sloop_ppl.models.likelihoods.cosine import bessel_ratios, expected_cosine
from sloop_ppl.models.likelihoods.gaussian import GaussianLikelihood
from sloop_ppl.models.likelihoods.marginal import (
    ClosedFormMarginal,
    frame_marginal,
    marginal_over,
)

__all__ = [
    "LIKELIHOODS",
    "ClosedFormMarginal",
    "GaussianLikelihood",
    "RelationLikelihood",
    "bessel_ratios",
    "expected_cosine",
    "frame_marginal",
    "marginal_over",
]
