"""The log evidence, which knows what it may be compared with, and the ranking of models by it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.models.vocabulary import SPEAKER_WORDS

if TYPE_CHECKING:
    from sloop_ppl.inference.posterior import Posterior

__all__ = ["LogEvidence", "ModelScore", "rank_models", "words_of"]


class LogEvidence(float):
    """A log probability of what was said, with the meaning it has under its model.

    It is a float, except that asking which of two is greater raises InputError when the two do
    not measure the same thing: models are ranked by evidence only when each gives a probability
    to what was said out of one vocabulary (``normalisation="speaker"``).

    Parameters
    ----------
    value : log probability, natural.
    normalisation : that of the model.
    model : the model's name.
    vocabulary : relation words that could have been said; empty unless the normalisation is
        ``"speaker"``.

    Examples
    --------
    >>> a, b = (LogEvidence(-2.0, "map", name) for name in ("sloop", "bayes"))
    >>> a > b
    Traceback (most recent call last):
    ...
    sloop_ppl.errors.InputError: Log evidence of model 'sloop' ('map' normalisation) and of \
'bayes' ('map') cannot be ranked; expected 'speaker' normalisation over one vocabulary: only \
then do both give a probability to the same words
    """

    normalisation: str
    model: str
    vocabulary: tuple[str, ...]

    def __new__(
        cls, value: float, normalisation: str, model: str, vocabulary: Sequence[str] = ()
    ) -> LogEvidence:
        """Return a float that carries its meaning."""
        made = super().__new__(cls, value)
        made.normalisation, made.model = normalisation, model
        made.vocabulary = tuple(vocabulary) if normalisation == "speaker" else ()
        return made

    def __getnewargs__(self) -> tuple[float, str, str, tuple[str, ...]]:  # type: ignore[override]
        return float(self), self.normalisation, self.model, self.vocabulary

    def __lt__(self, other: float) -> bool:
        self._check(other)
        return float.__lt__(self, other)

    def __le__(self, other: float) -> bool:
        self._check(other)
        return float.__le__(self, other)

    def __gt__(self, other: float) -> bool:
        self._check(other)
        return float.__gt__(self, other)

    def __ge__(self, other: float) -> bool:
        self._check(other)
        return float.__ge__(self, other)

    def _check(self, other: float) -> None:
        if not isinstance(other, LogEvidence) or self.model == other.model:
            return
        both = {self.normalisation, other.normalisation} == {"speaker"}
        if not both or self.vocabulary != other.vocabulary:
            raise InputError(
                f"Log evidence of model '{self.model}' ('{self.normalisation}' normalisation) and "
                f"of '{other.model}' ('{other.normalisation}') cannot be ranked; expected "
                "'speaker' normalisation over one vocabulary: only then do both give a "
                "probability to the same words"
            )


@dataclass(frozen=True)
class ModelScore:
    """How well one model predicted what was said.

    Parameters
    ----------
    name : what the model is called in the comparison.
    log_evidence : log probability of what was said, natural.
    bits_behind : how many bits it is behind the best, >= 0.
    p : its probability when all were equally likely before.
    """

    name: str
    log_evidence: float
    bits_behind: float
    p: float


def rank_models(
    posteriors: Sequence[Posterior] | Mapping[str, Posterior],
) -> tuple[ModelScore, ...]:
    """Rank models by the probability they gave to what was said, best first.

    Parameters
    ----------
    posteriors : one posterior per model, of the same descriptions on the same map from the same
        prior; by name, or named by their models.

    Raises
    ------
    InputError : when there are none; when one is not normalised over what could have been said;
        or when they are not about the same words, map, prior and sensing.

    Notes
    -----
    The evidence of a model with ``truth`` or ``map`` normalisation is no probability of what was
    said, so it ranks nothing.
    """
    named = _named(posteriors)
    (first_name, first), *others = named.items()
    for name, posterior in named.items():
        if posterior.model.normalisation != "speaker":
            raise InputError(
                f"Model '{name}' has '{posterior.model.normalisation}' normalisation, so its log "
                "evidence ranks no models; expected 'speaker' for all of them: "
                "dataclasses.replace(model, normalisation='speaker')"
            )
    for name, posterior in others:
        differs = _difference(first, posterior)
        if differs:
            raise InputError(
                f"Models '{first_name}' and '{name}' cannot be ranked: they differ in {differs}; "
                "infer both from the same"
            )
    scores = np.array([float(posterior.log_evidence) for posterior in named.values()])
    best = scores.max()
    share = np.exp(scores - best)
    ranked = [
        ModelScore(name, float(score), float((best - score) / math.log(2)), float(p))
        for name, score, p in zip(named, scores, share / share.sum(), strict=True)
    ]
    return tuple(sorted(ranked, key=lambda score: -score.log_evidence))


def words_of(posterior: Posterior) -> tuple[str, ...]:
    """Return the words a speaker of a posterior's descriptions could choose from."""
    said = {r.relation for d in posterior.descriptions for r in d.relations}
    return (*SPEAKER_WORDS, *sorted(said - set(SPEAKER_WORDS)))


def _named(posteriors: Sequence[Posterior] | Mapping[str, Posterior]) -> dict[str, Posterior]:
    if isinstance(posteriors, Mapping):
        named = dict(posteriors)
    else:
        named = {posterior.model.name: posterior for posterior in posteriors}
        if len(named) < len(posteriors):
            raise InputError(
                "Two of the posteriors have models of the same name; give a mapping of name to "
                "posterior"
            )
    if not named:
        raise InputError("There is no posterior to rank; expected at least one")
    return named


def _difference(one: Posterior, other: Posterior) -> str:
    """Return what two posteriors were told differently, or nothing."""
    if one.city.digest != other.city.digest:
        return "their map"
    if one.descriptions != other.descriptions:
        return "what was said"
    if one.model.joint_grounds != other.model.joint_grounds and any(
        len(r.grounds) > 1 for d in one.descriptions for r in d.relations
    ):
        return "how many phrases a relation to several grounds is (joint_grounds)"
    for mine, theirs, what in (
        (one.log_prior, other.log_prior, "their prior"),
        (one.log_sensed, other.log_sensed, "what was sensed"),
    ):
        if set(mine) != set(theirs) or any(not np.array_equal(mine[t], theirs[t]) for t in mine):
            return what
    return ""
