"""How probable it is that a phrase was a slip: the posterior of the model's lapse sites."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import torch
from numpy.typing import NDArray

from sloop_ppl.inference.said import Said
from sloop_ppl.language import SpatialRelation
from sloop_ppl.models import Component, Preset, RelationTerm
from sloop_ppl.models.phrases import log_idle

if TYPE_CHECKING:
    from sloop_ppl.inference.posterior import Posterior

__all__ = ["Lapse", "lapses_of"]

Table = NDArray[np.float64]


@dataclass(frozen=True)
class Lapse:
    """How probable it is that one relation was not meant.

    Parameters
    ----------
    relation : the relation.
    index : its position in ``posterior.relations(target)``.
    p : probability that it is wrong, given everything.
    prior : the same before anything was said.
    """

    relation: SpatialRelation
    index: int
    p: float
    prior: float


def lapses_of(posterior: Posterior, target: str) -> tuple[Lapse, ...]:
    """Return the probability that each relation of a target is wrong, in the order of saying.

    Parameters
    ----------
    posterior : what is believed; a model without lapses gives 0 throughout.
    target : id of the target.

    Notes
    -----
    Given component, shared fronts and cell, the lapses are independent: the chance that phrase j
    says nothing is lapse idle / [(1 - lapse) g_j + lapse idle]. Components that read the phrases
    together or otherwise than as said tell nothing of it. A relation that is read as several
    phrases, one per ground, is wrong when one of them is.
    """
    found: list[Lapse] = []
    model = posterior.model
    for which, said in enumerate(posterior._said(target)):
        joint = posterior._coupling.joint(target, which)
        for index, relation in enumerate(said.description.about(target)):
            terms = [term for term in said.terms if term.index == index]
            prior = 1 - (1 - model.lapse) ** len(terms)
            right = 1.0 - prior
            p = 0.0
            for k, component in enumerate(model.components):
                if model.lapse and _reads(component, terms[0]):
                    p += float((joint[:, k] * _wrong(terms, said, model)).sum())
                else:
                    p += float(joint[:, k].sum()) * (1 - right)
            found.append(Lapse(relation, len(found), p, prior))
    return tuple(found)


def _reads(component: Component, term: RelationTerm) -> bool:
    """Tell whether a component takes a phrase as it was said."""
    literal = component.combine == "product" and component.read_as is None
    return literal and (component.keep_frames or not term.needs_frame)


def _wrong(terms: list[RelationTerm], said: Said, model: Preset) -> Table:
    """Return P(some term lapsed | setting of the shared fronts, cell), shape (C, S)."""
    right = np.ones((said.shared.size, said.log_factor.shape[-1]))
    with torch.no_grad():
        for term in terms:
            log_p = said.shared.log_phrase(term, model).numpy()
            right = right * (1 - model.lapse * np.exp(log_idle(model, log_p.shape[-1]) - log_p))
    wrong: Table = np.clip(1 - right, 0.0, 1.0)
    return wrong
