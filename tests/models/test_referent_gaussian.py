"""`referent-gaussian`: a mixture over referents of Gaussians about them, solved by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from sloop_ppl.inference import infer_description
from sloop_ppl.language import Candidate, Distance
from sloop_ppl.models import (
    REFERENT_GAUSSIAN,
    UNFITTED_REFERENT_GAUSSIAN,
    ground_relations,
    preset,
    unfitted,
)
from sloop_ppl.models.likelihoods import DisplacementLikelihood, parameters_of
from tests.scenes import TARGET, house_and_street, point_city, relation, said, symmetric_grid

GRID = symmetric_grid(21)  # centres at multiples of 5 m, to 50
CITY = point_city(GRID, Pole=(0.0, 0.0), Post=(-30.0, 20.0))
KERNEL = DisplacementLikelihood(
    near_m=12.0, near_street_m=20.0, contact_street_m=7.0, ahead_m=13.0, along_m=10.0, aside_m=6.0
)
MODEL = replace(UNFITTED_REFERENT_GAUSSIAN, likelihood=KERNEL, lapse=0.0, temper=0.0)
X, Y = np.meshgrid(GRID.x_m, GRID.y_m)
EAST, NORTH = 0.0, math.pi / 2


def log_g(word, direction=None, city=CITY, ground="Pole", **changes):
    (term,) = ground_relations((replace(relation(word, ground), **changes),), city, joint=True)
    angles = None if direction is None else torch.tensor([direction], dtype=torch.float64)
    return KERNEL.log_g(term, angles).numpy().reshape(GRID.shape)


def at(table, x, y):
    return table[GRID.cell_at(x, y)]


def gaussian(x, y):
    log_p = -((X - x) ** 2 + (Y - y) ** 2) / (2 * 12.0**2)
    return np.exp(log_p) / np.exp(log_p).sum()


def test_directed_words_are_an_ellipse_ahead_of_the_referent():
    table = log_g("north", NORTH)
    assert at(table, 10, 20) == pytest.approx(-(7**2) / 200 - 10**2 / 72)
    assert at(table, 10, -20) == pytest.approx(-(33**2) / 200 - 10**2 / 72)
    assert at(table, 0, 0) == pytest.approx(-(13**2) / 200)
    np.testing.assert_allclose(log_g("east", EAST), table.T[:, ::1], atol=1e-12)
    np.testing.assert_allclose(table, table[:, ::-1], atol=1e-12)


def test_other_words_are_a_disc():
    assert at(log_g("near"), 9.9, 20) == pytest.approx(-(10**2 + 20**2) / (2 * 12**2))


def test_a_street_is_a_ridge():
    city = house_and_street(GRID, street_y=40.0)
    table = log_g("near", city=city, ground="MainSt")
    assert at(table, -30, 0) == at(table, 25, 0)
    rows = {y: at(table, 0, y) for y in (0, 20)}
    (term,) = ground_relations((relation("near", "MainSt"),), city, joint=True)
    d = {y: at(term.distance_m.numpy().reshape(GRID.shape), 0, y) for y in rows}
    assert d[0] > d[20] > 10
    assert rows == {y: pytest.approx(-(d[y] ** 2) / (2 * 20.0**2)) for y in rows}


def test_said_distances():
    ring = log_g("near", distance_m=40.0)  # deviation 10, a quarter of it
    assert at(ring, 40, 0) == pytest.approx(0)
    assert at(ring, 0, 20) == pytest.approx(-(20**2) / 200)
    ahead = log_g("north", NORTH, distance_m=40.0)
    assert at(ahead, 0, 40) == pytest.approx(0)
    assert at(ahead, 10, 30) == pytest.approx(-(10**2) / 200 - 10**2 / 72)
    within = log_g("north", NORTH, distance=Distance(0.0, 25.0))
    assert at(within, 0, 5) == at(within, 0, 25) == pytest.approx(0)
    assert at(within, 5, 20) == pytest.approx(-(5**2) / 72)
    assert at(within, 0, -20) == pytest.approx(-(20**2) / 200)
    assert at(within, 0, 45) == pytest.approx(-(20**2) / (2 * 10**2))


def test_the_belief_is_a_mixture_over_what_is_meant_and_nothing():
    spoken = replace(
        relation("near", "Pole"),
        candidates=((Candidate("Pole", 0.6), Candidate("Post", 0.3), Candidate(None, 0.1)),),
    )
    post, _ = infer_description(said(spoken), CITY, MODEL)
    expected = 0.6 * gaussian(0, 0) + 0.3 * gaussian(-30, 20) + 0.1 / GRID.size
    np.testing.assert_allclose(post.belief(TARGET), expected, atol=1e-15)
    both, _ = infer_description(said(spoken, relation("near", "Post")), CITY, MODEL)
    product = expected * gaussian(-30, 20)
    np.testing.assert_allclose(both.belief(TARGET), product / product.sum(), atol=1e-15)


def test_a_phrase_may_lapse():
    post, _ = infer_description(said(relation("near", "Pole")), CITY, replace(MODEL, lapse=0.2))
    expected = 0.8 * gaussian(0, 0) + 0.2 / GRID.size
    np.testing.assert_allclose(post.belief(TARGET), expected, atol=1e-15)


def test_it_takes_the_most_probable_reading_and_all_referents():
    assert not REFERENT_GAUSSIAN.sum_readings
    assert REFERENT_GAUSSIAN.sum_grounds


def test_the_shipped_numbers_are_those_of_a_fit():
    assert preset("referent-gaussian") == REFERENT_GAUSSIAN
    assert unfitted(REFERENT_GAUSSIAN) == UNFITTED_REFERENT_GAUSSIAN
    moved = {
        p.name
        for p in parameters_of(REFERENT_GAUSSIAN.likelihood)
        if getattr(REFERENT_GAUSSIAN.likelihood, p.name) != p.prior_median
    }
    assert {p.name for p in parameters_of(KERNEL)} == moved
    assert 0 < REFERENT_GAUSSIAN.lapse < 0.1
