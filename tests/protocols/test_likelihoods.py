"""Every registered likelihood keeps the protocol's promises."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import torch

from sloop_ppl.language import RELATIONS
from sloop_ppl.models import LIKELIHOODS, FrameDistribution, FramePart, ground_relations
from sloop_ppl.models.check import check_likelihood
from sloop_ppl.models.likelihoods import frame_marginal, parameters_of, with_values
from tests.scenes import house_and_street, relation, symmetric_grid

CITY = house_and_street(symmetric_grid(21), house=(12.0, -7.0), street_y=30.0)
FRAMES = {
    "point": FrameDistribution((FramePart(0.7, math.inf),)),
    "narrow": FrameDistribution((FramePart(0.7, 40.0),)),
    "wide": FrameDistribution((FramePart(-2.0, 1.5, 0.8),), lapse=0.2),
    "two": FrameDistribution((FramePart(0.3, 6.0, 0.5), FramePart(-2.8, 6.0, 0.5))),
    "uniform": FrameDistribution((), lapse=1.0),
}
JUMPING = ("box",)
"""Likelihoods that jump with direction, whose quadrature converges slowly."""


def term_of(word, *grounds, joint=False, **said):
    spoken = replace(relation(word, *(grounds or ("House",))), **said)
    (term,) = ground_relations((spoken,), CITY, joint=joint)
    return term


def directions_of(term, count=720):
    if term.needs_frame:
        return torch.linspace(-math.pi, math.pi, count + 1, dtype=torch.float64)[:-1]
    if term.compass_rad is not None:
        return torch.tensor([term.compass_rad], dtype=torch.float64)
    return None


@pytest.mark.parametrize("name", LIKELIHOODS)
def test_it_passes_the_check_that_users_run(name):
    check_likelihood(LIKELIHOODS[name])


@pytest.mark.parametrize("name", LIKELIHOODS)
@pytest.mark.parametrize("grounds", [("House",), ("MainSt",), ("Map",), ("House", "MainSt")])
@pytest.mark.parametrize("joint", [False, True])
def test_log_g_is_a_log_probability_of_the_right_shape(name, grounds, joint):
    for word in sorted(RELATIONS):
        for term in ground_relations((relation(word, *grounds),), CITY, joint=joint):
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
    count, within = (23040, 1e-3) if name in JUMPING else (1440, 1e-5)
    fronts = torch.linspace(-math.pi, math.pi, count + 1, dtype=torch.float64)[:-1]
    chunks = (fronts + term.offset_rad).split(1440)
    g = torch.cat([LIKELIHOODS[name].log_g(term, some).exp() for some in chunks])
    expected = prior.lapse * g.mean(0)
    for part in prior.parts:
        if math.isinf(part.kappa):
            at = torch.tensor([part.mean_rad + term.offset_rad], dtype=torch.float64)
            expected = expected + part.weight * LIKELIHOODS[name].log_g(term, at).exp()[0]
        else:
            shape = torch.softmax(part.kappa * torch.cos(fronts - part.mean_rad), 0)
            expected = expected + part.weight * shape @ g
    got = frame_marginal(LIKELIHOODS[name], term, prior).exp()
    assert 0.5 * (got / got.sum() - expected / expected.sum()).abs().sum() < within
    torch.testing.assert_close(got, expected, atol=within, rtol=1e-4)


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
    assert at["east"] >= at["northeast"] >= at["north"]
    assert at["east"] > at["north"]


@pytest.mark.parametrize("name", LIKELIHOODS)
def test_a_said_distance_is_a_ring(name):
    term = term_of("near", distance_m=30.0)
    log_g = LIKELIHOODS[name].log_g(term, None)
    ring = (term.distance_m - 30).abs() < 4
    assert log_g[ring].min() >= log_g[term.distance_m < 10].max()
    assert log_g[ring].min() > log_g[term.on_ground].max()


@pytest.mark.parametrize("name", LIKELIHOODS)
def test_parameters_are_declared_as_they_stand(name):
    likelihood = LIKELIHOODS[name]
    declared = parameters_of(likelihood)
    assert len({p.name for p in declared}) == len(declared)
    for parameter in declared:
        value = parameter.checked(getattr(likelihood, parameter.name))
        assert parameter.prior_median == pytest.approx(value, rel=0.02)
        assert parameter.unit in ("m", "rad", "1")
        assert parameter.meaning
        moved = with_values(likelihood, {parameter.name: parameter.prior_median * 1.01})
        assert getattr(moved, parameter.name) == parameter.prior_median * 1.01


@pytest.mark.parametrize("name", LIKELIHOODS)
@pytest.mark.parametrize("word", ["front", "near", "on", "north"])
def test_marginals_are_differentiable_where_parameters_are_declared(name, word):
    likelihood, term = LIKELIHOODS[name], term_of(word)
    tensors = {
        p.name: torch.tensor(getattr(likelihood, p.name), dtype=torch.float64, requires_grad=True)
        for p in parameters_of(likelihood)
    }
    if not tensors or not term.needs_frame:
        pytest.skip("it declares none, or the word has no frame")
    learning = with_values(likelihood, tensors)
    frame_marginal(learning, term, FRAMES["wide"]).logsumexp(0).backward()
    reached = [t.grad for t in tensors.values() if t.grad is not None]
    assert reached
    assert all(torch.isfinite(slope) for slope in reached)
