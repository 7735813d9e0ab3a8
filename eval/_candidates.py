"""The models among which `sloop eval fit` chooses."""

from __future__ import annotations

from dataclasses import replace

from sloop_ppl.models import (
    FRAME_PREDICTORS,
    LIKELIHOODS,
    PRESETS,
    UNFITTED_BAYES,
    Component,
    ObservationModel,
    PredictedSpread,
)
from sloop_ppl.registry import Registry

__all__ = ["CANDIDATES", "FAMILIES"]

CANDIDATES: Registry[ObservationModel] = Registry("candidate")
"""`bayes` before its fit, with one thing changed in each."""

FAMILIES = ("student-vonmises", "gaussian-clipped", "gaussian-cosine")
"""The likelihood families that the one of `bayes` is chosen from."""

for _family in FAMILIES:
    CANDIDATES.add(_family, replace(UNFITTED_BAYES, likelihood=LIKELIHOODS[_family]))

CANDIDATES.add("product-only", replace(UNFITTED_BAYES, components=(Component("product"),)))
CANDIDATES.add(
    "with-four-components",
    replace(
        UNFITTED_BAYES,
        components=tuple(replace(part, cut=False) for part in PRESETS["sloop-m4"].components),
    ),
)
CANDIDATES.add(
    "with-nearest-street",
    replace(UNFITTED_BAYES, frame_prior=PredictedSpread(FRAME_PREDICTORS["nearest-street"])),
)
