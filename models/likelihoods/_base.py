"""What a relation likelihood is, and the registry of those there are."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from torch import Tensor

from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.registry import Registry

__all__ = ["LIKELIHOODS", "RelationLikelihood"]


@runtime_checkable
class RelationLikelihood(Protocol):
    """How true a relation is of each cell: log g, with g in [0, 1].

    Shape legend: S cells of the term's map, B directions.

    Notes
    -----
    ``log_g`` is all a likelihood must have. One that knows its expectation over a frame in closed
    form may have ``log_marginal(term, frame) -> (S,)`` too; see
    :func:`sloop_ppl.models.likelihoods.frame_marginal`. One with numbers to tune is a frozen
    dataclass that declares them as ``parameters``; see
    :class:`sloop_ppl.models.likelihoods.Parameter`. One may say how far a belief is, in total
    variation, when its frame is summed over 1440 angle bins, as ``quadrature_error``: 1e-10 where
    g is smooth in direction, more where it has a kink or jumps.
    """

    def log_g(self, term: GroundedRelation, direction_rad: Tensor | None) -> Tensor:
        """Return the log probability that the (asserted) relation is true of each cell.

        Parameters
        ----------
        term
            Relation, ground and the ground's fields.
        direction_rad
            Directions the relation points in, radians, shape (B,); None for a relation that has no
            direction.

        Returns
        -------
        Tensor
            At most 0, shape (B, S), or (S,) without a direction.
        """


LIKELIHOODS: Registry[RelationLikelihood] = Registry("likelihood")
"""Relation likelihoods by name."""
