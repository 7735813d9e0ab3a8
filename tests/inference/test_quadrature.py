"""Frames summed out in closed form against plain enumeration of the program over 1440 bins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sloop_ppl.inference import Enumerate, Exact, infer_description
from sloop_ppl.models import LIKELIHOODS, PredictedPoint, PredictedSpread, preset
from tests.scenes import house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(15), house=(12.0, -7.0), street_y=30.0)
SPOKEN = said(
    relation("behind", "House", figure="A"),
    relation("left", "House", figure="A"),
    relation("near", "MainSt", negated=True, figure="A"),
    relation("front", "MainSt", figure="B"),
    relation("south", "MainSt", figure="B"),
    targets=("A", "B"),
)
FRAMES = {
    "spread": PredictedSpread(),
    "sharp": PredictedSpread(kappa=40.0),
    "points": PredictedPoint(),
}


@pytest.mark.parametrize("frames", FRAMES)
@pytest.mark.parametrize("name", LIKELIHOODS)
def test_the_closed_form_is_the_sum_over_bins(name, frames):
    """Within what each kernel declares: 1e-10 where it is smooth, more where it has a kink."""
    likelihood = LIKELIHOODS[name]
    model = replace(preset("bayes"), likelihood=likelihood, frame_prior=FRAMES[frames], temper=0.0)
    exact, _ = infer_description(SPOKEN, CITY, model, Exact())
    full, _ = infer_description(SPOKEN, CITY, model, Enumerate(1440))
    limit = 1e-10 if frames == "points" else likelihood.quadrature_error
    for target in exact.targets:
        apart = 0.5 * np.abs(exact.belief(target) - full.belief(target)).sum()
        assert apart <= limit
    assert float(full.log_evidence) == pytest.approx(float(exact.log_evidence), abs=10 * limit)


def test_the_closed_forms_that_jump_or_bend_say_so():
    declared = {name: LIKELIHOODS[name].quadrature_error for name in LIKELIHOODS}
    smooth = {name for name, error in declared.items() if error <= 1e-10}
    assert smooth == {"student-vonmises", "neural"}
