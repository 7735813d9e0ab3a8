"""Score predicted distributions of fronts against the directions buildings face."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.models.frames import FrameDistribution, FramePart

__all__ = ["ANGLE_BINS", "FrameScore", "FrameScores", "fit_points", "score_frame", "spread_points"]

ANGLE_BINS = 24
"""Arcs a prediction is scored in, the first centred on east."""

_KAPPAS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 300.0, 1000.0)
_LAPSES = (0.01, 0.02, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)


@dataclass(frozen=True)
class FrameScore:
    """How good one prediction is.

    Parameters
    ----------
    deviation_deg
        Between the likeliest direction and the label, 0 to 180; the mean over equally likely ones,
        90 when none is.
    log_score
        Natural log of the probability of the label's arc of 15 degrees.
    in50, in90
        Probability that the label lies in the smallest set of directions that holds so much; an arc
        that the set ends in counts by the share of it that is taken.
    """

    deviation_deg: float
    log_score: float
    in50: float
    in90: float


@dataclass(frozen=True)
class FrameScores:
    """How good the predictions for several buildings are, on average."""

    n: int
    mean_deviation_deg: float
    median_deviation_deg: float
    mean_log_score: float
    arc50: float
    arc90: float
    within45: float

    @classmethod
    def of(cls, scores: Sequence[FrameScore]) -> FrameScores | None:
        """Return the averages of some scores; None when there is none."""
        if not scores:
            return None
        deviation = np.array([score.deviation_deg for score in scores])
        return cls(
            n=len(scores),
            mean_deviation_deg=float(deviation.mean()),
            median_deviation_deg=float(np.median(deviation)),
            mean_log_score=float(np.mean([score.log_score for score in scores])),
            arc50=float(np.mean([score.in50 for score in scores])),
            arc90=float(np.mean([score.in90 for score in scores])),
            within45=float((deviation < 45).mean()),
        )


def score_frame(predicted: FrameDistribution, frame_angle_rad: float) -> FrameScore:
    """Return how good a prediction is, given the direction a building faces.

    Notes
    -----
    Probabilities are those of 24 arcs, since labels are exact directions to a street, against
    which a density could grow without bound. The level of the label is randomised within its arc
    (Czado, Gneiting and Held 2009), so that a prediction that is right about everything has half
    of the labels in its 50 % arcs, however few arcs these are.
    """
    mass = predicted.binned(ANGLE_BINS)
    here = math.floor(frame_angle_rad / (2 * math.pi) * ANGLE_BINS + 0.5) % ANGLE_BINS
    own = mass[here]
    alike = np.isclose(mass, own, rtol=1e-9, atol=1e-15)
    above, level = float(mass[(mass > own) & ~alike].sum()), float(mass[alike].sum())
    modes = predicted.modes()
    turned = [abs(math.degrees(math.remainder(m - frame_angle_rad, 2 * math.pi))) for m in modes]
    return FrameScore(
        deviation_deg=float(np.mean(turned)) if turned else 90.0,
        log_score=math.log(max(float(own), 1e-300)),
        in50=_taken(0.5, above, level),
        in90=_taken(0.9, above, level),
    )


def _taken(wanted: float, above: float, level: float) -> float:
    return min(max((wanted - above) / max(level, 1e-300), 0.0), 1.0)


def fit_points(
    predicted: Sequence[FrameDistribution], frame_angles_rad: Sequence[float]
) -> tuple[float, float]:
    """Return the concentration and the lapse that make points score best.

    Parameters
    ----------
    predicted
        Points, or uniform where nothing is known.
    frame_angles_rad
        The directions the buildings face, radians.

    Returns
    -------
    tuple of float
        Of a grid, those with the greatest mean log score; see `spread_points`.
    """
    known = [
        (p.modes()[0], f) for p, f in zip(predicted, frame_angles_rad, strict=True) if p.modes()
    ]
    if not known:
        return 1.0, 1.0
    mean, angle = np.array(known).T
    best, found = -math.inf, (1.0, 1.0)
    for kappa in _KAPPAS:
        inside = _label_arcs(mean, angle, kappa)
        for lapse in _LAPSES:
            score = float(np.log((1 - lapse) * inside + lapse / ANGLE_BINS).mean())
            if score > best:
                best, found = score, (kappa, lapse)
    return found


def spread_points(predicted: FrameDistribution, kappa: float, lapse: float) -> FrameDistribution:
    """Return a distribution with a concentration at its modes and a lapse; uniform without any."""
    modes = predicted.modes()
    parts = tuple(FramePart(mode, kappa, (1 - lapse) / len(modes)) for mode in modes)
    return FrameDistribution(parts, lapse=lapse if modes else 1.0)


def _label_arcs(
    mean: NDArray[np.float64], angle: NDArray[np.float64], kappa: float
) -> NDArray[np.float64]:
    """Return the probability of each label's arc under a von Mises around each prediction."""
    steps = np.arange(1440) * (2 * math.pi / 1440)
    arc = np.floor(angle / (2 * math.pi) * ANGLE_BINS + 0.5) % ANGLE_BINS
    at = np.floor(steps / (2 * math.pi) * ANGLE_BINS + 0.5) % ANGLE_BINS
    density = np.exp(kappa * (np.cos(steps - mean[:, None]) - 1))
    inside = density * (at[None, :] == arc[:, None])
    share: NDArray[np.float64] = inside.sum(1) / density.sum(1)
    return share
