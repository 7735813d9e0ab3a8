"""Turn what was said of targets into the tables the observation model scores."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap, Grid
from sloop_ppl.models.components import COMBINATIONS, Component, cut_below_uniform
from sloop_ppl.models.logspace import log_normalise
from sloop_ppl.models.phrases import log_phrase
from sloop_ppl.models.presets import Preset
from sloop_ppl.models.shared import SharedFrames, share_frames
from sloop_ppl.models.smoothing import log_blur
from sloop_ppl.models.terms import RelationTerm

__all__ = ["Evidence", "gather_evidence"]


@dataclass(frozen=True, eq=False)
class Evidence:
    """What one description says of N targets, as padded tables.

    Shape legend: C joint settings of the frames that targets or phrases share (1 when none is),
    N targets, K components, L rows of factors, S cells.

    Parameters
    ----------
    components : names of the components, length K.
    shared : the frames that are shared, and the prior of their settings.
    log_weight : log prior weights, -inf for a component that does not apply, shape (N, K).
    log_truth : log probability that each factor is true of each cell, at most 0, and 0 where a
        component has fewer factors than L, shape (C, N, K, L, S).
    log_normaliser : what makes a component a distribution over cells under a uniform map,
        tempering, cut and shared error included, shape (C, N, K, S).
    """

    components: tuple[str, ...]
    shared: SharedFrames
    log_weight: Tensor
    log_truth: Tensor
    log_normaliser: Tensor


@dataclass(frozen=True, eq=False)
class _Scored:
    """One component of one target: rows (C, L, S) and normaliser (C, S)."""

    rows: Tensor
    normaliser: Tensor


def gather_evidence(
    terms: Sequence[tuple[RelationTerm, ...]],
    city: CityMap,
    model: Preset,
    truths: Sequence[tuple[float, float]] | None = None,
) -> Evidence:
    """Score what was said of each target under every component, at every cell.

    Parameters
    ----------
    terms : per target, what was said of it; a target of which nothing was said has no terms.
    city : the map.
    model : the observation model.
    truths : per target, its true place in metres; wanted by models that need it, else ignored.

    Raises
    ------
    InputError : when the model needs the true places and got none, or too many frames are shared.
    """
    if model.needs_truth and truths is None:
        raise InputError(
            f"Model '{model.name}' needs to be told where the targets are; give truth="
            "{target: (x_m, y_m)}"
        )
    shared = share_frames(terms, model)
    phrases = _Phrases(model, shared)
    columns: list[list[_Scored | None]] = []
    for i, said in enumerate(terms):
        if model.needs_truth and truths is not None:
            around = _informed(city, truths[i], model.informed_sigma_m or 0.0)
            columns.append([around for _ in model.components])
            continue
        columns.append(
            [_scored(part, said, model, phrases, city.grid) for part in model.components]
        )
    scored = [part for column in columns for part in column if part is not None]
    height = max((part.rows.shape[-2] for part in scored), default=1)
    shape = (shared.size, len(terms), len(model.components))
    log_weight = torch.full(shape[1:], -math.inf, dtype=torch.float64)
    log_truth = torch.zeros(*shape, height, city.grid.size, dtype=torch.float64)
    log_normaliser = torch.zeros(*shape, city.grid.size, dtype=torch.float64)
    for i, column in enumerate(columns):
        for k, part in enumerate(column):
            if part is not None:
                log_truth[:, i, k, : part.rows.shape[-2]] = part.rows
                log_normaliser[:, i, k] = part.normaliser
                log_weight[i, k] = math.log(model.components[k].weight)
    return Evidence(
        components=tuple(component.name for component in model.components),
        shared=shared,
        log_weight=log_normalise(log_weight),
        log_truth=log_truth,
        log_normaliser=log_normaliser,
    )


class _Phrases:
    """Tables of phrases, each made once however often it is read."""

    def __init__(self, model: Preset, shared: SharedFrames) -> None:
        self._model, self.shared = model, shared
        self._plain: dict[Hashable, Tensor] = {}
        self._given: dict[Hashable, Tensor] = {}

    def plain(self, term: RelationTerm) -> Tensor:
        """Return the log truth of a phrase, its frame summed out, shape (S,)."""
        key = _meaning(term)
        if key not in self._plain:
            self._plain[key] = log_phrase(term, self._model)
        return self._plain[key]

    def given(self, term: RelationTerm) -> Tensor:
        """Return the log truth of a phrase in each setting of shared frames, shape (C, S)."""
        key = _meaning(term)
        if key not in self._given:
            self._given[key] = self.shared.log_phrase(term, self._model)
        return self._given[key]


def _meaning(term: RelationTerm) -> Hashable:
    """Return what two phrases of one map have in common when they say the same."""
    return (
        term.relation,
        term.relation_class,
        term.grounds,
        term.negated,
        term.said_distance_m,
        term.joint,
    )


def _scored(
    component: Component,
    terms: tuple[RelationTerm, ...],
    model: Preset,
    phrases: _Phrases,
    grid: Grid,
) -> _Scored | None:
    """Score a component; None where it does not apply."""
    read = component.terms_it_reads(terms)
    if not read:
        if terms or component is not model.components[0]:
            return None
        # Nothing was said: the first component stands for all, and says nothing.
        return _Scored(torch.zeros(1, 1, 1).double(), torch.zeros(1, 1).double())
    shared = phrases.shared
    if component.uses_frames and shared.grounds:
        rows = torch.stack([phrases.given(term) for term in read], 1)
    else:
        combine = COMBINATIONS[component.combine]
        rows = combine(read, phrases.plain)[None]
    total = rows.sum(1)
    wanted = total / len(read) ** model.temper
    if model.normalisation == "map":
        per_setting = torch.logsumexp(wanted, -1)
        settings = shared.log_prior if len(rows) > 1 else torch.zeros(1).double()
        wanted = wanted - torch.logsumexp(per_setting + settings, 0)
    if component.cut:
        wanted = cut_below_uniform(wanted)
    if model.error_m:
        wanted = log_blur(wanted, grid, model.error_m)
    return _Scored(rows, wanted - total)


def _informed(city: CityMap, truth: tuple[float, float], sigma_m: float) -> _Scored:
    city.grid.cell_at(*truth)  # raises for a place outside the map
    x, y = truth
    squared = (city.grid.x_m[None, :] - x) ** 2 + (city.grid.y_m[:, None] - y) ** 2
    rows = torch.from_numpy(-squared.reshape(1, 1, -1) / (2 * sigma_m**2))
    return _Scored(rows, log_normalise(rows[:, 0]) - rows[:, 0])
