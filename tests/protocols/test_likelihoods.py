"""Every registered likelihood keeps the protocol's promises."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch

from sloop_ppl.language import RELATIONS
from sloop_ppl.models import LIKELIHOODS, FrameDistribution, FramePart, ground_relations
from sloop_ppl.models.likelihoods import frame_marginal
from tests.scenes import house_and_street, relation, symmetric_grid

CITY = house_and_street(symmetric_grid(21), house=(12.0, -7.0), street_y=30.0)
FRAMES = {
    "point": FrameDistribution((FramePart(0.7, math.inf),)),
    "narrow": FrameDistribution((FramePart(0.7, 40.0),)),
    "wide": FrameDistribution((FramePart(-2.0, 1.5, 0.8),), lapse=0.2),
    "two": FrameDistribution((FramePart(0.3, 6.0, 0.5), FramePart(-2.8, 6.0, 0.5))),
    "uniform": FrameDistribution((), lapse=1.0),
}


def term_of(word, ground="House"):
    return ground_relations((relation(word, ground),), CITY)[0]


def directions_of(term, count=720):
    if term.needs_frame:
        return torch.linspace(-math.pi, math.pi, count + 1, dtype=torch.float64)[:-1]
    if term.compass_rad is not None:
        return torch.tensor([term.compass_rad], dtype=torch.float64)
    return None


@pytest.mark.parametrize("name", LIKELIHOODS)
@pytest.mark.parametrize("word", sorted(RELATIONS))
@pytest.mark.parametrize("ground", ["House", "MainSt"])
def test_log_g_is_a_log_probability_of_the_right_shape(name, word, ground):
    term = term_of(word, ground)
    directions = directions_of(term, count=7)
    log_g = LIKELIHOODS[name].log_g(term, directions)
    leading = () if directions is None else (len(directions),)
    assert log_g.shape == (*leading, CITY.grid.size)
    assert log_g.dtype == torch.float64
    assert torch.isfinite(log_g).all()
    assert (log_g <= 0).all()


@pytest.mark.parametrize("name", LIKELIHOODS)
@pytest.mark.parametrize("word", ["front", "behind", "left", "right"])
@pytest.mark.parametrize("frame", FRAMES)
def test_the_frame_marginal_agrees_with_quadrature(name, word, frame):
    term, prior = term_of(word), FRAMES[frame]
    fronts = torch.linspace(-math.pi, math.pi, 1441, dtype=torch.float64)[:-1]
    g = LIKELIHOODS[name].log_g(term, fronts + term.offset_rad).exp()
    expected = prior.lapse * g.mean(0)
    for part in prior.parts:
        if math.isinf(part.kappa):
            at = torch.tensor([part.mean_rad + term.offset_rad], dtype=torch.float64)
            expected = expected + part.weight * LIKELIHOODS[name].log_g(term, at).exp()[0]
        else:
            density = torch.from_numpy(np.exp(part.log_density(fronts.numpy())))
            expected = expected + part.weight * (density / density.sum()) @ g
    got = frame_marginal(LIKELIHOODS[name], term, prior).exp()
    assert 0.5 * (got / got.sum() - expected / expected.sum()).abs().sum() < 1e-5
    torch.testing.assert_close(got, expected, atol=1e-5, rtol=1e-4)


@pytest.mark.parametrize("name", LIKELIHOODS)
def test_a_relation_is_truest_in_its_own_direction(name):
    """Of the cells 20 m from the centroid, the truest lies where the relation points."""
    term = term_of("east")
    log_g = LIKELIHOODS[name].log_g(term, directions_of(term))[0].reshape(CITY.grid.shape)
    x, y = CITY.centroid("House")
    at = {
        where: log_g[CITY.grid.cell_at(x + dx, y + dy)]
        for where, dx, dy in (("east", 20, 0), ("north", 0, 20), ("northeast", 14, 14))
    }
    assert at["east"] > at["northeast"] > at["north"]
