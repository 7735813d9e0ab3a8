"""How much each relation moves a belief: what is lost when it had not been said."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.language import Description, SpatialRelation

__all__ = ["Influence", "bits_between", "without_relation"]

Table = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Influence:
    """What one relation does to a belief.

    Parameters
    ----------
    relation
        The relation.
    index
        Its position in ``posterior.relations(target)``.
    bits
        Kullback-Leibler divergence of the belief from the one without the relation, >= 0.
    without
        The belief had it not been said, shape (H, W).
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


def without_relation(
    descriptions: Sequence[Description], target: str, index: int
) -> tuple[Description, ...]:
    """Return descriptions as if one relation of a target had not been said.

    Parameters
    ----------
    index
        Position of the relation among all those of the target.
    """
    changed = list(descriptions)
    for place, description in enumerate(descriptions):
        own = description.about(target)
        if index < len(own):
            kept = tuple(r for r in description.relations if r is not own[index])
            readings = tuple(
                replace(reading, relations=_without(reading.relations, own[index]))
                for reading in description.readings
            )
            changed[place] = replace(description, relations=kept, readings=readings)
            break
        index -= len(own)
    return tuple(changed)


def _without(
    relations: tuple[SpatialRelation, ...], relation: SpatialRelation
) -> tuple[SpatialRelation, ...]:
    """Return the relations of a reading without the first that says the same as one."""
    same = (n for n, other in enumerate(relations) if _meant(other) == _meant(relation))
    at = next(same, len(relations))
    return (*relations[:at], *relations[at + 1 :])


def _meant(relation: SpatialRelation) -> SpatialRelation:
    """Return a relation without where and how surely it was read."""
    return replace(relation, confidence=1.0, spans=None)
