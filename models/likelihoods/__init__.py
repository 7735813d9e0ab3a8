"""Relation likelihoods: how true a relation is of each cell."""

from sloop_ppl.models.likelihoods.base import LIKELIHOODS, RelationLikelihood
from sloop_ppl.models.likelihoods.cosine import bessel_ratios, expected_cosine
from sloop_ppl.models.likelihoods.gaussian import GaussianLikelihood

__all__ = [
    "LIKELIHOODS",
    "GaussianLikelihood",
    "RelationLikelihood",
    "bessel_ratios",
    "expected_cosine",
]
