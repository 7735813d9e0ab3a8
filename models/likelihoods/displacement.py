"""A Gaussian about the referent: the fitted error of a place that a phrase measures."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import torch
from torch import Tensor

from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.models.likelihoods._base import LIKELIHOODS
from sloop_ppl.models.likelihoods._parameters import Parameter, width_parameter
from sloop_ppl.models.likelihoods._radial import log_bounds, stated_width_m

__all__ = ["DisplacementLikelihood"]


@dataclass(frozen=True)
class DisplacementLikelihood:
    """Gaussian in the displacement from the referent, its covariance fitted for each kind of word.

    Parameters
    ----------
    contact_m, contact_street_m
        Standard deviation for contact words, of a street and of anything else, metres, > 0, the
        same in all directions.
    near_m, near_street_m
        For proximity words.
    between_m, across_m
        Outside the region these mean.
    ahead_m
        How far directed words put the place, in their direction, metres, > 0.
    along_m, aside_m
        Standard deviations for directed words along their direction and square to it.

    Notes
    -----
    Source: after Language as a Sensor (arXiv 2606.08666): what is said measures a place with a
    calibrated error about the referent. The displacement is as long as the way to the referent's
    nearest cell, so that a street is a ridge and a building a plateau, and points from a street's
    nearest cell or anything else's centroid to the place. For a direction u and a displacement v

        log g = -(v.u - ahead)^2 / (2 along^2) - |v - (v.u) u|^2 / (2 aside^2)

    A said distance takes the place of `ahead_m` and, of a word without direction, of 0; its
    standard deviation is at least a quarter of it. Bounds on one are flat between them.
    """

    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter(
            "contact_m", "m", 0.0, math.inf, 5.0, 0.15, "deviation for contact, not with a street"
        ),
        width_parameter("contact_street_m", 8.0, "deviation for contact with a street"),
        width_parameter("near_m", 15.0, "deviation for proximity to anything but a street"),
        width_parameter("near_street_m", 15.0, "deviation for proximity to a street"),
        width_parameter("between_m", 8.0, "deviation outside the region between"),
        width_parameter("across_m", 15.0, "deviation outside the region across"),
        width_parameter("ahead_m", 15.0, "how far directed words put the place"),
        width_parameter("along_m", 20.0, "deviation of directed words along their direction"),
        width_parameter("aside_m", 15.0, "deviation of directed words square to it"),
    )

    quadrature_error: ClassVar[float] = 1e-8  # bounds on a distance bend

    contact_m: float = 5.0
    contact_street_m: float = 8.0
    near_m: float = 15.0
    near_street_m: float = 15.0
    between_m: float = 8.0
    across_m: float = 15.0
    ahead_m: float = 15.0
    along_m: float = 20.0
    aside_m: float = 15.0

    def log_g(self, term: GroundedRelation, direction_rad: Tensor | None) -> Tensor:
        """Return log g, shape (B, S), or (S,) for a relation without direction."""
        if direction_rad is None:
            return self._log_around(term)
        turned = term.outward_rad - direction_rad[:, None]
        # Where a cell has no direction, on the referent or at its centroid, it lies at the side.
        cosine = torch.where(term.has_direction, torch.cos(turned), 0.0)
        sine = torch.where(term.has_direction, torch.sin(turned), 1.0)
        along, aside = term.distance_m * cosine, term.distance_m * sine
        log_aside: Tensor = -(aside**2) / (2 * self.aside_m**2)
        bounded = log_bounds(term, self.along_m)
        if bounded is not None:  # "within 50 m north of": as far, but not behind it
            return bounded + log_aside - along.clamp_max(0.0) ** 2 / (2 * self.along_m**2)
        ahead, width = self.ahead_m, self.along_m
        if term.stated_distance_m is not None:
            ahead, width = term.stated_distance_m, stated_width_m(term, self.along_m)
        return log_aside - (along - ahead) ** 2 / (2 * width**2)

    def _log_around(self, term: GroundedRelation) -> Tensor:
        """Return log g of a relation that is the same in all directions, shape (S,)."""
        own = self._width_m(term)
        bounded = log_bounds(term, own)
        if bounded is not None:
            return bounded
        width = stated_width_m(term, self.contact_m) or own
        log_fall: Tensor = -(term.off_m**2) / (2 * width**2)
        return log_fall

    def _width_m(self, term: GroundedRelation) -> Any:
        widths = {
            "contact": (self.contact_m, self.contact_street_m),
            "proximity": (self.near_m, self.near_street_m),
            "between": (self.between_m, self.between_m),
            "across": (self.across_m, self.across_m),
            "directed": (self.along_m, self.along_m),
        }
        other, street = widths[term.width]
        return street if term.is_line else other


LIKELIHOODS.add("gaussian-displacement", DisplacementLikelihood())
