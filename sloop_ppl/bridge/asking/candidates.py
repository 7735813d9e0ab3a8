"""Find the questions that are worth asking.

Shape legend: S cells; A options.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.bridge._map_check import check_map
from sloop_ppl.bridge.asking.answerer_model import AnswererModel
from sloop_ppl.bridge.asking.kinds import QUESTION_KINDS, Proposal
from sloop_ppl.bridge.asking.landmark_salience import saliences
from sloop_ppl.bridge.asking.question import DONT_KNOW, Answer, Question, by_cell
from sloop_ppl.bridge.asking.scene import Scene
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.planning.information import AnswerTables

if TYPE_CHECKING:
    from sloop_ppl.inference import Posterior
    from sloop_ppl.maps import CityMap

__all__ = ["CandidateQuestions", "ask"]

Table = NDArray[np.float64]

MOST_CELLS = 2000
"""Cells at which the candidates are compared; the best of them are then taken exactly."""

LEAST_BITS = 0.01
"""A question that tells less is not worth asking."""


def ask(
    posterior: Posterior,
    city: CityMap,
    n: int = 3,
    *,
    target: str | None = None,
    kinds: Sequence[str] | None = None,
    person: AnswererModel | None = None,
    landmarks: Sequence[str] | None = None,
    most_landmarks: int = 14,
    without: Sequence[str] = (),
) -> tuple[Question, ...]:
    """Return the questions whose answers are expected to tell most of where the targets are.

    Parameters
    ----------
    posterior
        What is believed.
    city
        The map it was made on.
    n
        How many questions at most, > 0. The best of each kind come first, then the next best of
        any kind; they are returned in the order of their information.
    target
        Id of the target to ask about; any when None.
    kinds
        Names of the kinds of questions; all of `QUESTION_KINDS` when None.
    person
        How the person is believed to answer; errs in 10 % when None.
    landmarks
        Ids of the landmarks to ask about; the salient ones nearest to the belief when None.
    most_landmarks
        How many of these.
    without
        Texts of questions that are not asked again.

    Returns
    -------
    tuple of Question
        Empty when nothing is worth asking: no answer would tell a hundredth of a bit.

    Raises
    ------
    InputError
        When n is below 1 or the posterior was made on another map.
    UnknownName
        When there is no such target, kind or landmark.

    Examples
    --------
    >>> import sloop_ppl as sloop
    >>> city = sloop.load_map("cleveland")
    >>> posterior = sloop.infer("the red bike is behind Ivy", city)
    >>> (question,) = sloop.ask(posterior, city, n=1)
    >>> question.about, round(sum(answer.p for answer in question.answers), 9)
    ('cell', 1.0)
    """
    check_map(posterior, city)
    if n < 1:
        raise InputError(f"n is {n}; expected at least one question")
    if target is not None and target not in posterior.targets:
        raise UnknownName("target", target, posterior.targets)
    targets = posterior.targets if target is None else (target,)
    found: list[Question] = []
    for name in targets:
        candidates = CandidateQuestions(
            posterior, name, kinds=kinds, person=person, landmarks=landmarks,
            most_landmarks=most_landmarks, without=without,
        )  # fmt: skip
        found += [candidates.question(k) for k in candidates.best(n)]
    found = [question for question in found if question.bits >= LEAST_BITS]
    texts: dict[str, Question] = {}
    for question in sorted(found, key=lambda question: -question.bits):
        texts.setdefault(question.text, question)  # a referent that targets share is one question
    ranked = list(texts.values())
    order = _varied([question.kind for question in ranked])[:n]
    return tuple(ranked[i] for i in sorted(order))


def _varied(kinds: Sequence[str]) -> list[int]:
    """Return positions in a ranking, the first of each kind before all others."""
    first = [i for i, kind in enumerate(kinds) if kind not in kinds[:i]]
    return [*first, *(i for i in range(len(kinds)) if i not in first)]


@dataclass(frozen=True, eq=False)
class _Candidate:
    kind: str
    proposal: Proposal
    dont_know: float
    p_option: NDArray[np.float32]  # at the cells of the scene, if it is known, shape (A, S)


class CandidateQuestions:
    """All questions about a target, compared by their expected information.

    Parameters
    ----------
    posterior, target, kinds, person, landmarks, most_landmarks, without
        As of `ask`.
    """

    def __init__(
        self,
        posterior: Posterior,
        target: str,
        *,
        kinds: Sequence[str] | None = None,
        person: AnswererModel | None = None,
        landmarks: Sequence[str] | None = None,
        most_landmarks: int = 14,
        without: Sequence[str] = (),
    ) -> None:
        self.posterior, self.target = posterior, target
        self.person = AnswererModel() if person is None else person
        for landmark in landmarks or ():
            posterior.city.landmark(landmark)
        self.scene = Scene.of(
            posterior,
            target,
            most=most_landmarks,
            landmarks=None if landmarks is None else tuple(landmarks),
            person=self.person,
        )
        belief = posterior.belief(target).reshape(-1)
        self.cells, self._weights = _representative(belief, MOST_CELLS)
        scene = self.scene.at(self.cells)
        shares: dict[str, Table] = {}
        self._candidates: list[_Candidate] = []
        for kind in QUESTION_KINDS if kinds is None else kinds:
            for proposal in QUESTION_KINDS[kind](scene):
                if proposal.text not in without:
                    self._candidates.append(self._candidate(kind, proposal, scene, shares))
        tables = [candidate.p_option for candidate in self._candidates]
        self._tables = AnswerTables(tables) if tables else None
        self._knows = np.array([1.0 - candidate.dont_know for candidate in self._candidates])

    def __len__(self) -> int:
        return len(self._candidates)

    def texts(self) -> tuple[str, ...]:
        """Return the texts of all candidates."""
        return tuple(candidate.proposal.text for candidate in self._candidates)

    def bits(self, belief: Table | None = None) -> Table:
        """Return the expected information of each candidate, bits.

        Parameters
        ----------
        belief
            Where the target is believed to be now, shape (H, W); as the posterior has it when None.

        Notes
        -----
        On a map of more than 2,000 cells those that the belief was represented by are weighed by
        how much more or less probable they have become.
        """
        if self._tables is None:
            return np.zeros(0)
        weights = self._weights
        if belief is not None:
            old = self.posterior.belief(self.target).reshape(-1)
            new = belief.reshape(-1)
            at = slice(None) if self.cells is None else self.cells
            ratio = np.divide(new[at], old[at], out=np.zeros_like(new[at]), where=old[at] > 0)
            weights = new if self.cells is None else weights * ratio
            weights = weights / max(float(weights.sum()), 1e-300)
        # "I don't know" tells nothing, wherever the target is.
        bits: Table = self._tables.bits(weights) * self._knows
        return bits

    def best(self, n: int, belief: Table | None = None) -> list[int]:
        """Return the positions of n candidates, the best of each kind first; see `bits`."""
        bits = self.bits(belief)
        ranked = [int(k) for k in np.argsort(-bits, kind="stable") if bits[k] > 0]
        varied = _varied([self._candidates[k].kind for k in ranked])
        return [ranked[i] for i in varied[:n]]

    def question(self, k: int) -> Question:
        """Return a candidate as a question, taken exactly on all cells."""
        candidate, posterior = self._candidates[k], self.posterior
        proposal, cell = candidate.proposal, f"{self.target}/cell"
        latent = proposal.latent or cell
        truth = _checked(proposal.table(self.scene), proposal, candidate.kind)
        likelihood = self.person.likelihood(truth, candidate.dont_know)
        table = by_cell(posterior, self.target, latent, likelihood)
        belief = posterior.belief(self.target).reshape(-1)
        p = table @ belief
        names = (*proposal.options, *((DONT_KNOW,) if candidate.dont_know else ()))
        return Question(
            text=proposal.text,
            kind=candidate.kind,
            about=proposal.about,
            target=self.target,
            answers=tuple(Answer(name, float(v)) for name, v in zip(names, p, strict=False)),
            bits=float(AnswerTables([table]).bits(belief)[0]),
            landmarks=proposal.landmarks,
            latent=latent,
            support=posterior.joint.support(latent),
            truth=truth,
            person=self.person,
            dont_know=candidate.dont_know,
            others={name: row(self.scene) for name, row in proposal.others.items()},
            described_in=proposal.described_in,
            posterior=posterior,
        )

    def _candidate(
        self, kind: str, proposal: Proposal, scene: Scene, shares: dict[str, Table]
    ) -> _Candidate:
        scores = saliences(scene.city)
        known = [scores[m] for m in proposal.landmarks]
        # Who is asked which of two places they meant has spoken of them.
        dont_know = self.person.dont_know_of(min(known, default=1.0))
        if proposal.about != "cell":
            dont_know = self.person.dont_know
        truth = _checked(proposal.table(scene), proposal, kind, sums=False)
        if proposal.latent is not None:
            name = proposal.latent
            if name not in shares:
                identity = np.eye(len(self.posterior.joint.support(name)))
                share = by_cell(self.posterior, self.target, name, identity)
                shares[name] = share if self.cells is None else share[:, self.cells]
            truth = truth @ shares[name]
        # Linear in the truth, so that it may be averaged over what is known of it first.
        options = self.person.options(truth.astype(np.float32))
        return _Candidate(kind, proposal, dont_know, options)


def _representative(belief: Table, most: int) -> tuple[NDArray[np.intp] | None, Table]:
    """Return cells that stand for a belief, and their weights; all of few cells (None).

    Systematic resampling: the cells at the quantiles of the belief, each as often as it holds one.
    """
    if len(belief) <= most:
        return None, belief
    running = np.cumsum(belief)
    at = np.searchsorted(running, (np.arange(most) + 0.5) / most * running[-1], side="right")
    cells, counts = np.unique(np.minimum(at, len(belief) - 1), return_counts=True)
    return cells, counts / most


def _checked(table: Table, proposal: Proposal, kind: str, *, sums: bool = True) -> Table:
    """Refuse what a kind of question from outside returns when it is no table of its options.

    Whether columns sum to one is looked at when a question is taken exactly, not of each candidate.
    """
    found = np.asarray(table, dtype=np.float64)
    fits = found.ndim == 2 and len(found) == len(proposal.options) and len(found) > 1
    if not fits or (sums and (found.min() < -1e-9 or np.abs(found.sum(0) - 1.0).max() > 1e-6)):
        raise InputError(
            f"The table of question '{proposal.text}' of kind '{kind}' has shape {found.shape}; "
            f"expected probabilities of its {len(proposal.options)} options, shape "
            f"({len(proposal.options)}, values), columns summing to one"
        )
    return found
