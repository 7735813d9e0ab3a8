"""Frames of reference that several phrases of one speaker share."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.models.phrases import front_prior, log_phrase, log_phrase_given_front
from sloop_ppl.models.presets import Preset
from sloop_ppl.models.terms import RelationTerm

__all__ = ["SharedFrames", "share_frames"]

_BINS = {1: 72, 2: 36}
"""Angles that stand for each frame when so many are shared."""


@dataclass(frozen=True, eq=False)
class SharedFrames:
    """The grounds whose front several phrases share, and the joint settings of those fronts.

    Parameters
    ----------
    grounds : ids of the grounds, G of them; empty when nothing is shared.
    fronts_rad : front of each ground in each joint setting, radians, shape (C, G).
    log_prior : log probability of each setting, shape (C,).
    """

    grounds: tuple[str, ...]
    fronts_rad: NDArray[np.float64]
    log_prior: Tensor

    @property
    def size(self) -> int:
        """Number of joint settings, 1 when nothing is shared."""
        return len(self.log_prior)

    def log_phrase(self, term: RelationTerm, model: Preset) -> Tensor:
        """Return the log truth of a phrase in each joint setting, shape (C, S)."""
        if front_prior(term, model) is None or term.ground not in self.grounds:
            return log_phrase(term, model).expand(self.size, -1)
        fronts = self.fronts_rad[:, self.grounds.index(term.ground)]
        distinct, which = np.unique(fronts, return_inverse=True)
        return log_phrase_given_front(term, model, distinct)[torch.from_numpy(which)]


def share_frames(terms: Sequence[tuple[RelationTerm, ...]], model: Preset) -> SharedFrames:
    """Return what is shared between the phrases of a description.

    Parameters
    ----------
    terms : per target, what was said of it.
    model : the observation model; one that shares no frames shares nothing.

    Raises
    ------
    InputError : when the fronts of more than two grounds are shared.

    Notes
    -----
    A front is shared by all frame phrases about a ground, of any target; its prior is that of the
    first such phrase. The settings are enumerated: 72 angles for one ground, 36 each for two.
    """
    nothing = SharedFrames((), np.zeros((1, 0)), torch.zeros(1, dtype=torch.float64))
    if not model.shared_frames:
        return nothing
    framed = [term for said in terms for term in said if front_prior(term, model) is not None]
    grounds = dict.fromkeys(term.ground for term in framed)
    several = [g for g in grounds if sum(term.ground == g for term in framed) > 1]
    if not several:
        return nothing
    if len(several) > max(_BINS):
        raise InputError(
            f"{len(several)} grounds have a front that several phrases share "
            f"({', '.join(several)}); at most {max(_BINS)} can be enumerated; say less at a time "
            "or use a model without shared frames"
        )
    first = [next(term for term in framed if term.ground == ground) for ground in several]
    believed = [front_prior(term, model) for term in first]
    priors = [prior.bins(_BINS[len(several)]) for prior in believed if prior is not None]
    fronts = np.array(list(itertools.product(*(angles for angles, _ in priors))))
    mass = np.array([math.prod(p) for p in itertools.product(*(mass for _, mass in priors))])
    return SharedFrames(tuple(several), fronts, torch.from_numpy(np.log(np.maximum(mass, 1e-300))))
