from __future__ import annotations

import math

import pytest
import torch

from sloop_ppl.models import TruthValue
from sloop_ppl.models.logspace import log1mexp


def test_a_tiny_probability_is_not_clamped():
    """Pyro's Bernoulli would answer -15.94."""
    log_g = torch.tensor([-100.0, -1e-20], dtype=torch.float64)
    truth = TruthValue(log_g)
    torch.testing.assert_close(truth.log_prob(torch.ones(2)), log_g)
    denied = truth.log_prob(torch.zeros(2))
    assert denied[0] == pytest.approx(0.0, abs=1e-40)
    assert denied[1] == pytest.approx(math.log(1e-20), rel=1e-9)


def test_log1mexp_is_accurate_at_both_ends():
    for log_p in (-1e-15, -1e-3, -0.5, -1.0, -30.0):
        expected = math.log(-math.expm1(log_p))
        got = float(log1mexp(torch.tensor(log_p, dtype=torch.float64)))
        assert got == pytest.approx(expected, rel=1e-12)


def test_log1mexp_has_a_finite_gradient():
    log_p = torch.tensor([-1e-9, -0.3, -50.0], dtype=torch.float64, requires_grad=True)
    log1mexp(log_p).sum().backward()
    assert torch.isfinite(log_p.grad).all()


def test_draws_are_true_as_often_as_said():
    torch.manual_seed(0)
    drawn = TruthValue(torch.full((20_000,), math.log(0.3))).sample()
    # Standard error .0032: a fair sampler fails this once in 10^5.
    assert abs(drawn.mean() - 0.3) < 0.0145
