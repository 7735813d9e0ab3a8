"""Score a model by targets whose cells are known, differentiably.

Two scores: the log belief at the known cell, and, for a model that gives words a probability, the
log probability of what was said there, which takes the known cells only.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.inference._enumeration import description_tables
from sloop_ppl.inference._free_parameters import FreeParameters
from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap
from sloop_ppl.models import (
    GroundedRelation,
    ObservationModel,
    Program,
    ground_description,
    program_data,
)
from sloop_ppl.models._logspace import log_normalise
from sloop_ppl.models._vocabulary import speaker_words
from sloop_ppl.models.grounded_relation import word_options
from sloop_ppl.models.program import log_words, with_lapse

__all__ = [
    "BeliefScore",
    "Example",
    "SupervisedScore",
    "WordScore",
    "belief_scores",
    "supervised_score",
]

Deviations = Mapping[int, Tensor]
"""Number -> how far each speaker's is from the population's, shape (speakers,)."""


@dataclass(frozen=True, eq=False)
class Example:
    """A description and where its targets truly are.

    Parameters
    ----------
    description
        What was said.
    city
        The map.
    cells
        Target -> row (row 0 in the south) and column; targets left out teach nothing.
    speaker
        Who said it; only wanted where parameters vary from speaker to speaker.
    area
        True for the cells in which targets are searched for, shape (H, W): beliefs are of these;
        None for all.
    """

    description: Description
    city: CityMap
    cells: Mapping[str, tuple[int, int]]
    speaker: str | None = None
    area: NDArray[np.bool_] | None = None


@dataclass(frozen=True, eq=False)
class _KnownTarget:
    """One target whose cell is known, and what was said of it."""

    terms: tuple[GroundedRelation, ...]
    city: CityMap
    cell: int
    speaker: int
    area: NDArray[np.bool_] | None = None

    @property
    def shares_tables(self) -> bool:
        """Tell whether it may be one of several targets of a program: no latent is its own."""
        return not any(term.choices for term in self.terms)


class SupervisedScore(Protocol):
    """What a set of examples says of a model, with `size` targets."""

    size: int
    score_name: str

    def scores(self, free: FreeParameters, z: Tensor, deviations: Deviations) -> Tensor:
        """Return a log score per target at some numbers, shape (N,)."""


def supervised_score(
    examples: Sequence[Example], free: FreeParameters, speakers: Sequence[str] = ()
) -> SupervisedScore:
    """Return what examples are scored by: words where the model gives them a chance, else belief.

    Parameters
    ----------
    examples
        Descriptions with known cells.
    free
        What is learnt, of which model.
    speakers
        Names of all speakers when parameters vary between them.

    Raises
    ------
    InputError
        When no example knows a cell of which something was said, a cell is not on its map, or
        speakers are wanted and an example has none.
    """
    if free.is_generative:
        return WordScore(_known_targets(examples, free.model, speakers, sum_grounds=False))
    return BeliefScore(_known_targets(examples, free.model, speakers))


def belief_scores(examples: Sequence[Example], model: ObservationModel) -> Tensor:
    """Return the log belief at each known cell, map by map, shape (N,)."""
    groups = BeliefScore(_known_targets(examples, model, ())).groups
    with torch.no_grad():
        return torch.cat([_log_beliefs(model, None, group) for group in groups])


def _known_targets(
    examples: Sequence[Example],
    model: ObservationModel,
    speakers: Sequence[str],
    *,
    sum_grounds: bool = True,
) -> list[_KnownTarget]:
    targets = []
    # The most probable reading teaches; which of several places was meant stays open.
    certain = replace(model, sum_readings=False, sum_grounds=sum_grounds)
    for i, example in enumerate(examples):
        if speakers and example.speaker is None:
            raise InputError(
                f"Example {i} has no speaker; expected one, for parameters vary between speakers"
            )
        speaker = speakers.index(example.speaker) if speakers and example.speaker else 0
        every = ground_description(example.description, example.city, certain)
        grounded = {t: tuple(r for r in own if not r.is_silent) for t, own in every.items()}
        rows, cols = example.city.grid.shape
        for target, (row, col) in example.cells.items():
            if not (0 <= row < rows and 0 <= col < cols):
                raise InputError(
                    f"Example {i} has '{target}' in cell ({row}, {col}); expected rows 0 to "
                    f"{rows - 1} and columns 0 to {cols - 1}"
                )
            if grounded.get(target):
                terms, cell = grounded[target], row * cols + col
                targets.append(_KnownTarget(terms, example.city, cell, speaker, example.area))
    if not targets:
        raise InputError("No example says anything of a target whose cell is known")
    return targets


class BeliefScore:
    """The log belief at the known cells, every model's score; maps are scored whole."""

    score_name = "log score of known cells"

    def __init__(self, targets: Sequence[_KnownTarget]) -> None:
        self.size = len(targets)
        parted: dict[Hashable, list[_KnownTarget]] = {}
        for n, one in enumerate(targets):
            area = None if one.area is None else one.area.tobytes()
            alone = None if one.shares_tables else n
            parted.setdefault((one.city.digest, one.speaker, area, alone), []).append(one)
        self.groups = list(parted.values())

    def scores(self, free: FreeParameters, z: Tensor, deviations: Deviations) -> Tensor:
        """Return the log belief at each known cell, map by map and speaker by speaker, (N,)."""
        weights = free.log_weights(z)
        found = []
        for group in self.groups:
            own = list(z)
            for i, offset in deviations.items():
                own[i] = z[i] + offset[group[0].speaker]
            found.append(_log_beliefs(free.at(own), weights, group))
        return torch.cat(found)


