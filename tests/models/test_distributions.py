from __future__ import annotations

import math

import numpy as np
import pytest
import torch

from sloop_ppl.errors import InputError
from sloop_ppl.models import FrameDistribution, FramePart
from sloop_ppl.models._distributions import FrameDensity, LogBernoulli, categorical


def test_a_tiny_probability_is_not_clamped():
    """Pyro's Bernoulli would answer -15.94."""
    log_p = torch.tensor([-100.0, -1e-20], dtype=torch.float64)
    holds = LogBernoulli(log_p)
    torch.testing.assert_close(holds.log_prob(torch.ones(2)), log_p)
    denied = holds.log_prob(torch.zeros(2))
    assert denied[0] == pytest.approx(0.0, abs=1e-40)
    assert denied[1] == pytest.approx(math.log(1e-20), rel=1e-9)


def test_draws_are_true_as_often_as_said():
    torch.manual_seed(0)
    drawn = LogBernoulli(torch.full((20_000,), math.log(0.3))).sample()
    # Standard error .0032: a fair sampler fails this once in 10^5.
    assert abs(drawn.mean() - 0.3) < 0.0145


def test_one_value_has_an_impossible_twin():
    """Pyro's enumeration drops axes of length one (pyro #3102)."""
    one = categorical(torch.zeros(1, dtype=torch.float64))
    assert torch.equal(one.enumerate_support(), torch.tensor([0, 1]))
    assert one.log_prob(one.enumerate_support()).tolist() == [0.0, -math.inf]
    assert categorical(torch.zeros(3)).enumerate_support().tolist() == [0, 1, 2]


def test_the_density_of_a_frame_is_that_of_its_distribution():
    frame = FrameDistribution((FramePart(0.4, 3.0, 0.5), FramePart(-2.0, 40.0, 0.3)), lapse=0.2)
    angles = np.linspace(-math.pi, math.pi, 720, endpoint=False)
    density = FrameDensity(frame)
    log_p = density.log_prob(torch.from_numpy(angles)).numpy()
    np.testing.assert_allclose(np.exp(log_p), frame.density(angles), rtol=1e-12)
    assert np.exp(log_p).sum() * 2 * math.pi / 720 == pytest.approx(1)
    around = density.log_prob(torch.from_numpy(angles + 2 * math.pi))
    np.testing.assert_allclose(around, log_p, atol=1e-12)


def test_angles_are_drawn_from_the_density():
    torch.manual_seed(0)
    turned = FramePart(0.4, 3.0, 0.5)
    frame = FrameDistribution((turned, FramePart(-2.0, math.inf, 0.3)), lapse=0.2)
    drawn = FrameDensity(frame).sample((20_000,))
    # Standard errors below .0036: a fair sampler fails one of these once in 10^5.
    assert abs((drawn == -2.0).double().mean() - 0.3) < 0.017
    angles = np.linspace(-math.pi, math.pi, 720, endpoint=False)
    east = np.abs(angles) < math.pi / 2
    share = 0.5 * np.exp(turned.log_density(angles))[east].sum() * 2 * math.pi / 720 + 0.2 / 2
    assert abs((drawn.cos() > 0).double().mean() - share) < 0.017
    with pytest.raises(InputError, match="A frame is a point, which has no density"):
        FrameDensity(frame).log_prob(drawn)
