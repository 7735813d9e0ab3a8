"""What a speaker says of a ground: the probability of each word, given front and place.

Shape legend: V words, B fronts of the ground, S cells.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sloop_ppl.models.frames import FrameDistribution
from sloop_ppl.models.presets import Preset
from sloop_ppl.models.terms import RelationTerm
from sloop_ppl.models.vocabulary import SPEAKER_WORDS

__all__ = ["WordWeights", "front_masses", "weigh_words", "word_options"]


@dataclass(frozen=True, eq=False)
class WordWeights:
    """How true each word is, and all of them together.

    Parameters
    ----------
    still : log g of the words that need no frame, shape (V1, S).
    turned : log g of the words that do, shape (V2, B, S).
    at : per word, its position in `still`, or in `turned` counted on from there.
    log_total : log of the sum over words, shape (B, S).
    """

    still: Tensor
    turned: Tensor
    at: tuple[int, ...]
    log_total: Tensor

    def log_chance(self, word: int) -> Tensor:
        """Return the log probability that one word is chosen, shape (B, S)."""
        place = self.at[word] - len(self.still)
        chosen = self.still[self.at[word]] if place < 0 else self.turned[place]
        return chosen - self.log_total

    def log_chances(self, words: NDArray[np.intp]) -> Tensor:
        """Return the log probability of one word for each cell, shape (B, S).

        Parameters
        ----------
        words : index of the word chosen at each cell, shape (S,).
        """
        at = torch.from_numpy(np.array(self.at)[words])
        plain = self.still.gather(0, at.clamp_max(len(self.still) - 1)[None])
        framed = (at - len(self.still)).clamp_min(0).expand(1, *self.log_total.shape)
        turned = self.turned.gather(0, framed)[0]
        return torch.where(at < len(self.still), plain, turned) - self.log_total


def word_options(term: RelationTerm) -> tuple[tuple[RelationTerm, ...], int]:
    """Return all that could have been said of a term's grounds, and the index of what was.

    Notes
    -----
    Words of one class are one choice: "beside" is chosen when "near" is. A meaning outside the
    vocabulary counts as one more word.
    """
    options = tuple(term.as_relation(word) for word in SPEAKER_WORDS)
    same = [i for i, o in enumerate(options) if o.relation_class == term.relation_class]
    if same:
        return options, same[-1]
    return (*options, replace(term, negated=False)), len(options)


def weigh_words(
    options: Sequence[RelationTerm], model: Preset, fronts_rad: NDArray[np.float64] | Tensor
) -> WordWeights:
    """Return how true each word is for each front, at every cell of the terms.

    Parameters
    ----------
    options : what could have been said; see `word_options`.
    model : the observation model.
    fronts_rad : directions the ground may face, radians, shape (B,).

    Notes
    -----
    P(word | front, cell) is the softmax of log g over words; a speaker prefers what is truest.
    """
    fronts = torch.as_tensor(fronts_rad)
    still, turned = [], []
    for option in options:
        if option.needs_frame:
            turned.append(model.likelihood.log_g(option, fronts + option.offset_rad))
        elif option.compass_rad is None:
            still.append(model.likelihood.log_g(option, None))
        else:
            direction = torch.tensor([option.compass_rad], dtype=torch.float64)
            still.append(model.likelihood.log_g(option, direction)[0])
    plain = torch.stack(still)
    log_total = torch.logsumexp(plain, 0)[None].expand(len(fronts), -1)
    framed = torch.stack(turned) if turned else log_total.new_zeros(0, *log_total.shape)
    if turned:
        log_total = torch.logaddexp(log_total, torch.logsumexp(framed, 0))
    order = [i for i, o in enumerate(options) if not o.needs_frame]
    order += [i for i, o in enumerate(options) if o.needs_frame]
    return WordWeights(plain, framed, tuple(np.argsort(order).tolist()), log_total)


def front_masses(frame: FrameDistribution, count: int) -> tuple[Tensor, Tensor]:
    """Return fronts that stand for a frame's distribution, and their log probabilities.

    Parameters
    ----------
    frame : which way the ground faces; gradients flow into the concentrations of its parts, each
        a number or one number per cell, shape (S,).
    count : number of fronts that stand for what is spread, > 0; see `FrameDistribution.bins`.

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
