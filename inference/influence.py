"""How much each relation moves a belief: what is lost when it had not been said."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.language import Description, SpatialRelation

if TYPE_CHECKING:
    from sloop_ppl.inference.posterior import Posterior

__all__ = ["Influence", "bits_between", "influence_on", "rebuilt", "without"]

Table = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Influence:
    """What one relation does to a belief.

    Parameters
    ----------
    relation : the relation.
    index : its position in ``posterior.relations(target)``.
    bits : Kullback-Leibler divergence of the belief from the one without the relation, >= 0.
    without : the belief had it not been said, shape (H, W).
    """

    relation: SpatialRelation
    index: int
    bits: float
    without: Table


def bits_between(belief: Table, other: Table) -> float:
    """Return the Kullback-Leibler divergence KL(belief || other) in bits, at least 0."""
    held = belief > 0
    with np.errstate(divide="ignore"):
        ratio = np.log2(belief[held]) - np.log2(other[held])
    return max(float((belief[held] * ratio).sum()), 0.0)


def influence_on(
    posterior: Posterior, target: str, rng: np.random.Generator | None = None
) -> tuple[Influence, ...]:
    """Infer again without each relation of a target in turn.

    Parameters
    ----------
    posterior : beliefs, and the descriptions they come from.
    target : id of the target.
    rng : wanted by engines that draw.

    Returns
    -------
    tuple of Influence
        In the order of ``posterior.relations(target)``. Prior and sensing stay; the components
        that apply are chosen anew, so that a description that is left with nothing to say in
        front of, behind, left or right has no component without frames.

    Notes
    -----
    Influences do not add up to the bits gained from the prior: relations overlap, or contradict
    each other.
    """
    relations = posterior.relations(target)
    belief = posterior.belief(target)
    if posterior.model.needs_truth:  # it listens to nothing that was said
        return tuple(Influence(r, i, 0.0, belief) for i, r in enumerate(relations))
    found = []
    for index, relation in enumerate(relations):
        other = without(posterior, target, index, rng).belief(target)
        found.append(Influence(relation, index, bits_between(belief, other), other))
    return tuple(found)


def without(
    posterior: Posterior, target: str, index: int, rng: np.random.Generator | None = None
) -> Posterior:
    """Return the posterior had one relation of a target not been said.

    Parameters
    ----------
    posterior : beliefs, and the descriptions they come from.
    target : id of the target.
    index : position of the relation in ``posterior.relations(target)``.
    rng : wanted by engines that draw.
    """
    said = posterior._said(target)
    descriptions = list(posterior.descriptions)
    for part in said:
        own = part.description.about(target)
        if index < len(own):
            place = next(i for i, d in enumerate(descriptions) if d is part.description)
            descriptions[place] = _leave_out(part.description, own[index])
            break
        index -= len(own)
    return rebuilt(posterior, descriptions, rng)


def rebuilt(
    posterior: Posterior, descriptions: list[Description], rng: np.random.Generator | None = None
) -> Posterior:
    """Return a posterior as if other descriptions had come to it; prior and sensing stay."""
    from sloop_ppl.inference.infer import infer_description

    first, *later = descriptions
    grid = posterior.city.grid
    known = {t: np.exp(posterior.log_prior[t]).reshape(grid.shape) for t in posterior.targets}
    again, _ = infer_description(
        first,
        posterior.city,
        posterior.model,
        posterior.engine,
        prior={t.id: known[t.id] for t in first.targets},
        rng=rng,
    )
    for description in later:
        again = again.update(description, rng=rng)
    return replace(again, log_prior=posterior.log_prior, log_sensed=posterior.log_sensed, _cache={})


def _leave_out(description: Description, relation: SpatialRelation) -> Description:
    kept = list(description.relations)
    del kept[next(i for i, r in enumerate(kept) if r is relation)]
    return replace(description, relations=tuple(kept))
