"""A distribution over which way a ground faces: von Mises parts, points, and a uniform lapse."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ive

from sloop_ppl.errors import InputError

__all__ = ["ABSOLUTE_ANGLE_RAD", "FrameDistribution", "FramePart"]

ABSOLUTE_ANGLE_RAD = math.pi / 2
"""The front that makes left and right those of the map: facing north, right is east."""


@dataclass(frozen=True)
class FramePart:
    """One von Mises part of a frame distribution.

    Parameters
    ----------
    mean_rad
        Direction the ground faces, radians anticlockwise from east.
    kappa
        Concentration, >= 0; ``math.inf`` for a point.
    weight
        Probability of the part, in (0, 1].
    """

    mean_rad: float
    kappa: float
    weight: float = 1.0

    def log_density(self, angle_rad: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the log density per radian; a point has none and raises ValueError."""
        if math.isinf(self.kappa):
            raise ValueError("A point has no density; give the part a finite kappa")
        # ive is I0 scaled by exp(-kappa), so large kappa does not overflow.
        density: NDArray[np.float64] = (
            self.kappa * (np.cos(angle_rad - self.mean_rad) - 1)
            - math.log(2 * math.pi)
            - np.log(ive(0, self.kappa))
        )
        return density


@dataclass(frozen=True)
class FrameDistribution:
    """Which way a ground faces, with its uncertainty.

    Parameters
    ----------
    parts
        Von Mises parts; their weights and `lapse` sum to one.
    lapse
        Probability that the front is anywhere, uniformly.

    Raises
    ------
    InputError
        When the weights do not sum to one.

    Notes
    -----
    Source: design of this package, (1 - lapse) VonMises + lapse Uniform. The paper uses one
    predicted angle (SLOOP sec. III-D): one part that is a point.

    Examples
    --------
    >>> import math
    >>> front = FrameDistribution((FramePart(math.pi / 2, kappa=5.0, weight=0.9),), lapse=0.1)
    >>> [round(p, 2) for p in front.binned(4).tolist()]  # east, north, west, south
    [0.07, 0.84, 0.07, 0.03]
    """

    parts: tuple[FramePart, ...]
    lapse: float = 0.0

    def __post_init__(self) -> None:
        total = float(sum(_number(part.weight) for part in self.parts) + _number(self.lapse))
        if not math.isclose(total, 1.0, abs_tol=1e-9):
            raise InputError(f"Weights of a frame distribution sum to {total:g}; expected 1")

    @classmethod
    def points(cls, angles_rad: Sequence[float]) -> FrameDistribution:
        """Return equally likely points; the uniform distribution when there are none."""
        if not angles_rad:
            return cls((), lapse=1.0)
        share = 1 / len(angles_rad)
        return cls(tuple(FramePart(angle, math.inf, share) for angle in angles_rad))

    def bins(self, count: int = 360) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return angles and the probability of each, as a sum that stands for the distribution.

        Parameters
        ----------
        count
            Angles that stand for what is spread, > 0; points keep their own.

        Returns
        -------
        tuple of numpy.ndarray
            Angles in radians and probabilities that sum to one, shape (B,) each.
        """
        spread = np.linspace(-math.pi, math.pi, count, endpoint=False)
        mass = np.full(count, self.lapse / count)
        points = [part for part in self.parts if math.isinf(part.kappa)]
        for part in self.parts:
            if not math.isinf(part.kappa):
                density = np.exp(part.log_density(spread))
                mass += part.weight * density / density.sum()
        if len(points) == len(self.parts) and not self.lapse:
            spread, mass = spread[:0], mass[:0]
        angles = np.concatenate([[part.mean_rad for part in points], spread])
        return angles, np.concatenate([[part.weight for part in points], mass])

    def density(self, angle_rad: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the density per radian at some angles, same shape; a point raises ValueError."""
        total = np.full(np.shape(angle_rad), self.lapse / (2 * math.pi))
        for part in self.parts:
            total += part.weight * np.exp(part.log_density(angle_rad))
        return total

    def binned(self, count: int) -> NDArray[np.float64]:
        """Return the probability of each of B equal arcs, the first centred on east, shape (B,).

        Notes
        -----
        Exact for points and lapse; a von Mises part is summed on arcs a thousandth of a turn
        wide or narrower, which does up to a concentration of some thousands.
        """
        fine = count * max(1, -(-1440 // count))
        angles, mass = self.bins(fine)
        which = np.floor(np.asarray(angles) / (2 * math.pi) * count + 0.5 + 1e-9).astype(int)
        arcs = np.zeros(count)
        np.add.at(arcs, which % count, mass)
        return arcs

    def modes(self) -> tuple[float, ...]:
        """Return the likeliest directions, radians in (-pi, pi]; equal ones are all named.

        Points come before all that is spread. A uniform distribution has none.
        """
        points = [part for part in self.parts if math.isinf(part.kappa)]
        if points:
            most = max(part.weight for part in points)
            return tuple(p.mean_rad for p in points if math.isclose(p.weight, most))
        if not any(part.kappa > 0 and part.weight > 0 for part in self.parts):
            return ()
        peaks = [_climbed(self, start, 2 * math.pi / 720) for start in _tops(self)]
        most = max(height for _, height in peaks)
        found: list[float] = []
        for peak, height in sorted(peaks, key=lambda peak: -peak[1]):
            near = [p.mean_rad for p in self.parts if abs(_between(p.mean_rad, peak)) < 1e-6]
            angle = near[0] if near else peak
            apart = all(abs(_between(angle, f)) > 0.01 for f in found)
            if math.isclose(height, most, rel_tol=1e-6) and apart:
                found.append(angle)
        return tuple(found)

    @property
    def is_point(self) -> bool:
        """Tell whether all of its mass sits on points."""
        return self.lapse == 0 and all(math.isinf(part.kappa) for part in self.parts)


def _between(one: float, other: float) -> float:
    return math.remainder(one - other, 2 * math.pi)


def _number(share: Any) -> Any:
    """Return a share that may be a tensor, while it is learnt, without its gradient."""
    return share.detach() if hasattr(share, "detach") else share


def _tops(frame: FrameDistribution) -> list[float]:
    """Return angles next to which the density may be the greatest.

    Steps of half a degree miss a peak of kappa 500 by kappa (.25 degrees)^2 / 2 = .5 %, so starts
    within 2 % of the best are climbed; means of parts are met however narrow these are.
    """
    angles = np.linspace(-math.pi, math.pi, 720, endpoint=False)
    height = frame.density(angles)
    peaks = angles[(height >= np.roll(height, 1)) & (height > np.roll(height, -1))]
    starts = np.array([*peaks, *(part.mean_rad for part in frame.parts)])
    height = frame.density(starts)
    return [float(start) for start in starts[height >= 0.98 * height.max()]]


def _climbed(frame: FrameDistribution, start: float, reach: float) -> tuple[float, float]:
    """Return the angle of greatest density within reach of a start, and that density.

    Six rounds, each a tenth as wide as the one before: 1e-8 radians from a reach of half a degree.
    """
    low, high = start - reach, start + reach
    for _ in range(6):
        angles = np.linspace(low, high, 21)
        height = frame.density(angles)
        top = int(height.argmax())
        step = (high - low) / 20
        low, high = angles[top] - step, angles[top] + step
    angle = math.remainder(float(angles[top]), 2 * math.pi)
    return angle, float(height[top])
