"""How true one phrase is of each cell: asserted or denied, normalised, with its lapse."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sloop_ppl.models.frames import FrameDistribution
from sloop_ppl.models.likelihoods import frame_marginal
from sloop_ppl.models.logspace import log1mexp, log_normalise
from sloop_ppl.models.presets import Preset
from sloop_ppl.models.speaker import front_masses, weigh_words, word_options
from sloop_ppl.models.terms import RelationTerm
from sloop_ppl.models.vocabulary import SPEAKER_WORDS

__all__ = ["front_prior", "log_idle", "log_phrase", "log_phrase_given_front", "log_words"]

_LEAST_LOG = math.log(1e-300)
_SPEAKER_BINS = 360


def front_prior(term: RelationTerm, model: Preset) -> FrameDistribution | None:
    """Return the prior of the front that a phrase depends on; None when it depends on none.

    Under ``"speaker"`` normalisation every phrase does, since the front decides what else could
    have been said; that prior is the one of "front" for all words.
    """
    if model.normalisation == "speaker":
        return model.frame_prior(term.as_relation("front"))
    return model.frame_prior(term) if term.needs_frame else None


def log_phrase(term: RelationTerm, model: Preset) -> Tensor:
    """Return the log truth of one phrase at every cell, its frame summed out, shape (S,).

    Notes
    -----
    The model's lapse mixes in a phrase that says nothing; see `log_idle`.
    """
    return _with_lapse(_meant(term, model), model)


def log_phrase_given_front(
    term: RelationTerm,
    model: Preset,
    fronts_rad: NDArray[np.float64] | Tensor,
    *,
    lapse: bool = True,
) -> Tensor:
    """Return the log truth of a phrase at every cell for each front of its ground.

    Parameters
    ----------
    term : a relation; one that needs no frame is as true for every front.
    model : the observation model.
    fronts_rad : directions the ground may face, radians, shape (B,).
    lapse : False to leave the model's lapse out: the phrase is meant.

    Returns
    -------
    Tensor
        Shape (B, S); its mean over the frame's prior is `log_phrase`.
    """
    if model.normalisation == "speaker":
        meant = _spoken(term, model, fronts_rad)
    elif not term.needs_frame:
        meant = _meant(term, model).expand(len(fronts_rad), -1)
    else:
        directions = torch.as_tensor(fronts_rad) + term.offset_rad
        meant = _denied_if(model.likelihood.log_g(term, directions), term)
        if model.normalisation == "map":
            meant = meant - torch.logsumexp(_truth(term, model), -1)
    return _with_lapse(meant, model) if lapse else meant


def log_words(
    options: Sequence[RelationTerm],
    model: Preset,
    words: NDArray[np.intp],
    denied: NDArray[np.bool_],
    *,
    fronts: int = 72,
) -> Tensor:
    """Return the log probability of one phrase about each cell of a ground, shape (S,).

    Parameters
    ----------
    options : all that could have been said of the ground, as terms of S cells; see
        :func:`sloop_ppl.models.speaker.word_options`.
    model : a model with ``"speaker"`` normalisation; its lapse is left out. Numbers of its
        likelihood and the concentration of its frames may be tensors of shape (S,).
    words : index among the options of the word said of each cell, shape (S,).
    denied : whether it was denied, shape (S,).
    fronts : angles that stand for the frame, which is summed out: 72 are exact to rounding for a
        smooth likelihood and to some .005 in the log for one with a kink.

    Notes
    -----
    `log_phrase` at many known cells at once, which is what learning from them takes.
    """
    front = options[SPEAKER_WORDS.index("front")]
    angles, log_mass = front_masses(model.frame_prior(front), fronts)
    log_p = weigh_words(options, model, angles).log_chances(words)
    if denied.any():
        other = log1mexp(log_p).clamp_min(_LEAST_LOG)
        log_p = torch.where(torch.from_numpy(denied), other, log_p)
    return torch.logsumexp(log_p + log_mass, 0)


def log_idle(model: Preset, cells: int) -> float:
    """Return the log truth of a phrase that says nothing, the same at every cell.

    Under ``"map"`` normalisation it is uniform over cells, under ``"truth"`` an even chance, and
    under ``"speaker"`` any word is as likely.
    """
    level = {"map": 1 / cells, "truth": 0.5, "speaker": 1 / len(SPEAKER_WORDS)}
    return math.log(level[model.normalisation])


def _meant(term: RelationTerm, model: Preset) -> Tensor:
    """Return the log truth of a phrase that is meant, its frame summed out, shape (S,)."""
    prior = front_prior(term, model)
    if model.normalisation == "speaker" and prior is not None:
        fronts, log_mass = front_masses(prior, _SPEAKER_BINS)
        return torch.logsumexp(_spoken(term, model, fronts) + log_mass, 0)
    log_p = _truth(term, model)
    return log_normalise(log_p) if model.normalisation == "map" else log_p


def _truth(term: RelationTerm, model: Preset) -> Tensor:
    """Return the log probability that the phrase is true, its frame summed out, shape (S,)."""
    return _denied_if(_asserted(term, model), term)


def _asserted(term: RelationTerm, model: Preset) -> Tensor:
    if term.needs_frame:
        return frame_marginal(model.likelihood, term, model.frame_prior(term))
    if term.compass_rad is not None:
        direction = torch.tensor([term.compass_rad], dtype=torch.float64)
        return model.likelihood.log_g(term, direction)[0]
    return model.likelihood.log_g(term, None)


def _denied_if(log_g: Tensor, term: RelationTerm) -> Tensor:
    """Return log(1 - g) of a denied phrase, at least that of 1e-300, else log g.

    The floor keeps a cell on the ground of "not on Main Street" from turning sums into NaN.
    """
    return log1mexp(log_g).clamp_min(_LEAST_LOG) if term.negated else log_g


def _with_lapse(meant: Tensor, model: Preset) -> Tensor:
    if not model.lapse:
        return meant
    lapse = torch.as_tensor(model.lapse, dtype=torch.float64)  # a tensor while it is learnt
    idle = lapse.log() + log_idle(model, meant.shape[-1])
    return torch.logaddexp(meant + torch.log1p(-lapse), idle)


def _spoken(term: RelationTerm, model: Preset, fronts_rad: NDArray[np.float64] | Tensor) -> Tensor:
    """Return log P(word | ground, front, cell), a choice among the vocabulary, shape (B, S).

    A denied phrase has the probability that another word is chosen.
    """
    options, chosen = word_options(term)
    return _denied_if(weigh_words(options, model, fronts_rad).log_chance(chosen), term)
