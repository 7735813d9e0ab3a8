"""Attention-weighted vectors from an extended ground: Regier and Carlson's model."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import shapely
import torch
from torch import Tensor

from sloop_ppl.models._reference_regions import REFERENCE_CELL_M, shape_fields
from sloop_ppl.models.frames import FrameDistribution
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.models.likelihoods._base import LIKELIHOODS
from sloop_ppl.models.likelihoods._marginal import marginal_over
from sloop_ppl.models.likelihoods._parameters import Parameter, width_parameter
from sloop_ppl.models.likelihoods._radial import log_bounds, log_student, stated_width_m

__all__ = ["AttentionVectorSumLikelihood", "attended_bearing_rad"]

_POINTS, _ELEMENTS = 256, 1 << 19  # points of a ground; distances of one chunk, 4 MiB
_LEAST_DISTANCE_M = REFERENCE_CELL_M / 2  # a cell on the ground: a beam of width 0 has no mean


@dataclass(frozen=True)
class AttentionVectorSumLikelihood:
    """Direction from an attention-weighted sum of vectors, the grazing line, and distance.

    Parameters
    ----------
    attention
        Width of the beam of attention as a share of the distance to the ground, > 0.
    zero_rad
        Angle from its direction at which a word no longer holds, radians, in (0, pi).
    grazing_m
        How fast truth rises across the line that grazes the ground's far edge, metres.
    contact_m, near_m, directed_m
        Widths for contact words, for proximity words (between and across too) and for directed
        words, metres, > 0.
    tail
        Degrees of freedom of the fall-off with distance, > 0.
    floor
        Least factor of direction, > 0.

    Notes
    -----
    Source: Regier and Carlson, Grounding spatial language in perception, J. Exp. Psychol. Gen.
    130 (2001): vectors from all points of the ground are weighted by exp(-d / (lambda sigma)),
    d from the focus of attention and sigma the focus's distance from the figure; truth falls
    linearly with the angle of their sum, and is halved on the line that grazes the ground's edge.
    Theirs is for "above" and ratings; here it holds for any direction. Deviations: the focus is
    the ground's nearest point, not the one straight below, so that it does not depend on the
    frame; one line grazes the farthest point of the edge, not one its highest and one its lowest
    point, of which the latter jumps as a direction turns past a wall; and a fall-off with
    distance is added, as a rating of "above" needs none but a map does. At most 256 points
    stand for a ground, each a cell of 5 m.
    """

    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("attention", "1", 0.0, math.inf, 1.0, 0.7, "width of the beam of attention"),
        Parameter("zero_rad", "rad", 0.0, math.pi, 1.6, 1.0, "angle at which a word fails"),
        width_parameter("grazing_m", 5.0, "how soft the grazing line is"),
        width_parameter("contact_m", 6.0, "width for contact"),
        width_parameter("near_m", 15.0, "width for proximity, between and across"),
        width_parameter("directed_m", 20.0, "width for directed words"),
        Parameter("tail", "1", 0.0, math.inf, 3.0, 0.7, "degrees of freedom of the fall-off"),
    )

    quadrature_error: ClassVar[float] = 1e-5  # the triangle of its angle has kinks

    attention: float = 1.0
    zero_rad: float = math.pi / 2
    grazing_m: float = 5.0
    contact_m: float = 6.0
    near_m: float = 15.0
    directed_m: float = 20.0
    tail: float = 3.0
    floor: float = 1e-3

    def log_g(self, term: GroundedRelation, direction_rad: Tensor | None) -> Tensor:
        """Return log g, shape (B, S), or (S,) for a relation without direction."""
        if direction_rad is None:
            return self._log_radial(term)
        return self._log_directed(term, direction_rad, *self._seen(term))

    def log_marginal(self, term: GroundedRelation, frame: FrameDistribution) -> Tensor:
        """Return log E[g] over the frame by quadrature, attention computed once, shape (S,)."""
        seen = self._seen(term)
        return marginal_over(
            frame, term.offset_rad, lambda angles: self._log_directed(term, angles, *seen)
        )

    def _seen(self, term: GroundedRelation) -> tuple[Tensor, Tensor, Tensor]:
        return *attended_bearing_rad(term, self.attention), self._log_radial(term)

    def _log_directed(
        self,
        term: GroundedRelation,
        direction_rad: Tensor,
        bearing_rad: Tensor,
        defined: Tensor,
        radial: Tensor,
    ) -> Tensor:
        turned = bearing_rad - direction_rad[:, None]
        off = torch.atan2(torch.sin(turned), torch.cos(turned)).abs()
        ahead = (1 - off / self.zero_rad).clamp_min(self.floor)
        # Where the vectors cancel: the mean over directions, a triangle's of that base.
        ahead = torch.where(defined, ahead, self.zero_rad / (2 * math.pi))
        return ahead.log() + self._log_grazing(term, direction_rad) + radial

    def _log_grazing(self, term: GroundedRelation, direction_rad: Tensor) -> Tensor:
        """Return the log of how far a cell is beyond the ground's far edge, shape (B, S)."""
        towards = torch.stack([direction_rad.cos(), direction_rad.sin()])
        edge = (_hull(term) @ towards).amax(0)
        over = torch.sigmoid((term.place_m @ towards - edge) / self.grazing_m)
        return over.clamp_min(self.floor).log().T

    def _log_radial(self, term: GroundedRelation) -> Tensor:
        own = {"contact": self.contact_m, "directed": self.directed_m}
        width: Any = own.get(term.width, self.near_m)
        bounded = log_bounds(term, width)
        if bounded is not None:
            return bounded
        width = stated_width_m(term, self.contact_m) or width
        return log_student(term.off_m, width, self.tail)


