"""What a speaker says of a ground: tables of words, and the fronts they are tried with.

Shape legend: V words, B fronts of the ground, S cells.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sloop_ppl.models.frames import FrameDistribution

__all__ = ["WordWeights", "frame_angle_masses"]


@dataclass(frozen=True, eq=False)
class WordWeights:
    """How true each word is, and all of them together.

    Parameters
    ----------
    still
        Log g of the words that need no frame, shape (V1, S).
    turned
        Log g of the words that do, shape (V2, B, S).
    at
        Per word, its position in `still`, or in `turned` counted on from there.
    log_total
        Log of the sum over words, shape (B, S).
    """

    still: Tensor
    turned: Tensor
    at: tuple[int, ...]
    log_total: Tensor

    @classmethod
    def of(
        cls,
        needs_frame: Sequence[bool],
        still: Sequence[Tensor],
        turned: Sequence[Tensor],
        n_angles: int,
    ) -> WordWeights:
        """Gather the tables of some words.

        Parameters
        ----------
        needs_frame
            Per word, whether its table depends on the front.
        still, turned
            Tables of the words that do not, (S,) each, and of those that do, (B, S) each.
        n_angles
            Number of angles B.
        """
        plain = torch.stack(list(still))
        log_total = torch.logsumexp(plain, 0)[None].expand(n_angles, -1)
        framed = torch.stack(list(turned)) if turned else log_total.new_zeros(0, *log_total.shape)
        if turned:
            log_total = torch.logaddexp(log_total, torch.logsumexp(framed, 0))
        order = [i for i, needs in enumerate(needs_frame) if not needs]
        order += [i for i, needs in enumerate(needs_frame) if needs]
        return cls(plain, framed, tuple(np.argsort(order).tolist()), log_total)

    def log_chance(self, word: int) -> Tensor:
        """Return the log probability that one word is chosen, shape (B, S)."""
        place = self.at[word] - len(self.still)
        chosen = self.still[self.at[word]] if place < 0 else self.turned[place]
        return chosen - self.log_total

    def log_chances(self, words: NDArray[np.intp]) -> Tensor:
        """Return the log probability of one word for each cell, shape (B, S).

        Parameters
        ----------
        words
            Index of the word chosen at each cell, shape (S,).
        """
        at = torch.from_numpy(np.array(self.at)[words])
        plain = self.still.gather(0, at.clamp_max(len(self.still) - 1)[None])
        framed = (at - len(self.still)).clamp_min(0).expand(1, *self.log_total.shape)
        turned = self.turned.gather(0, framed)[0]
        return torch.where(at < len(self.still), plain, turned) - self.log_total


def frame_angle_masses(frame: FrameDistribution, count: int) -> tuple[Tensor, Tensor]:
    """Return fronts that stand for a frame's distribution, and their log probabilities.

    Parameters
    ----------
    frame
        Which way the ground faces; gradients flow into the concentrations of its parts, each a
        number or one number per cell, shape (S,).
    count
        Number of fronts that stand for what is spread, > 0; see `FrameDistribution.bins`.

    Returns
    -------
    tuple of Tensor
        Radians, shape (B,), and logs of probabilities that sum to one over fronts, shape (B, 1),
        or (B, S) where a concentration is one number per cell.
    """
    if not any(_is_learnt(part.kappa) for part in frame.parts):
        angles, plain = frame.bins(count)
        return torch.from_numpy(angles), torch.from_numpy(np.maximum(plain, 1e-300)).log()[:, None]
    circle = torch.linspace(-torch.pi, torch.pi, count + 1, dtype=torch.float64)[:-1, None]
    points = [part for part in frame.parts if _is_point(part.kappa)]
    spread = torch.full_like(circle, frame.lapse / count)
    for part in frame.parts:
        if not _is_point(part.kappa):
            density = torch.softmax(part.kappa * (torch.cos(circle - part.mean_rad) - 1), 0)
            spread = spread + part.weight * density
    means = circle.new_tensor([part.mean_rad for part in points])
    weights = circle.new_tensor([part.weight for part in points])[:, None]
    mass = torch.cat([weights.expand(-1, spread.shape[1]), spread])
    return torch.cat([means, circle[:, 0]]), mass.clamp_min(1e-300).log()


def _is_learnt(kappa: Any) -> bool:
    return isinstance(kappa, Tensor)


def _is_point(kappa: Any) -> bool:
    return not _is_learnt(kappa) and math.isinf(kappa)
