"""Draw frames from their priors, spread evenly over the prior's mass."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.models import FrameDistribution, ProgramData

__all__ = ["draw_frame", "framed_sites"]


def framed_sites(data: ProgramData) -> dict[str, FrameDistribution]:
    """Return the continuous sites of the program with ``frames="density"``, and their priors."""
    found = {}
    for target, j, phrase in data.framed_phrases():
        own = phrase.own_frames(f"{target}/frame_{j}")
        if any(not one.is_point for one in own.values()):  # the program refuses points beside it
            found |= own
    return found


def draw_frame(prior: FrameDistribution, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Draw n angles, spread evenly over the prior's mass: each by itself is a draw from it."""
    weights = np.array([*(part.weight for part in prior.parts), prior.lapse])
    edges = np.concatenate([[0.0], np.cumsum(weights / weights.sum())])
    level = (rng.permutation(n) + rng.random(n)) / n
    which = np.clip(np.searchsorted(edges, level, side="right") - 1, 0, len(weights) - 1)
    within = (level - edges[which]) / np.maximum(edges[which + 1] - edges[which], 1e-300)
    drawn: NDArray[np.float64] = math.pi * (2 * within - 1)
    for i, part in enumerate(prior.parts):
        chosen = which == i
        if math.isinf(part.kappa):
            drawn[chosen] = part.mean_rad
        else:
            drawn[chosen] = part.mean_rad + _von_mises_quantile(within[chosen], part.kappa)
    return drawn


def _von_mises_quantile(level: NDArray[np.float64], kappa: float) -> NDArray[np.float64]:
    """Return angles less the mean below which a von Mises distribution has this much mass."""
    reach = min(math.pi, 12 / math.sqrt(max(kappa, 1e-9)))
    angles = np.linspace(-reach, reach, 4097)
    density = np.exp(kappa * (np.cos(angles) - 1))
    mass = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2)])
    found: NDArray[np.float64] = np.interp(level, mass / mass[-1], angles)
    return found
