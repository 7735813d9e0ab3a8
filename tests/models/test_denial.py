"""A denied phrase is 1 - denial g / max g, divided by its sum over the map."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from sloop_ppl.inference import Enumerate, infer_description
from sloop_ppl.language import SpatialRelation
from sloop_ppl.models import Component, ground_description, ground_relations, preset, program_data
from sloop_ppl.models.tuning import with_parameters
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(15), house=(12.0, -7.0), street_y=30.0)
PLAIN = replace(preset("bayes"), lapse=0.0, temper=0.0)


def belief(*relations, model=PLAIN, **options):
    return infer_description(said(*relations), CITY, model, **options)[0].belief(TARGET)


@pytest.mark.parametrize("word", ["near", "on", "north"])
@pytest.mark.parametrize("denial", [0.0, 0.5, 1.0])
def test_by_hand_without_frames(word, denial):
    asserted = belief(relation(word, "House"))
    expected = 1 - denial * asserted / asserted.max()
    got = belief(relation(word, "House", negated=True), model=replace(PLAIN, denial=denial))
    np.testing.assert_allclose(got, expected / expected.sum(), rtol=1e-9, atol=1e-15)


def test_denying_nothing_tells_nothing_and_denying_all_rules_the_peak_out():
    nothing = belief(relation("near", "House", negated=True), model=replace(PLAIN, denial=0.0))
    np.testing.assert_allclose(nothing, 1 / CITY.grid.size)
    sure = belief(relation("near", "House", negated=True), model=replace(PLAIN, denial=1.0))
    assert sure[CITY.grid.cell_at(12.0, -7.0)] < 1e-12
    usual = belief(relation("near", "House", negated=True))
    assert 0 < usual[CITY.grid.cell_at(12.0, -7.0)] < 0.1 / CITY.grid.size


def test_a_denied_frame_word_agrees_with_enumeration_of_its_fronts():
    for word in ("behind", "left"):
        denied = relation(word, "House", negated=True)
        np.testing.assert_allclose(
            belief(denied, model=preset("bayes")),
            belief(denied, model=preset("bayes"), engine=Enumerate(1440)),
            atol=1e-12,
        )


@pytest.mark.parametrize("word", ["behind", "left"])
def test_a_denied_frame_word_by_hand(word):
    """The greatest g is over all cells and 72 fronts; 1 - denial g / max g is then averaged."""
    (term,) = ground_relations((relation(word, "House"),), CITY)
    round_, prior = torch.arange(72) * (2 * math.pi / 72), PLAIN.frame_prior(term)
    peak = PLAIN.likelihood.log_g(term, term.directions(round_)).max()
    mean = PLAIN.likelihood.log_marginal(term, prior)
    expected = (1 - PLAIN.denial * (mean - peak).exp()).reshape(CITY.grid.shape).numpy()
    got = belief(relation(word, "House", negated=True))
    np.testing.assert_allclose(got, expected / expected.sum(), rtol=1e-9)


def test_the_deeper_in_what_was_denied_the_less_likely():
    got = belief(relation("near", "House", negated=True))
    away = CITY.fields("House").distance_m
    order = np.argsort(away, axis=None)
    assert (np.diff(got.reshape(-1)[order]) >= -1e-15).all()


def test_the_share_is_a_number_of_the_model():
    half = with_parameters(preset("bayes"), {"model": {"denial": 0.5}})
    assert half.denial == 0.5


def test_under_truth_a_denial_stays_the_probability_that_it_is_false():
    model = replace(PLAIN, normalisation="truth")
    asserted, denied = (
        infer_description(said(relation("near", "House", negated=n)), CITY, model)[0]
        for n in (False, True)
    )
    g, other = (np.exp(p.factors[0].log_factors[TARGET][0]) for p in (asserted, denied))
    cells = g < g.max() * (1 - 1e-9)  # at g = 1 the denial is held above zero
    np.testing.assert_allclose((g + other)[cells], model.components[0].weight, rtol=1e-9)


# -- "not near a bank" ------------------------------------------------------------------------


def denying_each(grounds, relation_word="near"):
    each = SpatialRelation(TARGET, relation_word, grounds, negated=True, each=True)
    return said(relation("near", "MainSt"), each)


def test_a_denial_of_each_is_the_product_over_its_grounds():
    """By hand: prod_c (1 - delta g_c / max g_c), normalised over the map."""
    model = replace(PLAIN, denial=0.9, components=(Component("literal"),))
    posterior, _ = infer_description(denying_each(("House", "MainSt")), CITY, model)
    expected = np.ones(CITY.grid.size)
    for ground in ("House", "MainSt"):
        g = infer_description(said(relation("near", ground)), CITY, model)[0].belief(TARGET).ravel()
        expected *= 1 - 0.9 * g / g.max()
        if ground == "MainSt":
            expected *= g
    np.testing.assert_allclose(posterior.belief(TARGET).ravel(), expected / expected.sum())


def test_a_denial_of_each_is_one_phrase_to_the_temper():
    """Else "near Main Street and not near a bank" would say less of the street per bank."""
    model = replace(PLAIN, temper=0.5)
    data = [
        program_data(ground_description(denying_each(grounds), CITY, model), CITY, model)
        for grounds in (("House",), ("House", "MainSt"))
    ]
    assert [float(one.n_phrases[0].reshape(-1)[0]) for one in data] == [2.0, 2.0]
    posterior, _ = infer_description(denying_each(("House", "MainSt")), CITY, model)
    assert len(posterior.relations(TARGET)) == len(posterior.phrase_tables(TARGET)) == 2
    assert len(posterior.grounded(TARGET)) == 3
