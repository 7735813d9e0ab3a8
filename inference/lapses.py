"""How probable it is that a phrase was not meant: the posterior of the model's lapse sites."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray

from sloop_ppl.inference._pairs import MOST_NUMBERS
from sloop_ppl.inference._phrase_tables import PhraseTables
from sloop_ppl.inference.factors import DescriptionFactor, gates_of, site_name
from sloop_ppl.inference.joint import JointPosterior
from sloop_ppl.language import SpatialRelation
from sloop_ppl.models import GroundedRelation, ProgramData

__all__ = ["Lapse", "lapses_of"]


@dataclass(frozen=True)
class Lapse:
    """How probable it is that one relation was not meant.

    Parameters
    ----------
    relation
        The relation.
    index
        Its position in ``posterior.relations(target)``.
    p
        Probability that it is wrong, given everything.
    prior
        The same before anything was said.
    """

    relation: SpatialRelation
    index: int
    p: float
    prior: float


def lapses_of(
    joint: JointPosterior, factors: Sequence[DescriptionFactor], target: str
) -> tuple[Lapse, ...]:
    """Return the probability that each relation of a target is wrong, in the order of saying.

    Parameters
    ----------
    factors
        The descriptions; a model without lapses gives 0 throughout.

    Notes
    -----
    Given component, shared latents and cell, the lapses are independent: the chance that phrase j
    says nothing is lapse u / phi_j, with u the probability of a phrase that says nothing.
    Components that read the phrases together or otherwise than as said tell nothing of it. A
    relation that is read as several phrases, one per ground, is wrong when one of them is.
    """
    found: list[Lapse] = []
    for which, factor in enumerate(factors):
        if target not in factor.log_factors:
            continue
        data = factor.data
        names = [site_name(latent.name, which) for latent in data.shared]
        component = site_name(f"{target}/component", which)
        weights = joint.probabilities(*names, component, f"{target}/cell")  # (V..., K, S)
        for index, relation in enumerate(factor.about(target)):
            terms = [term for term in factor.relations(target) if term.index == index]
            if not terms:
                found.append(_lapse_of_pair(joint, factor, which, target, index, len(found)))
                continue
            lapse = data.model.lapse_of(terms[0])
            prior = 1 - (1 - lapse) ** len(terms)
            p = 0.0
            for k, part in enumerate(data.model.components):
                own = weights[..., k, :]
                reads = lapse and part.reads(terms[0])
                p += float((own * _wrong(terms, data)).sum()) if reads else prior * own.sum()
            found.append(Lapse(relation, len(found), float(p), float(prior)))
    return tuple(found)


def _lapse_of_pair(
    joint: JointPosterior,
    factor: DescriptionFactor,
    which: int,
    target: str,
    index: int,
    position: int,
) -> Lapse:
    """Return the probability that a relation to a target is wrong.

    It is the prior where the model does not heed it, or the joint of the two cells is too large.

    Notes
    -----
    Given both cells it is lapse u / phi, averaged over their joint.
    """
    model, relation = factor.data.model, factor.about(target)[index]
    pairs = factor.pairs_of(target, index)
    lapse = model.lapse_of(pairs[0].relation) if pairs else model.lapse
    if not pairs or not lapse or pairs[0].n_cells ** 2 > MOST_NUMBERS:
        return Lapse(relation, position, float(lapse), float(lapse))
    pair = replace(pairs[0], power=1.0)
    gates, otherwise = gates_of(factor, which, pairs[0]), 0.0
    cells = joint.probabilities(*gates, f"{pair.figure}/cell", f"{pair.ground}/cell")
    level = math.log(lapse) + factor.data.log_uninformative
    log_phi = pair.log_rows(torch.arange(pair.n_cells), of_figure=True).numpy()
    for values in gates.values():  # where it was not meant, nothing tells of its lapse
        meant = np.isin(np.arange(len(cells)), sorted(values))
        otherwise += float(cells[~meant].sum())
        cells = cells[meant].sum(0)
    p = float((cells * np.exp(level - log_phi)).sum()) + otherwise * lapse
    return Lapse(relation, position, min(p, 1.0), float(lapse))


def _wrong(terms: Sequence[GroundedRelation], data: ProgramData) -> NDArray[np.float64]:
    """Return P(some term lapsed | shared latents, cell), shape (V..., S)."""
    level = math.log(data.model.lapse_of(terms[0])) + data.log_uninformative
    right = np.ones(1)
    for term in terms:
        tables = PhraseTables(data, term)
        log_phi = tables.log_phi.aligned((*tables.shared, "cell")).numpy()
        right = right * (1 - np.exp(level - log_phi))
    wrong: NDArray[np.float64] = np.clip(1 - right, 0.0, 1.0)
    return wrong
