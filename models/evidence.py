"""Turn what was said of targets into the tables the observation model scores."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap
from sloop_ppl.models.components import COMBINATIONS, Component, cut_below_uniform
from sloop_ppl.models.logspace import log1mexp, log_normalise
from sloop_ppl.models.presets import Preset
from sloop_ppl.models.terms import RelationTerm

__all__ = ["Evidence", "asserted_log_g", "gather_evidence", "log_denied", "log_phrase"]

_LEAST_LOG = math.log(1e-300)


@dataclass(frozen=True, eq=False)
class Evidence:
    """What one description says of N targets, as padded tables.

    Shape legend: N targets, K components, L rows of factors, S cells.

    Parameters
    ----------
    components : names of the components, length K.
    log_weight : log prior weights, -inf for a component that does not apply, shape (N, K).
    log_truth : log probability that each factor is true of each cell, at most 0, and 0 where a
        component has fewer factors than L, shape (N, K, L, S).
    log_normaliser : what makes a component a distribution over cells under a uniform map,
        shape (N, K, S).
    """

    components: tuple[str, ...]
    log_weight: Tensor
    log_truth: Tensor
    log_normaliser: Tensor


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
    InputError : when the model needs the true places and got none.
    """
    if model.needs_truth and truths is None:
        raise InputError(
            f"Model '{model.name}' needs to be told where the targets are; give truth="
            "{target: (x_m, y_m)}"
        )
    cells, count = city.grid.size, len(model.components)
    columns = [
        [
            _informed_rows(city, truths[i], model.informed_sigma_m or 0.0)
            if model.needs_truth and truths is not None
            else _component_rows(component, said, model)
            for component in model.components
        ]
        for i, said in enumerate(terms)
    ]
    height = max(
        (rows.shape[0] for column in columns for rows, _ in filter(None, column)), default=1
    )
    log_weight = torch.full((len(terms), count), -math.inf, dtype=torch.float64)
    log_truth = torch.zeros(len(terms), count, height, cells, dtype=torch.float64)
    log_normaliser = torch.zeros(len(terms), count, cells, dtype=torch.float64)
    for i, column in enumerate(columns):
        for k, scored in enumerate(column):
            if scored is not None:
                rows, log_normaliser[i, k] = scored
                log_truth[i, k, : rows.shape[0]] = rows
                log_weight[i, k] = math.log(model.components[k].weight)
    return Evidence(
        components=tuple(component.name for component in model.components),
        log_weight=log_normalise(log_weight),
        log_truth=log_truth,
        log_normaliser=log_normaliser,
    )


def log_phrase(term: RelationTerm, model: Preset) -> Tensor:
    """Return the log truth of one phrase at every cell, its frame summed out, shape (S,).

    Notes
    -----
    The model's lapse mixes in a phrase that says nothing: under ``"map"`` normalisation a
    uniform table, under ``"truth"`` an even chance.
    """
    log_p = asserted_log_g(term, model)
    if term.negated:
        log_p = log_denied(log_p)
    if model.normalisation == "map":
        log_p = log_normalise(log_p)
    if model.lapse:
        level = 1 / log_p.shape[-1] if model.normalisation == "map" else 0.5
        idle = torch.full_like(log_p, math.log(model.lapse * level))
        log_p = torch.logaddexp(log_p + math.log1p(-model.lapse), idle)
    return log_p


def asserted_log_g(term: RelationTerm, model: Preset) -> Tensor:
    """Return log g of the relation as if asserted, its frame summed out, shape (S,)."""
    if term.needs_frame:
        return model.likelihood.log_marginal(term, model.frame_prior(term))
    if term.compass_rad is not None:
        direction = torch.tensor([term.compass_rad], dtype=torch.float64)
        return model.likelihood.log_g(term, direction)[0]
    return model.likelihood.log_g(term, None)


def log_denied(log_g: Tensor) -> Tensor:
    """Return the log truth of a denied phrase, log(1 - g), at least that of 1e-300.

    The floor keeps a cell on the ground of "not on Main Street" from turning sums into NaN.
    """
    return log1mexp(log_g).clamp_min(_LEAST_LOG)


def _component_rows(
    component: Component, terms: tuple[RelationTerm, ...], model: Preset
) -> tuple[Tensor, Tensor] | None:
    """Return a component's factors (L, S) and normaliser (S,); None where it does not apply."""
    read = component.terms_it_reads(terms)
    if not read:
        if terms or component is not model.components[0]:
            return None
        # Nothing was said: the first component stands for all, and says nothing.
        return torch.zeros(1, 1, dtype=torch.float64), torch.zeros(1, dtype=torch.float64)
    rows = COMBINATIONS[component.combine](read, lambda term: log_phrase(term, model))
    if model.normalisation == "truth":
        return rows, torch.zeros(rows.shape[-1], dtype=torch.float64)
    total = rows.sum(0)
    wanted = log_normalise(total)
    if component.cut:
        wanted = cut_below_uniform(wanted)
    return rows, wanted - total


def _informed_rows(
    city: CityMap, truth: tuple[float, float], sigma_m: float
) -> tuple[Tensor, Tensor]:
    x, y = city.grid.centre_of(*city.grid.cell_at(*truth))
    squared = (city.grid.x_m[None, :] - x) ** 2 + (city.grid.y_m[:, None] - y) ** 2
    rows = torch.from_numpy(-squared.reshape(1, -1) / (2 * sigma_m**2))
    return rows, log_normalise(rows[0]) - rows[0]
