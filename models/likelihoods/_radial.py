"""How truth falls off with distance: what several likelihoods share."""

from __future__ import annotations

import math
from typing import Any

import torch
from torch import Tensor

from sloop_ppl.models.grounded_relation import GroundedRelation

__all__ = ["SAID_SHARE", "bound_width_m", "log_bounds", "log_student", "stated_width_m"]

SAID_SHARE = 0.25
"""Least width of the ring that a said distance means, as a share of that distance: by hand. People
round distances, so the error grows with them (Weber's law)."""


def stated_width_m(term: GroundedRelation, least_m: Any) -> Any:
    """Return the width of the ring that a said distance means; None when none was said.

    Parameters
    ----------
    least_m
        Least width, metres; a float or a tensor.
    """
    if term.stated_distance_m is None:
        return None
    bounds = term.distance_bounds
    share = SAID_SHARE if bounds is None else max(SAID_SHARE, bounds.vagueness)
    return _at_least(least_m, share * term.stated_distance_m)


def bound_width_m(bound_m: float, vagueness: float, least_m: Any) -> Any:
    """Return how far beyond a said bound truth reaches: one standard deviation, metres.

    Parameters
    ----------
    bound_m
        The bound, metres, finite.
    vagueness
        Standard deviation as a share of the bound.
    least_m
        Width of the relation's own fall-off, metres; a float or a tensor.
    """
    return _at_least(least_m, vagueness * bound_m)


def log_bounds(term: GroundedRelation, width_m: Any) -> Tensor | None:
    """Return the log of the distance factor of a relation with bounds, shape (S,); None without.

    Parameters
    ----------
    term
        The relation.
    width_m
        Width of its own fall-off, metres; a float or a tensor.

    Notes
    -----
    Source: ours. 1 from the lower to the upper bound ("within 50 m", "50 to 100 m", "at least
    50 m"), beyond each a Gaussian whose standard deviation is its vagueness times the bound and
    at least the relation's own width. Equal bounds are one distance, a ring: `stated_width_m`.
    """
    bounds = term.distance_bounds
    if bounds is None or not term.has_bounds:
        return None
    log_fall = torch.zeros_like(term.distance_m)
    for bound_m, off_m in ((bounds.low_m, term.below_m), (bounds.high_m, term.above_m)):
        if math.isfinite(bound_m):
            sigma_m = bound_width_m(bound_m, bounds.vagueness, width_m)
            log_fall = log_fall - off_m**2 / (2 * sigma_m**2)
    return log_fall


def _at_least(least_m: Any, width_m: float) -> Any:
    return (
        torch.clamp_min(least_m, width_m) if isinstance(least_m, Tensor) else max(least_m, width_m)
    )


def log_student(off_m: Tensor, width_m: Any, tail: Any) -> Tensor:
    """Return the log of a heavy-tailed fall-off that is 1 at distance 0, shape of `off_m`.

    Parameters
    ----------
    off_m
        Distances, metres, >= 0.
    width_m
        Width, metres, > 0.
    tail
        Degrees of freedom, > 0; the fall-off goes with the power -(tail + 1) far away.

    Notes
    -----
    Source: the kernel of Student's t distribution, (1 + d^2 / (nu w^2))^(-(nu + 1) / 2).
    """
    log_fall: Tensor = -0.5 * (tail + 1) * torch.log1p(off_m**2 / (tail * width_m**2))
    return log_fall
