"""A question that is worth asking, and what its answers would say.

Shape legend: H, W grid; S = H W cells; A options; V values of the latent it is about.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.bridge._timed_utterances import follow_up
from sloop_ppl.bridge.asking._answer_text import chosen
from sloop_ppl.bridge.asking.answerer_model import AnswererModel
from sloop_ppl.bridge.asking.kinds import About
from sloop_ppl.errors import InputError, NoRelationFound, on_one_line
from sloop_ppl.inference import AnswerFactor
from sloop_ppl.planning.information import expected_bits

if TYPE_CHECKING:
    from sloop_ppl.inference import Posterior
    from sloop_ppl.language import Description

__all__ = ["DONT_KNOW", "Answer", "Question", "QuestionValue"]

Table = NDArray[np.float64]

_LEAST = 1e-12
"""Probability of an answer that should not be given: who never errs may still be wrong once."""

DONT_KNOW = "I don't know"
"""The last answer of each question."""


class Answer(NamedTuple):
    """An answer that may be given.

    Parameters
    ----------
    text
        The words.
    p
        Probability that it will be given, errors included.
    """

    text: str
    p: float


class QuestionValue(NamedTuple):
    """What a question is worth.

    Parameters
    ----------
    bits
        Expected information about the target's cell.
    reward
        Expected discounted return of the search with it less that without it, its cost included.
    """

    bits: float
    reward: float


@dataclass(frozen=True, eq=False, repr=False)
class Question:
    """A question about a target, as of one posterior.

    Parameters
    ----------
    text
        The question.
    kind
        Name of its kind; see `QUESTION_KINDS`.
    about
        What it settles: the target's ``"cell"``, a ``"referent"``, a ``"frame"``, a ``"reading"``
        or a ``"component"``.
    target
        Id of the target.
    answers
        What may be answered, with predictive probabilities that sum to one.
    bits
        Expected information about the target's cell.
    landmarks
        Ids of the landmarks that it names.
    latent, support
        Name and values of the latent that it asks for.
    truth
        Probability of each option of one who does not err, shape (A, V).
    person
        How the person is believed to answer.
    dont_know
        Probability of "I don't know".
    others
        Answers that are not offered but understood -> how far they are true, shape (V,).
    described_in
        Text of the description whose latent it asks for; empty for a cell.
    posterior
        What was believed when it was asked.
    """

    text: str
    kind: str
    about: About
    target: str
    answers: tuple[Answer, ...]
    bits: float
    landmarks: tuple[str, ...]
    latent: str
    support: Any
    truth: Table
    person: AnswererModel
    dont_know: float
    others: Mapping[str, Table]
    described_in: str
    posterior: Posterior = field(repr=False)

    def __repr__(self) -> str:
        shares = ", ".join(f"{a.text} {a.p:.2f}" for a in self.answers)
        return f"Question({self.text!r}; {shares}; {self.bits:.2f} bits)"

    @property
    def options(self) -> tuple[str, ...]:
        """The answers that choose something, A of them."""
        return tuple(a.text for a in self.answers if a.text != DONT_KNOW)

    @cached_property
    def _likelihood(self) -> Table:
        """Probability of each answer at each value of the latent, shape (A + 1, V)."""
        return self.person.likelihood(self.truth, self.dont_know)

    def p_answer(self, posterior: Posterior | None = None) -> Table:
        """Return the probability of each answer if the target is in a cell, shape (A + 1, H, W).

        Parameters
        ----------
        posterior
            What is believed; that of the question when None. Of a question about anything but the
            cell it depends on what the posterior knows of both.
        """
        chosen_posterior = self.posterior if posterior is None else posterior
        table = by_cell(chosen_posterior, self.target, self.latent, self._likelihood)
        return table.reshape(len(table), *chosen_posterior.city.grid.shape)

    def truth_by_cell(self) -> Table:
        """Return the same of a person who always knows and never errs, shape (A, H, W)."""
        table = by_cell(self.posterior, self.target, self.latent, self.truth)
        return table.reshape(len(table), *self.posterior.city.grid.shape)

    @cached_property
    def settles(self) -> Mapping[str, float]:
        """Expected information about each thing it tells of, bits, the most first.

        Keys are ``"cell"`` and names of latents: components, readings, referents, and the frame
        that is asked about. Less than a hundredth of a bit is left out.
        """
        joint, found = self.posterior.joint, {"cell": self.bits}
        for name in joint.latents:
            kind = name.rpartition("/")[2].partition("_")[0]
            if name == self.latent and kind != "cell":
                found[name] = expected_bits(self._likelihood, joint.probabilities(name))
            elif kind not in ("cell", "lapse", "frame"):
                both = joint.probabilities(self.latent, name)
                p = both.sum(0)
                given = np.divide(both, p, out=np.zeros_like(both), where=p > 0)
                given[:, p <= 0] = both.sum(1)[:, None]
                found[name] = expected_bits(self._likelihood @ given, p)
        kept = {name: bits for name, bits in found.items() if bits >= 0.01}
        return dict(sorted(kept.items(), key=lambda item: -item[1]))

    def answer(self, text: str) -> AnswerFactor:
        """Return what an answer says, for ``posterior.update``.

        Parameters
        ----------
        text
            One of the answers in about these words, "not ..." of one, "I don't know", "neither", or
            any sentence that says where the target is; what is said beyond the choice counts too.

        Raises
        ------
        InputError
            When it chooses no answer and says nothing of where the target is.

        Notes
        -----
        An answer that chooses is as probable under each value of the latent as the person gives it,
        errors included; its other words are one more description.
        """
        if not isinstance(text, str) or not text.strip():
            raise InputError(f"The answer is empty; expected {self._expected()}")
        choice = chosen(text, self.options, tuple(self.others))
        if choice is None:
            description = self._description(text)
            if description is None:
                raise InputError(
                    f"Answer '{on_one_line(text, 80)}' was not understood; expected "
                    f"{self._expected()}"
                )
            return AnswerFactor(self.text, text, description=description)
        rest = self._description(choice.rest) if len(choice.rest.split()) > 1 else None
        if choice.kind == "unknown":
            return AnswerFactor(self.text, text, description=rest)
        knows = 1.0 - self.dont_know
        if choice.kind == "other":
            truth = list(self.others.values())[choice.place]
            meant = knows * self.person.reliability * truth
            wrong = 1.0 - self.person.reliability
            likelihood = meant + knows * wrong / (len(self.truth) + 1)
        else:
            truth, likelihood = self.truth[choice.place], self._likelihood[choice.place]
            if choice.kind == "not":
                truth, likelihood = 1.0 - truth, np.maximum(knows - likelihood, 0.0)
            meant = np.minimum(knows * self.person.reliability * truth, likelihood)
        return AnswerFactor(
            question=self.text,
            answer=text,
            latents=(self.latent,),
            supports=(self.support,),
            likelihood=np.clip(likelihood, _LEAST, 1.0),
            meant=np.clip(meant, 0.0, 1.0),
            text=self.described_in,
            description=rest,
        )

    def value(
        self,
        posterior: Posterior | None = None,
        *,
        cost: float = 0.0,
        steps: int = 0,
        start: tuple[float, ...] | None = None,
        config: Any = None,
    ) -> QuestionValue:
        """Return what the question is worth in bits and in reward.

        Parameters
        ----------
        posterior
            What is believed; that of the question when None.
        cost
            What asking takes from the reward.
        steps
            How many steps it takes.
        start
            Where the search would begin, as of :func:`sloop_ppl.search`; the mean over nine places
            spread over the map, heading east, when None.
        config
            Settings of the search, a `sloop_ppl.planning.SearchConfig`; the paper's when None.
        """
        from sloop_ppl.bridge.asking._reward import expected_gain

        known = self.posterior if posterior is None else posterior
        table = self.p_answer(known)
        belief = known.belief(self.target).reshape(-1)
        bits = expected_bits(table.reshape(len(table), -1), belief)
        gain = expected_gain(
            known, self.target, self.text, table, cost=cost, steps=steps, start=start, config=config
        )
        return QuestionValue(bits, gain)

    def _description(self, text: str) -> Description | None:
        """Return what words say of the target by themselves; None for nothing."""
        subject = "i am" if self.target == "Me" else f"the {self._name()} is"
        for words in (text, f"{subject} {text}"):
            try:
                read = follow_up(self.posterior, words)
            except NoRelationFound:
                continue
            if any(relation.figure == self.target for relation in read.relations):
                return read
        return None

    def _name(self) -> str:
        known = {t.id: t for d in self.posterior.descriptions for t in d.targets}
        names = known[self.target].names if self.target in known else ()
        return names[0] if names else self.target

    def _expected(self) -> str:
        return (
            f"one of: {', '.join(self.options)}, {DONT_KNOW}; or a sentence that says where it is"
        )


def by_cell(posterior: Posterior, target: str, latent: str, table: Table) -> Table:
    """Return probabilities given a latent as probabilities given a target's cell, shape (A, S).

    Where the target cannot be, they are those given nothing.
    """
    cell = f"{target}/cell"
    if latent == cell:
        return table
    both = posterior.joint.probabilities(latent, cell)
    mass = both.sum(0)
    share = np.divide(both, mass, out=np.zeros_like(both), where=mass > 0)
    share[:, mass <= 0] = both.sum(1)[:, None]
    found: Table = table @ share
    return found