def attended_bearing_rad(term: GroundedRelation, attention: Any) -> tuple[Tensor, Tensor]:
    """Return the direction of the attention-weighted vectors to each cell, and where there is one.

    Parameters
    ----------
    attention
        Width of the beam as a share of the distance to the ground, > 0.

    Returns
    -------
    tuple of Tensor
        Radians, and True where the vectors do not cancel, shape (S,) each.
    """
    points, cells = _points(term), term.place_m
    apart = torch.cdist(points, points)
    step = max(1, _ELEMENTS // len(points))
    sums = []
    for some in cells.split(step):
        away, focus = torch.cdist(some, points).min(1)
        beam = attention * away.clamp_min(_LEAST_DISTANCE_M)
        weights = torch.softmax(-apart[focus] / beam[:, None], 1)
        sums.append(some - weights @ points)
    total = torch.cat(sums)
    defined = total.detach().norm(dim=-1) > 1e-6
    safe = torch.where(defined[:, None], total, torch.ones_like(total))
    return torch.atan2(safe[:, 1], safe[:, 0]), defined


def _points(term: GroundedRelation) -> Tensor:
    """Return points spread over the ground, one for each of its cells of 5 m, shape (G, 2)."""
    grid = term.city.grid
    if grid.cell_m < REFERENCE_CELL_M:
        grid = replace(grid, cell_m=REFERENCE_CELL_M)
    shape = term.outline
    if shape.geom_type == "Point":
        return torch.tensor([[shape.x, shape.y]], dtype=torch.float64)
    rows, cols = np.nonzero(shape_fields(shape, grid).cells)
    kept = np.linspace(0, len(rows) - 1, min(len(rows), _POINTS)).round().astype(int)
    points = np.stack([grid.x_m[cols[kept]], grid.y_m[rows[kept]]], -1)
    return torch.from_numpy(points)


def _hull(term: GroundedRelation) -> Tensor:
    """Return the corners of the ground's convex hull, shape (V, 2)."""
    return torch.from_numpy(shapely.get_coordinates(shapely.convex_hull(term.outline)))


LIKELIHOODS.add("attention-vector-sum", AttentionVectorSumLikelihood())
