"""A distribution over which way a ground faces: von Mises parts, points, and a uniform lapse."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ive

from sloop_ppl.errors import InputError

__all__ = ["FrameDistribution", "FramePart"]


@dataclass(frozen=True)
class FramePart:
    """One von Mises part of a frame distribution.

    Parameters
    ----------
    mean_rad : direction the ground faces, radians anticlockwise from east.
    kappa : concentration, >= 0; ``math.inf`` for a point.
    weight : probability of the part, in (0, 1].
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
    parts : von Mises parts; their weights and `lapse` sum to one.
    lapse : probability that the front is anywhere, uniformly.

    Raises
    ------
    InputError : when the weights do not sum to one.

    Notes
    -----
    Source: design of this package, (1 - lapse) VonMises + lapse Uniform. The paper uses one
    predicted angle (SLOOP sec. III-D): one part that is a point.
    """

    parts: tuple[FramePart, ...]
    lapse: float = 0.0

    def __post_init__(self) -> None:
        total = sum(part.weight for part in self.parts) + self.lapse
        if not math.isclose(total, 1.0, abs_tol=1e-9):
            raise InputError(f"Weights of a frame distribution sum to {total:g}; expected 1")

    def bins(self, count: int = 360) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return angles and the probability of each, as a sum that stands for the distribution.

        Parameters
        ----------
        count : angles that stand for what is spread, > 0; points keep their own.

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

    @property
    def is_point(self) -> bool:
        """Tell whether all of its mass sits on points."""
        return self.lapse == 0 and all(math.isinf(part.kappa) for part in self.parts)
