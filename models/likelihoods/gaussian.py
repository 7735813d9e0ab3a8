"""The paper's likelihood: a Gaussian in distance times a cosine in direction."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import torch
from torch import Tensor

from sloop_ppl.models.frames import FrameDistribution
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.models.likelihoods._base import LIKELIHOODS
from sloop_ppl.models.likelihoods._cosine import expected_cosine
from sloop_ppl.models.likelihoods._parameters import Parameter, clamped, width_parameter
from sloop_ppl.models.likelihoods._radial import log_bounds, stated_width_m

__all__ = ["GaussianLikelihood"]


@dataclass(frozen=True)
class GaussianLikelihood:
    r"""Gaussian fall-off with the distance from the ground, times a cosine in direction.

    Parameters
    ----------
    near_m
        Width for the proximity words, between and across, metres, > 0.
    at_m
        Width for the contact words, metres, > 0.
    directed_min_m, directed_max_m
        Bounds of the width for directed words, metres; between them the width is the longer side of
        the ground.
    clipped
        True for max(0, cos); False for \|cos\|, under which front and behind are the same.
    from_centroid
        True to take directions from the ground's centroid; False from its nearest cell.
    floor
        Least direction factor, > 0.

    Notes
    -----
    Source: SLOOP eq. (5) and (6). `clipped` with `from_centroid` is the published code
    (widths 3 cells, 1 cell, 1 to 4 cells of 5 m); neither is the paper's text. Widths are kept
    in metres, so that a finer grid keeps the belief. A said distance replaces the fall-off by a
    Gaussian around it whose width is a quarter of it, at least `at_m`, bounds on one by
    `log_bounds`: ours, the paper ignores both.
    """

    parameters: ClassVar[tuple[Parameter, ...]] = (
        width_parameter("near_m", 15.0, "width for proximity, between and across"),
        width_parameter("at_m", 5.0, "width for contact"),
        width_parameter("directed_min_m", 5.0, "least width for directed words"),
        width_parameter("directed_max_m", 20.0, "greatest width for directed words"),
    )

    quadrature_error: ClassVar[float] = 1e-5  # the clipped or absolute cosine has a kink

    near_m: float = 15.0
    at_m: float = 5.0
    directed_min_m: float = 5.0
    directed_max_m: float = 20.0
    clipped: bool = True
    from_centroid: bool = True
    floor: float = 1e-9

    def log_g(self, term: GroundedRelation, direction_rad: Tensor | None) -> Tensor:
        """Return log g, shape (B, S), or (S,) for a relation without direction."""
        radial = self._log_radial(term)
        if direction_rad is None:
            return radial
        cosine = torch.cos(self._bearing(term) - direction_rad[..., None])
        factor = (cosine if self.clipped else cosine.abs()).clamp_min(self.floor)
        return self._log_directed(term, factor, radial)

    def log_marginal(self, term: GroundedRelation, frame: FrameDistribution) -> Tensor:
        """Return log E[g] over the frame, in closed form, shape (S,)."""
        factor = expected_cosine(
            self._bearing(term), frame, term.offset_rad, clipped=self.clipped, floor=self.floor
        )
        return self._log_directed(term, factor, self._log_radial(term))

    def _bearing(self, term: GroundedRelation) -> Tensor:
        return term.bearing_rad if self.from_centroid else term.nearest_bearing_rad

    def _log_directed(self, term: GroundedRelation, factor: Tensor, radial: Tensor) -> Tensor:
        # A cell at the very centroid has no direction: the factor is its mean over directions.
        mean = (1 if self.clipped else 2) / math.pi
        return torch.where(term.at_centroid, mean, factor).log() + radial

    def _log_radial(self, term: GroundedRelation) -> Tensor:
        bounded = log_bounds(term, self._width_m(term))
        if bounded is not None:
            return bounded
        width = stated_width_m(term, self.at_m) or self._width_m(term)
        log_fall: Tensor = -(term.off_m**2) / (2 * width**2)
        return log_fall

    def _width_m(self, term: GroundedRelation) -> Any:
        if term.width == "contact":
            return self.at_m
        if term.width == "directed":
            return clamped(term.extent_m, self.directed_min_m, self.directed_max_m)
        return self.near_m


LIKELIHOODS.add("gaussian-clipped", GaussianLikelihood())
LIKELIHOODS.add("gaussian-cosine", GaussianLikelihood(clipped=False, from_centroid=False))
