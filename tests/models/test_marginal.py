"""The frame summed out by quadrature, held against sums worked out otherwise."""

from __future__ import annotations

import math

import pytest
import torch

from sloop_ppl.models import FrameDistribution, FramePart, GaussianLikelihood, ground_relations
from sloop_ppl.models.likelihoods import frame_marginal, marginal_over, summed_within
from tests.scenes import house_and_street, relation, symmetric_grid

CITY = house_and_street(symmetric_grid(21), house=(12.0, -7.0), street_y=30.0)
FRAMES = {
    "point": FrameDistribution((FramePart(0.7, math.inf),)),
    "two points": FrameDistribution((FramePart(0.7, math.inf, 0.4), FramePart(-2, math.inf, 0.6))),
    "sharp": FrameDistribution((FramePart(0.7, 5000.0),)),
    "narrow": FrameDistribution((FramePart(0.7, 40.0),)),
    "wide with lapse": FrameDistribution((FramePart(-2.0, 1.5, 0.8),), lapse=0.2),
    "point and lapse": FrameDistribution((FramePart(3.0, math.inf, 0.5),), lapse=0.5),
    "lapse": FrameDistribution((), lapse=1.0),
}


class Bare:
    """A likelihood with nothing but what one must have."""

    def log_g(self, term, direction_rad):
        return GaussianLikelihood().log_g(term, direction_rad)


def term_of(word):
    return ground_relations((relation(word, "House"),), CITY)[0]


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("word", ["front", "left"])
def test_quadrature_is_the_closed_form(frame, word):
    term = term_of(word)
    got = frame_marginal(Bare(), term, FRAMES[frame]).exp()
    expected = frame_marginal(GaussianLikelihood(), term, FRAMES[frame]).exp()
    assert 0.5 * (got / got.sum() - expected / expected.sum()).abs().sum() < 1e-5
    torch.testing.assert_close(got, expected, atol=3e-6, rtol=1e-4)


def test_a_point_is_exact():
    term = term_of("behind")
    at = torch.tensor([0.7 + math.pi], dtype=torch.float64)
    torch.testing.assert_close(
        frame_marginal(Bare(), term, FRAMES["point"]), Bare().log_g(term, at)[0], atol=0, rtol=1e-12
    )


def test_no_call_holds_more_than_half_a_million_numbers():
    sizes = []

    def log_g(angles):
        sizes.append(len(angles) * 100_000)
        return torch.zeros(len(angles), 100_000, dtype=torch.float64)

    total = marginal_over(FRAMES["wide with lapse"], 0.0, log_g)
    assert max(sizes) <= 1 << 19
    assert sum(sizes) == 1440 * 100_000
    torch.testing.assert_close(total, torch.zeros(100_000, dtype=torch.float64))


def test_gradients_reach_the_likelihood_and_the_frame():
    kappa = torch.tensor(2.0, dtype=torch.float64, requires_grad=True)
    width = torch.tensor(1.5, dtype=torch.float64, requires_grad=True)
    frame = FrameDistribution((FramePart(0.0, kappa, 0.9),), lapse=0.1)
    cells = torch.linspace(-3, 3, 7, dtype=torch.float64)

    def marginal():
        return marginal_over(frame, 0.0, lambda a: width * (torch.cos(cells - a[:, None]) - 1))

    marginal()[3].backward()
    # A frame better known helps the cell that lies straight ahead; a narrower relation does not.
    assert kappa.grad > 0
    assert width.grad < 0


CELLS = torch.linspace(-3, 3, 50, dtype=torch.float64)
SHAPES = {
    "smooth": (lambda a: torch.log(0.4995 * (1 + torch.cos(CELLS - a)) + 0.001), 128),
    "kink": (lambda a: torch.log(torch.cos(CELLS - a).clamp_min(0) + 0.01), 2048),
    "jump": (lambda a: torch.where(torch.cos(CELLS - a) > 0.7, -0.01, -5.0).double(), 3200),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("frame", ["narrow", "wide with lapse", "point and lapse"])
def test_few_directions_do_while_learning(shape, frame):
    asked = []

    def log_g(angles):
        asked.append(len(angles))
        return SHAPES[shape][0](angles[:, None])

    whole = marginal_over(FRAMES[frame], 0.3, log_g)
    asked.clear()
    with summed_within(1e-3):
        few = marginal_over(FRAMES[frame], 0.3, log_g)
    assert sum(asked) <= SHAPES[shape][1]
    assert float((few - whole).abs().max()) <= {"smooth": 1e-9, "kink": 1e-3, "jump": 0}[shape]
    again = marginal_over(FRAMES[frame], 0.3, log_g)
    torch.testing.assert_close(again, whole, rtol=0, atol=0)


def test_the_inner_tolerance_holds_and_the_outer_comes_back():
    counts = []

    def count():
        asked = []
        marginal_over(
            FRAMES["wide with lapse"],
            0.0,
            lambda a: asked.append(len(a)) or torch.cos(CELLS - a[:, None]).clamp_min(0.01).log(),
        )
        counts.append(sum(asked))

    with summed_within(1e-2):
        count()
        with summed_within(1e-4):
            count()
        count()
    count()
    assert counts[0] == counts[2] < counts[1] < counts[3] == 1440


def test_no_number_is_asked_of_all_directions():
    with summed_within(1e-3):
        found = marginal_over(FRAMES["lapse"], 0.0, lambda a: CELLS * math.nan * a[:, None])
    assert found.isnan().all()


def test_the_gradient_of_many_directions_is_that_of_few_at_a_time(monkeypatch):
    from sloop_ppl.models.likelihoods import _marginal

    def slope():
        width = torch.tensor(1.5, dtype=torch.float64, requires_grad=True)
        kappa = torch.tensor(2.0, dtype=torch.float64, requires_grad=True)
        frame = FrameDistribution((FramePart(0.0, kappa, 0.9),), lapse=0.1)
        found = marginal_over(frame, 0.0, lambda a: width * (torch.cos(CELLS - a[:, None]) - 1))
        return torch.stack(torch.autograd.grad(found.sum(), (width, kappa)))

    whole = slope()
    monkeypatch.setattr(_marginal, "_ELEMENTS", 50 * 100)
    torch.testing.assert_close(slope(), whole, rtol=1e-12, atol=0)
