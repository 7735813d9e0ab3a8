"""How expected each phrase was, given all the others: a predictive check of what was said.

Shape legend: V words that could have been said of a ground; S cells; B fronts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from sloop_ppl.language import SpatialRelation
from sloop_ppl.models import GroundedRelation, ObservationModel
from sloop_ppl.models._speaker import frame_angle_masses
from sloop_ppl.models.grounded_relation import word_options
from sloop_ppl.models.program import word_weights

__all__ = ["PhraseCheck", "check_phrase", "word_probabilities", "word_table"]

Table = NDArray[np.float64]

_ANGLES = 72  # exact to rounding for a smooth likelihood; see `sloop_ppl.models.program.log_words`


@dataclass(frozen=True)
class PhraseCheck:
    """How expected one phrase was.

    Parameters
    ----------
    relation
        The relation.
    index
        Its position in ``posterior.relations(target)``.
    p
        Probability that of its ground just this would be said, given all other phrases.
    rank
        Place of its word among all that could have been said, 1 the most probable; of a denied
        phrase among two, this word and any other.
    tail
        Probability of all that is no more probable than it, half of its own counted: uniform when
        the model is right, near 0 where a phrase surprises.
    words
        Word -> its probability; they sum to one.
    word
        Which of them the relation counts as: several words mean the same.
    """

    relation: SpatialRelation
    index: int
    p: float
    rank: int
    tail: float
    words: Mapping[str, float]
    word: str


def word_probabilities(
    term: GroundedRelation, model: ObservationModel, belief: Table
) -> dict[str, float]:
    """Return the probability of each word of a ground where a target is believed to be.

    Parameters
    ----------
    term
        A relation to the ground; its own word is one of the choices.
    model
        A model that speaks: plain products, or words chosen carelessly.
    belief
        Probability of each cell, shape (S,).

    Notes
    -----
    sum_s b(s) [w (1 - lapse) E_psi P(word | s, psi) + (1 - w (1 - lapse)) / V] with w the weight
    of the literal components, and P the softmax of log g over words.
    """
    names, table = word_table(term, model)
    words = dict(zip(names, (table @ belief).tolist(), strict=True))
    scale = math.fsum(words.values())
    return {word: p / scale for word, p in words.items()}


def word_table(term: GroundedRelation, model: ObservationModel) -> tuple[tuple[str, ...], Table]:
    """Return the words of a ground and the probability of each at every cell, shape (V, S).

    Parameters are those of `word_probabilities`, which sums it over a belief.
    """
    options, _ = word_options(term)
    prior = model.frame_prior_for(term)
    if prior is None:
        raise ValueError(f"Model '{model.name}' does not speak; expected speaker_of(model)")
    angles, log_mass = frame_angle_masses(prior, _ANGLES)
    with torch.no_grad():
        weights = word_weights(model.likelihood, options, angles)
        meant = torch.stack(
            [torch.logsumexp(weights.log_chance(v) + log_mass, 0) for v in range(len(options))]
        )
    total = sum(part.weight for part in model.components)
    literal = (
        sum(part.weight for part in model.components if part.combine != "uninformative") / total
    )
    share = literal * (1 - model.lapse)
    table: Table = share * meant.exp().numpy() + (1 - share) / len(options)
    return tuple(option.relation for option in options), table


def check_phrase(
    relation: SpatialRelation,
    index: int,
    term: GroundedRelation,
    model: ObservationModel,
    belief: Table,
) -> PhraseCheck:
    """Return how expected a phrase was where its target is believed to be without it.

    Parameters
    ----------
    relation, index
        The relation and its position among those of the target.
    term
        The relation, grounded.
    model
        A model that speaks.
    belief
        Belief given all other phrases, shape (S,).
    """
    words = word_probabilities(term, model, belief)
    options, chosen = word_options(term)
    word = options[chosen].relation
    own = words[word]
    if term.negated:  # two outcomes: this word, or another
        p = 1 - own
        rank, tail = 1 + (own > p), 0.5 * p + (own if own < p else 0.0)
        return PhraseCheck(relation, index, p, rank, tail, words, word)
    p = own
    # Words that mean the same differ by rounding alone.
    higher = [q for q in words.values() if q > own * (1 + 1e-12)]
    same = [q for q in words.values() if abs(q - own) <= own * 1e-12]
    tail = 1 - math.fsum(higher) - 0.5 * math.fsum(same)
    return PhraseCheck(relation, index, p, len(higher) + 1, min(max(tail, 0.0), 1.0), words, word)
