"""How truth falls off with distance: what several likelihoods share."""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor

from sloop_ppl.models.grounded_relation import GroundedRelation

__all__ = ["SAID_SHARE", "log_student", "stated_width_m"]

SAID_SHARE = 0.25
"""Width of the ring that a said distance means, as a share of that distance: by hand. People round
distances, so the error grows with them (Weber's law)."""


def stated_width_m(term: GroundedRelation, least_m: Any) -> Any:
    """Return the width of the ring that a said distance means; None when none was said.

    Parameters
    ----------
    least_m
        Least width, metres; a float or a tensor.
    """
    if term.stated_distance_m is None:
        return None
    width = SAID_SHARE * term.stated_distance_m
    return torch.clamp_min(least_m, width) if isinstance(least_m, Tensor) else max(least_m, width)


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
