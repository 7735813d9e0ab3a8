"""A heavy tail in distance and a von Mises shape in direction, its frame summed out exactly."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import torch
from torch import Tensor

from sloop_ppl.models.frames import FrameDistribution
from sloop_ppl.models.likelihoods.base import LIKELIHOODS
from sloop_ppl.models.likelihoods.parameters import Parameter, width_parameter
from sloop_ppl.models.likelihoods.radial import log_student, said_width_m
from sloop_ppl.models.terms import RelationTerm

__all__ = ["StudentVonMisesLikelihood", "log_expected_von_mises"]


@dataclass(frozen=True)
class StudentVonMisesLikelihood:
    """Student's kernel in distance times exp(kappa (cos x - 1)) in direction.

    Parameters
    ----------
    contact_m, contact_street_m : width for contact words, of a street and of anything else;
        streets are drawn narrower than they are. Metres, > 0, as all widths.
    near_m, near_street_m : width for proximity words.
    between_m, across_m : width outside the region these mean.
    directed_m, directed_street_m : width for compass and frame words.
    tail : degrees of freedom, > 0: far away truth falls with the power -(tail + 1).
    kappa_compass, kappa_frame : sharpness in direction of compass and of frame words, > 0.

    Notes
    -----
    Source: ours, after ``t`` distributed errors of distance and von Mises tuning in angle. A
    plain Gaussian gives a place 60 m off no chance, and one wrong phrase then decides. Directions
    are taken from the nearest part of a street and from the centroid of anything else; where a
    cell has none (on the street, at the centroid) the factor is its mean over directions. Widths
    were set by hand; learning is what moves them.
    """

    parameters: ClassVar[tuple[Parameter, ...]] = (
        # Cells of 5 m cannot tell a narrower width, and one would tie the belief to their size.
        Parameter(
            "contact_m", "m", 0.0, math.inf, 5.0, 0.15, "width for contact, not with a street"
        ),
        width_parameter("contact_street_m", 8.0, "width for contact with a street"),
        width_parameter("near_m", 15.0, "width for proximity to anything but a street"),
        width_parameter("near_street_m", 15.0, "width for proximity to a street"),
        width_parameter("between_m", 8.0, "width outside the region between"),
        width_parameter("across_m", 15.0, "width outside the region across"),
        width_parameter("directed_m", 20.0, "width for directed words, not of a street"),
        width_parameter("directed_street_m", 20.0, "width for directed words of a street"),
        Parameter("tail", "1", 0.0, math.inf, 5.0, 0.35, "degrees of freedom of the fall-off"),
        Parameter("kappa_compass", "1", 0.0, math.inf, 3.0, 0.35, "sharpness of compass words"),
        Parameter("kappa_frame", "1", 0.0, math.inf, 3.0, 0.35, "sharpness of frame words"),
    )

    contact_m: float = 5.0
    contact_street_m: float = 8.0
    near_m: float = 15.0
    near_street_m: float = 15.0
    between_m: float = 8.0
    across_m: float = 15.0
    directed_m: float = 20.0
    directed_street_m: float = 20.0
    tail: float = 5.0
    kappa_compass: float = 3.0
    kappa_frame: float = 3.0

    def log_g(self, term: RelationTerm, direction_rad: Tensor | None) -> Tensor:
        """Return log g, shape (B, S), or (S,) for a relation without direction."""
        radial = self._log_radial(term)
        if direction_rad is None:
            return radial
        kappa = self._kappa(term)
        angular = kappa * (torch.cos(term.outward_rad - direction_rad[:, None]) - 1)
        return torch.where(term.has_direction, angular, _log_mean(kappa)) + radial

    def log_marginal(self, term: RelationTerm, frame: FrameDistribution) -> Tensor:
        """Return log E[g] over the frame, in closed form, shape (S,)."""
        kappa = self._kappa(term)
        turned = term.outward_rad - term.offset_rad
        angular = log_expected_von_mises(turned, frame, kappa)
        return torch.where(term.has_direction, angular, _log_mean(kappa)) + self._log_radial(term)

    def _kappa(self, term: RelationTerm) -> Any:
        return self.kappa_frame if term.needs_frame else self.kappa_compass

    def _log_radial(self, term: RelationTerm) -> Tensor:
        width = said_width_m(term, self.contact_m) or self._width_m(term)
        return log_student(term.off_m, width, self.tail)

    def _width_m(self, term: RelationTerm) -> Any:
        street = term.is_line
        if term.needs_frame or term.compass_rad is not None:
            return self.directed_street_m if street else self.directed_m
        if term.relation_class == "between":
            return self.between_m
        if term.relation_class == "across":
            return self.across_m
        if term.relation_class == "contact":
            return self.contact_street_m if street else self.contact_m
        return self.near_street_m if street else self.near_m


def log_expected_von_mises(bearing_rad: Tensor, frame: FrameDistribution, kappa: Any) -> Tensor:
    """Return log E[exp(kappa (cos(bearing - psi) - 1))] over the front psi, in closed form.

    Parameters
    ----------
    bearing_rad : direction of each cell less the relation's offset, radians, shape (S,).
    frame : distribution of psi.
    kappa : sharpness, > 0; a float or a tensor without dimensions.

    Returns
    -------
    Tensor
        At most 0, shape (S,).

    Notes
    -----
    For a von Mises part of concentration c the expectation is I_0(R) / I_0(c) exp(-kappa) with
    R^2 = kappa^2 + c^2 + 2 kappa c cos x: the product of two von Mises shapes is one.
    """
    parts = []
    if frame.lapse:
        parts.append(torch.zeros_like(bearing_rad) + _log(frame.lapse) + _log_mean(kappa))
    for part in frame.parts:
        x = bearing_rad - part.mean_rad
        spread = torch.as_tensor(part.kappa, dtype=torch.float64)
        if torch.isinf(spread):
            log_mean = kappa * (torch.cos(x) - 1)
        else:
            both = (kappa**2 + spread**2 + 2 * kappa * spread * torch.cos(x)).clamp_min(1e-16)
            length = both.sqrt()
            log_mean = _log_i0e(length) - _log_i0e(spread) + (length - spread - kappa)
        parts.append(log_mean + _log(part.weight))
    # Rounding may lift a sum of weights over one by 1e-16.
    return torch.logsumexp(torch.stack(parts), 0).clamp_max(0.0)


def _log_mean(kappa: Any) -> Tensor:
    """Return the log of exp(kappa (cos x - 1)) averaged over directions."""
    return _log_i0e(torch.as_tensor(kappa, dtype=torch.float64))


def _log(share: Any) -> Tensor:
    return torch.as_tensor(share, dtype=torch.float64).log()


def _log_i0e(x: Tensor) -> Tensor:
    logarithm: Tensor = torch.special.i0e(x).log()
    return logarithm


LIKELIHOODS.add("student-vonmises", StudentVonMisesLikelihood())
