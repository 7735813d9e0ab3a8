"""How probable it is that a phrase was read right, and the readings that follow from it.

A logistic regression on features of the parse, fitted by ``benchmarks/fit_confidence.py`` on
descriptions with gold relations; its weights are in ``data/confidence.json``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.resources import files
from itertools import pairwise

from sloop_ppl.language.relations import RELATIONS
from sloop_ppl.language.values import NOT_ON_MAP, SPEAKER, Reading, SpatialRelation

__all__ = ["FEATURES", "PhraseContext", "confidence", "phrase_features", "readings_of"]

FEATURES = (
    "weak attachment",
    "doubtful ground",
    "kind of place",
    "back reference",
    "words between",
    "speaker",
    "inferred target",
    "target as ground",
    "denied",
    "alternative",
    "frame word",
    "contact",
    "relations",
    "unread share",
    "set aside",
    "inverted",
    "sentence",
    "not on map",
    "ground first",
    "proximity",
)
"""What the regression looks at, in the order of its weights."""

_MOST_READINGS = 4
_LEAST_APART = 0.02  # readings less probable than this are not kept apart: 2 % of the belief


@dataclass(frozen=True, slots=True)
class PhraseContext:
    """What surrounds a phrase in its text.

    Parameters
    ----------
    attachment
        How sure the rule was that attached it, in [0, 1].
    ground
        How sure the rule was that read its grounds, in [0, 1].
    named
        Whether each ground is named, rather than a kind of place or a pronoun.
    pointed
        Whether a ground is a pronoun.
    target
        Whether a ground is another target.
    inferred
        Whether no one declared its target.
    relations, aside
        How many relations were read in the text, and how many phrases were set aside.
    unread
        Share of the words of its sentence that nothing was made of.
    sentence
        Words of its sentence.
    """

    attachment: float
    ground: float
    named: bool
    pointed: bool
    target: bool
    inferred: bool
    relations: int
    aside: int
    unread: float
    sentence: int


def phrase_features(relation: SpatialRelation, context: PhraseContext) -> tuple[float, ...]:
    """Return the features of one relation, in the order of `FEATURES`."""
    record = RELATIONS[relation.relation]
    top = min(max(c.probability for c in relation.slot(i)) for i in range(len(relation.grounds)))
    spans = relation.spans
    between = 0 if spans is None else max(0, spans.relation[0] - spans.figure[1])
    inverted = spans is not None and spans.relation[0] < spans.figure[0]
    return (
        1.0 - context.attachment,
        1.0 - min(context.ground, top),
        float(not context.named),
        float(context.pointed),
        math.log1p(between) / 4.0,
        float(relation.figure == SPEAKER),
        float(context.inferred and relation.figure != SPEAKER),
        float(context.target),
        float(relation.negated),
        float(relation.either is not None),
        float(record.needs_frame),
        float(record.relation_class == "contact"),
        math.log1p(context.relations) / 2.0,
        context.unread,
        math.log1p(context.aside) / 2.0,
        float(inverted),
        math.log1p(context.sentence) / 3.0,
        float(NOT_ON_MAP in relation.grounds),
        float(spans is not None and spans.grounds[-1][0] < spans.relation[0]),
        float(record.relation_class == "proximity"),
    )


@lru_cache(maxsize=1)
def _weights() -> tuple[float, tuple[float, ...]]:
    data = json.loads((files("sloop_ppl") / "data" / "confidence.json").read_text("utf-8"))
    return float(data["intercept"]), tuple(float(data["weights"][name]) for name in FEATURES)


def confidence(features: Sequence[float]) -> float:
    """Return the probability that a relation with these features was read right."""
    intercept, weights = _weights()
    score = intercept + sum(w * x for w, x in zip(weights, features, strict=True))
    return 1.0 / (1.0 + math.exp(-score))


def readings_of(
    relations: Sequence[SpatialRelation], probabilities: Sequence[float]
) -> tuple[Reading, ...]:
    """Return readings in which each relation holds with its probability; nested, at most four.

    Phrases are misread together (a wrong subject spoils all that follows), so of the joint
    distributions with these marginals the one is taken in which the surer phrase holds whenever the
    less sure one does: reading k has the k surest phrases, with probability q_k - q_(k+1), and one
    has none, with 1 - q_1. Of more than three different probabilities the nearest are merged, each
    phrase of a merged level taking the mean.

    Examples
    --------
    >>> near = SpatialRelation("RedBike", "near", ("Ivy",))
    >>> behind = SpatialRelation("RedBike", "behind", ("Rumor",))
    >>> [
    ...     (round(r.probability, 2), len(r.relations))
    ...     for r in readings_of([near, behind], [0.9, 0.7])
    ... ]
    [(0.7, 2), (0.2, 1), (0.1, 0)]
    """
    if not relations:
        return (Reading(1.0),)
    levels: list[list[float]] = [[q] for q in sorted(probabilities, reverse=True)]
    while len(levels) > _MOST_READINGS - 1 or any(
        _mean(a) - _mean(b) < _LEAST_APART for a, b in pairwise(levels)
    ):
        gaps = [_mean(a) - _mean(b) for a, b in pairwise(levels)]
        k = gaps.index(min(gaps))
        levels[k : k + 2] = [levels[k] + levels[k + 1]]
    level_of = {q: k for k, level in enumerate(levels) for q in level}
    means = [_mean(level) for level in levels]
    kept = tuple(
        replace(r, confidence=round(means[level_of[q]], 4))
        for r, q in zip(relations, probabilities, strict=True)
    )
    found: list[Reading] = []
    for k, (mean, after) in enumerate(zip(means, (*means[1:], 0.0), strict=True)):
        inside = tuple(r for r, q in zip(kept, probabilities, strict=True) if level_of[q] <= k)
        found.append(Reading(mean - after, inside))
    found.reverse()  # all phrases first
    return (*sorted(found, key=lambda r: -r.probability), Reading(1.0 - means[0]))


def _mean(level: Sequence[float]) -> float:
    return sum(level) / len(level)
