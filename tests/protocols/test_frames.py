"""Every registered frame prior and predictor keeps the protocol's promises."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from sloop_ppl.inference import infer_description
from sloop_ppl.models import FRAME_PREDICTORS, FRAME_PRIORS, LIKELIHOODS, ground_relations, preset
from sloop_ppl.models.likelihoods import frame_marginal
from tests.scenes import TARGET, house_and_street, point_city, relation, said, symmetric_grid

GRID = symmetric_grid(21)
CITY = house_and_street(GRID, house=(12.0, -7.0), street_y=30.0)
WORDS = ("front", "behind", "left", "right")


def term_of(word, ground="House", city=CITY):
    return ground_relations((relation(word, ground),), city)[0]


def check_distribution(frame):
    weights = [part.weight for part in frame.parts]
    assert sum(weights) + frame.lapse == pytest.approx(1)
    assert min([*weights, frame.lapse]) >= -1e-12
    for part in frame.parts:
        assert math.isfinite(part.mean_rad)
        assert part.kappa >= 0
    assert frame.binned(24).sum() == pytest.approx(1)


@pytest.mark.parametrize("name", FRAME_PREDICTORS)
@pytest.mark.parametrize("ground", ["House", "MainSt", "Map"])
def test_a_predictor_gives_a_distribution_for_any_ground(name, ground):
    check_distribution(FRAME_PREDICTORS[name](term_of("front", ground)))


@pytest.mark.parametrize("name", FRAME_PREDICTORS)
def test_a_predictor_gives_a_distribution_without_streets_and_for_points(name):
    lonely = point_city(GRID, Pole=(0.0, 0.0), Post=(-50.0, 50.0))
    for ground in ("Pole", "Post"):
        check_distribution(FRAME_PREDICTORS[name](term_of("front", ground, lonely)))


@pytest.mark.parametrize("name", FRAME_PREDICTORS)
def test_a_predictor_says_the_same_twice(name):
    again = house_and_street(GRID, house=(12.0, -7.0), street_y=30.0)
    first = FRAME_PREDICTORS[name](term_of("front"))
    assert FRAME_PREDICTORS[name](term_of("front", city=again)) == first


@pytest.mark.parametrize("name", FRAME_PRIORS)
@pytest.mark.parametrize("word", WORDS)
@pytest.mark.parametrize("ground", ["House", "MainSt"])
def test_a_prior_gives_a_distribution_for_any_frame_word(name, word, ground):
    check_distribution(FRAME_PRIORS[name](term_of(word, ground)))


@pytest.mark.parametrize("name", FRAME_PRIORS)
@pytest.mark.parametrize("word", WORDS)
def test_exact_inference_is_the_sum_over_the_parts(name, word):
    """The closed form agrees with summing the front over the bins of the prior one by one."""
    term = term_of(word)
    prior = FRAME_PRIORS[name](term)
    likelihood = LIKELIHOODS["gaussian-clipped"]
    angles, mass = prior.bins(2880)
    g = likelihood.log_g(term, torch.from_numpy(angles) + term.offset_rad).exp()
    expected = torch.from_numpy(mass) @ g
    torch.testing.assert_close(
        frame_marginal(likelihood, term, prior).exp(), expected, atol=2e-6, rtol=1e-4
    )


@pytest.mark.parametrize("name", FRAME_PRIORS)
def test_a_prior_serves_in_a_model(name):
    model = replace(preset("bayes"), frame_prior=FRAME_PRIORS[name])
    posterior, _ = infer_description(said(relation("behind", "House")), CITY, model, "exact")
    belief = posterior.belief(TARGET)
    assert belief.sum() == pytest.approx(1)
    assert np.isfinite(belief).all()
    shares = [frame.p for frame in posterior.frames(TARGET)]
    assert len(shares) == len(FRAME_PRIORS[name](term_of("behind")).parts)
    assert sum(shares) <= 1 + 1e-9
