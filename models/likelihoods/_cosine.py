"""The expected cosine factor under an uncertain frame, in closed form."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import torch
from torch import Tensor

from sloop_ppl.models.frames import FrameDistribution

__all__ = ["bessel_ratios", "expected_cosine"]

# A_2m is about exp(-2 m^2 / kappa), e^-24.5 = 2e-11 at m = 3.5 sqrt(kappa): that many terms are
# taken, at least 24 (kappa 47) and at most 1000 (kappa 8e4), and none below 1e-10.
_TERMS, _MOST_TERMS = 24, 1000
_LEAST_COEFFICIENT = 1e-10


def bessel_ratios(kappa: float | Tensor, count: int) -> tuple[float | Tensor, ...]:
    """Return A_n = I_n(kappa) / I_0(kappa) for n = 0..count, by backward recurrence.

    Parameters
    ----------
    kappa
        Concentration, >= 0, finite; gradients flow through a tensor.
    count
        Highest order, >= 0.

    Examples
    --------
    >>> [round(a, 4) for a in bessel_ratios(2.0, 2)]
    [1.0, 0.6978, 0.3022]
    """
    return _recurrence(kappa, count) if isinstance(kappa, Tensor) else _cached(kappa, count)


def _recurrence(kappa: float | Tensor, count: int) -> tuple[float | Tensor, ...]:
    size = float(torch.as_tensor(kappa).detach())
    if size == 0:
        return (1.0,) + (0.0,) * count
    # r_n = I_n / I_(n-1) = 1 / (2 n / kappa + r_(n+1)); starting high enough, r = 0 is exact.
    ratio: float | Tensor = 0.0
    ratios: list[float | Tensor] = []
    for n in range(count + 40 + int(2 * size), 0, -1):
        ratio = 1 / (2 * n / kappa + ratio)
        if n <= count:
            ratios.append(ratio)
    values: list[float | Tensor] = [1.0]
    for ratio in reversed(ratios):
        values.append(values[-1] * ratio)
    return tuple(values)


@lru_cache(maxsize=256)
def _cached(kappa: float, count: int) -> tuple[float | Tensor, ...]:
    return _recurrence(kappa, count)


def expected_cosine(
    bearing_rad: Tensor, frame: FrameDistribution, offset_rad: float, *, clipped: bool, floor: float
) -> Tensor:
    r"""Return E[max(floor, cos x)] (or E|cos x|), x the angle between bearing and relation.

    Parameters
    ----------
    bearing_rad
        Direction of each cell from the ground, radians, shape (S,).
    frame
        Distribution of the direction the ground faces.
    offset_rad
        Direction of the relation less that of the front, radians.
    clipped
        True for max(0, cos), the published code; False for \|cos\|, the paper's text.
    floor
        Least value, > 0, so that logs stay finite.

    Returns
    -------
    Tensor
        In [floor, 1], shape (S,).

    Notes
    -----
    Fourier series of the factor with each harmonic shrunk by A_n = I_n(kappa) / I_0(kappa):
    E[max(0, cos)] = 1/pi + A_1 cos(x)/2 + (2/pi) sum_m (-1)^(m+1) A_2m cos(2 m x)/(4 m^2 - 1),
    and E|cos| is twice its even part; enough terms are taken for an error of 1e-8 up to kappa
    8e4, and summed by Clenshaw's recurrence. The floor is applied to points exactly, to spread
    parts after the expectation.
    """
    total = torch.zeros_like(bearing_rad) + frame.lapse * (1 if clipped else 2) / math.pi
    for part in frame.parts:
        cosine = torch.cos(bearing_rad - (part.mean_rad + offset_rad))
        if math.isinf(float(torch.as_tensor(part.kappa).detach())):
            value = cosine.clamp_min(floor) if clipped else cosine.abs()
        else:
            odd, even = _coefficients(part.kappa)
            value = _series(even, 4 * cosine * cosine - 2)
            value = torch.add(value, odd * cosine) if clipped else 2 * value
        total = total + part.weight * value
    return total.clamp(floor, 1.0)


def _coefficients(kappa: float | Tensor) -> tuple[Any, list[Any]]:
    """Return the coefficient of cos x and those of cos 2 m x, m = 0, 1, ..., of E[max(0, cos)]."""
    size = float(torch.as_tensor(kappa).detach())
    count = min(max(_TERMS, int(3.5 * math.sqrt(size))), _MOST_TERMS)
    a = bessel_ratios(kappa, 2 * count)
    even: list[Any] = [1 / math.pi]
    for m in range(1, count + 1):
        even.append((2 / math.pi) * (-1) ** (m + 1) * a[2 * m] / (4 * m * m - 1))
        if abs(even[-1]) < _LEAST_COEFFICIENT:
            break
    return a[1] / 2, even


def _series(coefficients: list[Any], twice_cosine: Tensor) -> Tensor:
    """Return the sum of c_m cos(m y), given 2 cos y, by Clenshaw's recurrence: no more cosines."""
    last, before = torch.zeros_like(twice_cosine), torch.zeros_like(twice_cosine)
    for c in reversed(coefficients[1:]):
        last, before = torch.addcmul(c - before, twice_cosine, last), last
    return torch.addcmul(coefficients[0] - before, twice_cosine, last, value=0.5)