def _log_beliefs(
    model: ObservationModel, log_weights: Tensor | None, group: Sequence[_KnownTarget]
) -> Tensor:
    """Return the log belief at the known cells of one map, differentiable, shape (N,)."""
    relations = {str(n): one.terms for n, one in enumerate(group)}
    data = program_data(relations, group[0].city, model)
    rows = torch.stack(description_tables(Program(data, "summed")))
    if data.shared:  # what is left open is summed out by its prior
        rows = (rows + data.log_shared[..., None]).flatten(1, -3).logsumexp(1)
    if log_weights is not None:  # in place of the weights that the components have
        applies = torch.isfinite(data.log_weight)
        weight = log_normalise(torch.where(applies, log_weights, -math.inf))
        fixed = torch.where(applies, data.log_weight, 0.0)
        rows = torch.where(applies[..., None], rows - fixed[..., None], 0.0) + weight[..., None]
    log_q = torch.logsumexp(rows, 1)
    if group[0].area is not None:  # -1e30 has a gradient, which -inf has not
        log_q = torch.where(torch.from_numpy(group[0].area.reshape(-1)), log_q, -1e30)
    log_p = log_normalise(log_q)
    return log_p[torch.arange(len(group)), torch.tensor([one.cell for one in group])]


@dataclass(frozen=True, eq=False)
class _GroundPhrases:
    """All phrases about one ground: what could have been said, and what was, at known cells."""

    options: tuple[GroundedRelation, ...]
    words: NDArray[np.intp]
    denied: NDArray[np.bool_]
    target: Tensor
    speaker: Tensor


class WordScore:
    """The log probability of what was said, given the known cell: phrases ground by ground."""

    score_name = "log probability of what was said of known cells"

    def __init__(self, targets: Sequence[_KnownTarget]) -> None:
        self.size = len(targets)
        self._phrases = torch.tensor([len(one.terms) for one in targets], dtype=torch.float64)
        met: dict[Hashable, list[tuple[int, GroundedRelation]]] = {}
        for n, one in enumerate(targets):
            for term in one.terms:
                key = (one.city.digest, term.grounds, term.joint)
                met.setdefault(key, []).append((n, term))
        self._grounds = [
            some for phrases in met.values() for some in _phrases_by_ground(phrases, targets)
        ]

    def scores(self, free: FreeParameters, z: Tensor, deviations: Deviations) -> Tensor:
        """Return the log probability of what was said of each target, shape (N,)."""
        model = free.at(z)
        literal = torch.zeros(self.size, dtype=torch.float64)
        for ground in self._grounds:
            own = list(z)
            for i, offset in deviations.items():
                own[i] = z[i] + offset[ground.speaker]
            there = free.at(own) if deviations else model
            log_word = log_words(ground.options, there, ground.words, ground.denied)
            log_phrase = with_lapse(log_word, model.lapse, model.log_uninformative(1))
            literal = literal.index_add(0, ground.target, log_phrase)
        uninformative = self._phrases * model.log_uninformative(1)
        each = [
            literal if part.combine == "product" else uninformative for part in model.components
        ]
        weights = free.log_weights(z)
        if weights is None:
            shares = torch.tensor([part.weight for part in model.components], dtype=torch.float64)
            weights = log_normalise(shares.log())
        return torch.logsumexp(torch.stack(each) + weights[:, None], 0)


def _phrases_by_ground(
    phrases: Sequence[tuple[int, GroundedRelation]], targets: Sequence[_KnownTarget]
) -> Iterator[_GroundPhrases]:
    """Yield the phrases about one ground; a meaning beyond the vocabulary makes its own group."""
    words, _ = word_options(phrases[0][1])
    index = {option.relation_class: i for i, option in enumerate(words[: len(speaker_words())])}
    parted: dict[Hashable, list[tuple[int, GroundedRelation]]] = {}
    for n, term in phrases:
        plain = term.relation_class in index
        key = None if plain else (term.relation, term.stated_distance_m, term.distance_bounds)
        parted.setdefault(key, []).append((n, term))
    for some in parted.values():
        rows = np.array([n for n, _ in some])
        cells = np.array([targets[n].cell for n in rows])
        options, chosen = word_options(some[0][1].at(cells))
        yield _GroundPhrases(
            options,
            np.array([index.get(term.relation_class, chosen) for _, term in some]),
            np.array([term.negated for _, term in some]),
            torch.from_numpy(rows),
            torch.tensor([targets[n].speaker for n in rows]),
        )
