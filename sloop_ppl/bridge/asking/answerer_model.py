"""What is believed of the person who answers: how often they err, and how often they do not know.

Shape legend: A options; V values of the latent that a question is about.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, softmax

from sloop_ppl.errors import InputError

__all__ = ["AnswererModel"]

Table = NDArray[np.float64]


@lru_cache(maxsize=16)
def _quarters_around(angle_deg: float) -> tuple[Table, float]:
    """Return the probabilities of the quarters at even steps around, shape (N, 4), and the step.

    Between them they are linear: 64 steps a standard deviation are good to five digits.
    """
    sigma = math.radians(angle_deg)
    count = max(1024, math.ceil(2 * math.pi / (sigma / 64)))
    bearing = np.arange(count + 2) * (2 * math.pi / count)  # one more for an angle of just 2 pi
    centres = np.radians([90.0, 0.0, -90.0, 180.0])
    off = np.abs((bearing - centres[:, None] + np.pi) % (2 * np.pi) - np.pi)
    seen = ndtr((np.pi / 4 - off) / sigma)
    return np.ascontiguousarray((seen / seen.sum(0)).T), 2 * math.pi / count


@dataclass(frozen=True)
class AnswererModel:
    """How a person answers.

    Parameters
    ----------
    error
        Probability of an answer other than the true one, each of the others as likely, in [0, 1).
    guess
        Share of the answers that are guessed, each option as likely, in [0, 1]; with 1 no answer
        tells anything.
    dont_know
        Probability of "I don't know" about the best known landmarks, in [0, 1); about others it is
        up to five times as high, see `dont_know_of`. It does not depend on where the target is, so
        the answer tells nothing.
    angle_deg
        Standard deviation of the direction that a person sees, degrees, in [0, 90]; 0 for one who
        takes every boundary between two sides exactly.
    distance_share
        Standard deviation of the logarithm of the distance that a person sees, in [0, 2]: about the
        share by which it is wrong.
    other_geometry
        Share of people who measure the other way: directions from a place's nearest edge instead of
        its middle, distances to its middle instead of its nearest edge, in [0, 1].

    Raises
    ------
    InputError
        When a share is out of its range.
    """

    error: float = 0.1
    guess: float = 0.0
    dont_know: float = 0.05
    angle_deg: float = 10.0
    distance_share: float = 0.3
    other_geometry: float = 0.5

    def __post_init__(self) -> None:
        for name, most in (
            ("guess", 1),
            ("angle_deg", 90),
            ("distance_share", 2),
            ("other_geometry", 1),
        ):
            if not 0 <= getattr(self, name) <= most:
                raise InputError(
                    f"{name} of the answerer is {getattr(self, name)}; expected a number from 0 "
                    f"to {most}"
                )
        for name in ("error", "dont_know"):
            if not 0 <= getattr(self, name) < 1:
                raise InputError(
                    f"{name} of the answerer is {getattr(self, name)}; expected a share in [0, 1)"
                )

    @classmethod
    def exact(cls, error: float = 0.1, guess: float = 0.0) -> AnswererModel:
        """Return a person who always knows and sees directions and distances exactly."""
        return cls(
            error=error, guess=guess, dont_know=0.0, angle_deg=0.0, distance_share=0.0,
            other_geometry=0.0,
        )  # fmt: skip

    def farther(self, log_m: Table, than: Table | float) -> Table:
        """Return the probability that a distance is seen as greater than another.

        Parameters
        ----------
        log_m, than
            Logarithms of metres, shape (S,) or one number.
        """
        if self.distance_share == 0.0:
            return np.asarray(log_m > than, dtype=np.float64)
        found: Table = ndtr((log_m - than) / self.distance_share)
        return found

    def nearest(self, log_m: Table) -> Table:
        """Return the probability that each of G places is seen as the nearest.

        Parameters
        ----------
        log_m
            Logarithms of metres, shape (G, S).

        Returns
        -------
        numpy.ndarray
            Shape (G, S), columns sum to one.

        Notes
        -----
        A multinomial logit: the logarithm of each distance is seen with a Gumbel error of standard
        deviation `distance_share`.
        """
        if self.distance_share == 0.0:
            first = np.argmin(log_m, axis=0)
            return np.asarray(first[None, :] == np.arange(len(log_m))[:, None], dtype=np.float64)
        found: Table = softmax(-log_m * (math.pi / math.sqrt(6) / self.distance_share), axis=0)
        return found

    def quarters(self, bearing_rad: Table) -> Table:
        """Return the probability that a direction is seen as north, east, south or west.

        Parameters
        ----------
        bearing_rad
            Radians anticlockwise from east, shape (S,).

        Returns
        -------
        numpy.ndarray
            Shape (4, S), columns sum to one.
        """
        if self.angle_deg == 0.0:
            quarter = np.rint(bearing_rad / (np.pi / 2)).astype(np.intp) % 4
            return np.asarray(quarter[None, :] == np.array([1, 0, 3, 2])[:, None], dtype=float)
        nodes, step = _quarters_around(self.angle_deg)
        at = (bearing_rad % (2 * np.pi)) / step
        below = at.astype(np.intp)
        found: Table = nodes.take(below, axis=0)
        found += (at - below)[:, None] * (nodes.take(below + 1, axis=0) - found)
        return found.T

    def dont_know_of(self, salience: float) -> float:
        """Return the probability of "I don't know" about landmarks of a salience in [0, 1]."""
        return min(self.dont_know * (5.0 - 4.0 * salience), 0.9)

    def options(self, truth: NDArray[Any]) -> NDArray[Any]:
        """Return the probability of each option of one who knows, errors included, shape (A, V)."""
        others = self.error / (len(truth) - 1)
        meant = truth * (1.0 - self.error - others) + others
        return (1.0 - self.guess) * meant + self.guess / len(truth)

    @property
    def reliability(self) -> float:
        """Probability that an answer is the true one on purpose."""
        return (1.0 - self.error) * (1.0 - self.guess)

    def likelihood(self, truth: Table, dont_know: float) -> Table:
        """Return the probability of each answer, and of "I don't know" in the last row.

        Parameters
        ----------
        truth
            Probability of each option of one who does not err, shape (A, V), A of at least 2.
        dont_know
            Probability of "I don't know".

        Returns
        -------
        numpy.ndarray
            Shape (A + 1, V), columns sum to one.
        """
        options = self.options(truth)
        silent = np.full((1, truth.shape[1]), dont_know)
        table: Table = np.concatenate([(1.0 - dont_know) * options, silent])
        return table
