"""A hard region: true inside, all but false outside. For teaching."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import torch
from torch import Tensor

from sloop_ppl.models.frames import FrameDistribution
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.models.likelihoods._base import LIKELIHOODS
from sloop_ppl.models.likelihoods._cosine import bessel_ratios
from sloop_ppl.models.likelihoods._radial import bound_width_m, stated_width_m

__all__ = ["BoxLikelihood"]


@dataclass(frozen=True)
class BoxLikelihood:
    """1 within a reach of the ground and an angle of the direction, `floor` elsewhere.

    Parameters
    ----------
    contact_m, near_m, directed_m
        Reach of contact words, of proximity words (between and across too) and of directed words,
        metres, > 0.
    half_angle_rad
        How far from its direction a directed word still holds, radians, (0, pi].
    floor
        What is left outside, in (0, 1), so that logs stay finite.

    Notes
    -----
    Source: textbook. It declares no parameters: a step has no gradient to learn by.
    """

    quadrature_error: ClassVar[float] = 2e-3  # it jumps with direction

    contact_m: float = 7.5  # a cell of 5 m and half the next
    near_m: float = 30.0
    directed_m: float = 40.0
    half_angle_rad: float = math.pi / 3  # compass words, 45 degrees apart, overlap
    floor: float = 1e-6

    def log_g(self, term: GroundedRelation, direction_rad: Tensor | None) -> Tensor:
        """Return log g, shape (B, S), or (S,) for a relation without direction."""
        if direction_rad is None:
            return self._log(self._within(term).double())
        turned = term.outward_rad - direction_rad[:, None]
        ahead = torch.cos(turned) >= math.cos(self.half_angle_rad)
        share = torch.where(term.has_direction, ahead.double(), self.half_angle_rad / math.pi)
        return self._log(share * self._within(term))

    def log_marginal(self, term: GroundedRelation, frame: FrameDistribution) -> Tensor:
        """Return log E[g] over the frame, in closed form, shape (S,).

        Notes
        -----
        The mass of a von Mises part within h of an angle x from its mean is
        h / pi + (2 / pi) sum_n A_n sin(n h) cos(n x) / n with A_n = I_n(kappa) / I_0(kappa).
        """
        h = self.half_angle_rad
        share = torch.full_like(term.outward_rad, frame.lapse * h / math.pi)
        for part in frame.parts:
            x = term.outward_rad - term.offset_rad - part.mean_rad
            if math.isinf(part.kappa):
                mass = (torch.cos(x) >= math.cos(h)).double()
            else:
                # A_n is about exp(-n^2 / (2 kappa)): e^-32 at n = 8 sqrt(kappa), up to kappa 6e4.
                count = min(24 + int(8 * math.sqrt(float(part.kappa))), 2000)
                mass = torch.full_like(x, h / math.pi)
                for n, a in enumerate(bessel_ratios(float(part.kappa), count)[1:], start=1):
                    mass = mass + 2 / math.pi * a * math.sin(n * h) * torch.cos(n * x) / n
            share = share + part.weight * mass
        share = torch.where(term.has_direction, share.clamp(0.0, 1.0), h / math.pi)
        return self._log(share * self._within(term))

    def _within(self, term: GroundedRelation) -> Tensor:
        own = {"contact": self.contact_m, "directed": self.directed_m}
        reach = own.get(term.width, self.near_m)
        bounds = term.distance_bounds
        if bounds is not None and term.has_bounds:  # a deviation beyond each bound, as of a ring
            near = bound_width_m(bounds.low_m, bounds.vagueness, self.contact_m)
            far = bound_width_m(bounds.high_m, bounds.vagueness, self.contact_m)
            both: Tensor = (term.below_m <= near) & (term.above_m <= far)
            return both
        stated = stated_width_m(term, self.contact_m)
        reach = reach if stated is None else stated
        within: Tensor = term.off_m <= reach
        return within

    def _log(self, share: Tensor) -> Tensor:
        return (self.floor + (1 - self.floor) * share).log().clamp_max(0.0)


LIKELIHOODS.add("box", BoxLikelihood())
