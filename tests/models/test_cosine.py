from __future__ import annotations

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import iv

from sloop_ppl.models import FrameDistribution, FramePart
from sloop_ppl.models.likelihoods import bessel_ratios, expected_cosine

ANGLES = torch.linspace(-math.pi, math.pi, 73, dtype=torch.float64)


@given(st.floats(0.01, 60))
def test_bessel_ratios_are_those_of_scipy(kappa):
    expected = [iv(n, kappa) / iv(0, kappa) for n in range(12)]
    np.testing.assert_allclose(bessel_ratios(kappa, 11), expected, rtol=1e-10, atol=1e-300)


def test_a_flat_frame_has_no_direction():
    assert bessel_ratios(0.0, 3) == (1.0, 0.0, 0.0, 0.0)
    flat = FrameDistribution((FramePart(0.3, 0.0),))
    got = expected_cosine(ANGLES, flat, 0.0, clipped=True, floor=1e-9)
    np.testing.assert_allclose(got, 1 / math.pi)


@pytest.mark.parametrize("kappa", [0.3, 2.0, 8.0, 50.0])
@pytest.mark.parametrize("clipped", [True, False])
def test_the_series_is_the_integral(kappa, clipped):
    frame = FrameDistribution((FramePart(0.4, kappa),))
    got = expected_cosine(ANGLES, frame, 0.0, clipped=clipped, floor=1e-9)
    psi = np.linspace(-math.pi, math.pi, 200_001)[:-1]
    density = np.exp(frame.parts[0].log_density(psi))
    density /= density.sum()
    for angle, value in zip(ANGLES.tolist()[::9], got.tolist()[::9], strict=True):
        cosine = np.cos(angle - psi)
        integrand = np.maximum(0, cosine) if clipped else np.abs(cosine)
        assert value == pytest.approx(float(density @ integrand), abs=2e-7)


def test_a_sharp_frame_is_nearly_a_point():
    point = FrameDistribution((FramePart(0.4, math.inf),))
    sharp = FrameDistribution((FramePart(0.4, 400.0),))
    a = expected_cosine(ANGLES, point, 0.0, clipped=True, floor=1e-9)
    b = expected_cosine(ANGLES, sharp, 0.0, clipped=True, floor=1e-9)
    assert (a - b).abs().max() < 0.03


def test_the_floor_holds():
    point = FrameDistribution((FramePart(0.0, math.inf),))
    got = expected_cosine(ANGLES, point, 0.0, clipped=True, floor=1e-9)
    assert got.min() == 1e-9
    assert got.max() == 1


@pytest.mark.parametrize("kappa", [0.5, 4.0, 60.0])
def test_the_series_is_differentiable_in_kappa(kappa):
    def summed(value):
        frame = FrameDistribution((FramePart(0.4, value, 0.9),), lapse=0.1)
        return expected_cosine(ANGLES[::7], frame, 1.0, clipped=True, floor=1e-9).log().sum()

    learnt = torch.tensor(kappa, dtype=torch.float64, requires_grad=True)
    summed(learnt).backward()
    step = 1e-4 * kappa
    slope = (summed(kappa + step) - summed(kappa - step)) / (2 * step)
    assert learnt.grad.item() == pytest.approx(slope.item(), rel=1e-5)


def test_ratios_of_a_number_that_is_learnt_follow_it():
    """An optimiser changes the tensor in place, and each step is differentiated anew."""
    kappa = torch.tensor(2.0, dtype=torch.float64, requires_grad=True)
    before = bessel_ratios(kappa, 2)[1]
    before.backward()
    bessel_ratios(kappa, 2)[1].backward()
    with torch.no_grad():
        kappa += 1
    assert float(bessel_ratios(kappa, 2)[1].detach()) == pytest.approx(bessel_ratios(3.0, 2)[1])
    assert float(before.detach()) == pytest.approx(bessel_ratios(2.0, 2)[1])
