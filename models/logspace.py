"""Arithmetic on log probabilities that stays finite where plain arithmetic does not."""

from __future__ import annotations

import math

import torch
from torch import Tensor

__all__ = ["log1mexp", "log_normalise"]


def log1mexp(log_p: Tensor) -> Tensor:
    """Return log(1 - exp(log_p)) for log_p <= 0, accurate near both ends; -inf at 0."""
    near_one = log_p > -math.log(2)
    # Each branch sees only arguments it is accurate (and finite in gradient) for.
    small = torch.where(near_one, log_p, torch.full_like(log_p, -1.0))
    large = torch.where(near_one, torch.full_like(log_p, -1.0), log_p)
    return torch.where(near_one, (-torch.expm1(small)).log(), torch.log1p(-large.exp()))


def log_normalise(log_p: Tensor) -> Tensor:
    """Return log probabilities that sum to one over the last axis."""
    return log_p - torch.logsumexp(log_p, -1, keepdim=True)
