"""Relation likelihoods: how true a relation is of each cell."""

from sloop_ppl.models.likelihoods._base import LIKELIHOODS, RelationLikelihood
from sloop_ppl.models.likelihoods._cosine import bessel_ratios, expected_cosine
from sloop_ppl.models.likelihoods._marginal import (
    ClosedFormMarginal,
    frame_marginal,
    marginal_over,
    summed_within,
)
from sloop_ppl.models.likelihoods._parameters import (
    Parameter,
    parameters_of,
    share_parameter,
    with_values,
)
from sloop_ppl.models.likelihoods.attention import AttentionVectorSumLikelihood
from sloop_ppl.models.likelihoods.box import BoxLikelihood
from sloop_ppl.models.likelihoods.displacement import DisplacementLikelihood
from sloop_ppl.models.likelihoods.gaussian import GaussianLikelihood
from sloop_ppl.models.likelihoods.neural import NeuralLikelihood
from sloop_ppl.models.likelihoods.student import StudentVonMisesLikelihood

__all__ = [
    "LIKELIHOODS",
    "AttentionVectorSumLikelihood",
    "BoxLikelihood",
    "ClosedFormMarginal",
    "DisplacementLikelihood",
    "GaussianLikelihood",
    "NeuralLikelihood",
    "Parameter",
    "RelationLikelihood",
    "StudentVonMisesLikelihood",
    "bessel_ratios",
    "expected_cosine",
    "frame_marginal",
    "marginal_over",
    "parameters_of",
    "share_parameter",
    "summed_within",
    "with_values",
]
