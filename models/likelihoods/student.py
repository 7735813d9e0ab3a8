"""A heavy tail in distance and a von Mises shape in direction, its frame summed out exactly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import torch
from torch import Tensor

from sloop_ppl.models.frames import FrameDistribution
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.models.likelihoods._base import LIKELIHOODS
from sloop_ppl.models.likelihoods._parameters import Parameter, width_parameter
from sloop_ppl.models.likelihoods._radial import log_bounds, log_student, stated_width_m

__all__ = ["StudentVonMisesLikelihood", "log_expected_von_mises"]

_NODES = 4096
"""Bearings that the angular factor is tabulated over. A cubic through four nodes h apart is off by
3/128 h^4 = 1.3e-13 of the fourth derivative: 5e-12 in log g for kappa 3 and fronts up to 500."""

_TABULATED_FROM = 2 * _NODES
"""Cells above which it is tabulated: with fewer, the table costs as much as it saves."""


@dataclass(frozen=True)
class StudentVonMisesLikelihood:
    """Student's kernel in distance times exp(kappa (cos x - 1)) in direction.

    Parameters
    ----------
    contact_m, contact_point_m, contact_street_m
        Width for contact words, of an area, of a point (a place without a shape of its own, a
        bench or a bank in a row of houses) and of a street, from its carriageway. Metres, > 0, as
        all widths.
    near_m, near_street_m
        Width for proximity words.
    between_m, across_m
        Width outside the region these mean.
    directed_m, directed_street_m
        Width for compass and frame words.
    tail
        Degrees of freedom, > 0: far away truth falls with the power -(tail + 1).
    kappa_compass, kappa_frame
        Sharpness in direction of compass and of frame words, > 0.
    own_place
        Factor of the widths of words that stand away from their ground (near, north, behind,
        across) for a ground that is no street, when speakers say where they are themselves, > 0.
    own_street
        Factor of all widths of a street then, > 0.

    Notes
    -----
    Source: ours, after ``t`` distributed errors of distance and von Mises tuning in angle. A
    plain Gaussian gives a place 60 m off no chance, and one wrong phrase then decides. Directions
    are taken from the nearest part of a street and from the centroid of anything else; where a
    cell has none (on the street, at the centroid) the factor is its mean over directions. Widths
    were set by hand; learning is what moves them.

    A word is used at the scale of what the speaker sees (Guo, Liu and Wieczorek 2008: the
    uncertainty of a locality grows with its distance). Who describes an object on a map relates
    it to what is beside it; who stands in a street and says where that is takes what can be seen
    from there, in the median 85 m away instead of 5 (`docs/models.md`): hence `own_place`. The
    size of the map, the space between its places and the extent of the ground explain less.
    """

    parameters: ClassVar[tuple[Parameter, ...]] = (
        # Cells of 5 m cannot tell a narrower width, and one would tie the belief to their size:
        # from 4.6 m on, halving the cells moves less than .02 of it.
        Parameter("contact_m", "m", 4.6, math.inf, 5.0, 0.5, "width for contact with an area"),
        Parameter(
            "contact_point_m", "m", 0.0, math.inf, 3.0, 0.5, "width for contact with a point"
        ),
        width_parameter("contact_street_m", 8.0, "width for contact with a street"),
        width_parameter("near_m", 15.0, "width for proximity to anything but a street"),
        width_parameter("near_street_m", 15.0, "width for proximity to a street"),
        width_parameter("between_m", 8.0, "width outside the region between"),
        width_parameter("across_m", 15.0, "width outside the region across"),
        width_parameter("directed_m", 20.0, "width for directed words, not of a street"),
        width_parameter("directed_street_m", 20.0, "width for directed words of a street"),
        Parameter("tail", "1", 0.0, math.inf, 5.0, 0.35, "degrees of freedom of the fall-off"),
        # Where it is sharper than 3.4, beliefs depend on the size of the cells about a centroid:
        # halving them moves more than .02. So a fit leaves it at 3 unless it is asked for.
        Parameter(
            *("kappa_compass", "1", 0.0, math.inf, 3.0, 0.35, "sharpness of compass words"),
            by_default=False,
        ),
        Parameter("kappa_frame", "1", 0.0, math.inf, 3.0, 0.35, "sharpness of frame words"),
        Parameter(
            "own_place", "1", 0.0, math.inf, 3.0, 0.7, "factor of widths, of one's own place"
        ),
        Parameter(
            "own_street", "1", 0.0, math.inf, 1.5, 0.35, "factor of a street's, of one's own place"
        ),
    )

    quadrature_error: ClassVar[float] = 1e-10  # smooth

    contact_m: float = 5.0
    contact_point_m: float = 3.0
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
    own_place: float = 3.0
    own_street: float = 1.5
    # What the middles mean: at four widths g is (1 + 4^2 / 5)^-3 = .013, where a Gaussian has 3e-4;
    # kappa 3 halves g at arccos(1 - ln 2 / 3) = 40 degrees, near the 45 between compass words.

    def log_g(self, term: GroundedRelation, direction_rad: Tensor | None) -> Tensor:
        """Return log g, shape (B, S), or (S,) for a relation without direction."""
        radial = self._log_radial(term)
        if direction_rad is None:
            return radial
        kappa = self._kappa(term)
        angular = kappa * (torch.cos(term.outward_rad - direction_rad[:, None]) - 1)
        return torch.where(term.has_direction, angular, _log_mean(kappa)) + radial

    def log_marginal(self, term: GroundedRelation, frame: FrameDistribution) -> Tensor:
        """Return log E[g] over the frame, in closed form, shape (S,)."""
        kappa = self._kappa(term)
        turned = term.outward_rad - term.offset_rad
        angular = log_expected_von_mises(turned, frame, kappa)
        return torch.where(term.has_direction, angular, _log_mean(kappa)) + self._log_radial(term)

    def _kappa(self, term: GroundedRelation) -> Any:
        return self.kappa_frame if term.needs_frame else self.kappa_compass

    def _log_radial(self, term: GroundedRelation) -> Tensor:
        bounded = log_bounds(term, self._width_m(term))
        if bounded is not None:
            return bounded
        width = stated_width_m(term, self.contact_m) or self._width_m(term)
        return log_student(term.off_street_m, width, self.tail)

    def _width_m(self, term: GroundedRelation) -> Any:
        is_point = term.form == "point" and not term.has_part
        contact_m = self.contact_point_m if is_point else self.contact_m
        widths = {
            "contact": (contact_m, self.contact_street_m),
            "proximity": (self.near_m, self.near_street_m),
            "between": (self.between_m, self.between_m),
            "across": (self.across_m, self.across_m),
            "directed": (self.directed_m, self.directed_street_m),
        }
        other, street = widths[term.width]
        if term.is_line and not term.has_part:
            return street * self.own_street if term.is_own_place else street
        stands_away = term.width in ("proximity", "directed", "across")
        return other * self.own_place if stands_away and term.is_own_place else other


def log_expected_von_mises(bearing_rad: Tensor, frame: FrameDistribution, kappa: Any) -> Tensor:
    """Return log E[exp(kappa (cos(bearing - psi) - 1))] over the front psi, in closed form.

    Parameters
    ----------
    bearing_rad
        Direction of each cell less the relation's offset, radians, shape (S,).
    frame
        Distribution of psi.
    kappa
        Sharpness, > 0; a float or a tensor without dimensions.

    Returns
    -------
    Tensor
        At most 0, shape (S,).

    Notes
    -----
    For a von Mises part of concentration c the expectation is I_0(R) / I_0(c) exp(-kappa) with
    R^2 = kappa^2 + c^2 + 2 kappa c cos x: the product of two von Mises shapes is one. It depends on
    the bearing alone, so on more than 8192 cells it is tabulated over 4096 bearings and
    interpolated by cubics, unless it is learnt: that moves a belief by less than 1e-9 in total
    variation up to a concentration of some hundreds.
    """
    if bearing_rad.numel() <= _TABULATED_FROM or _is_learnt(frame, kappa):
        return _log_expected(bearing_rad, frame, kappa)
    nodes = torch.arange(_NODES, dtype=torch.float64) * (2 * math.pi / _NODES)
    return _interpolated(_log_expected(nodes, frame, kappa), bearing_rad)


def _log_expected(bearing_rad: Tensor, frame: FrameDistribution, kappa: Any) -> Tensor:
    # Numbers that are learnt are tensors with a history, and no keys of a cache.
    rows_of = _rows.__wrapped__ if _is_learnt(frame, kappa) else _rows
    spread, points, lapse = rows_of(frame, kappa)
    rows = []
    if spread is not None:
        mean, squares, twice, level = spread
        # R is 0 only opposite a part with c = kappa, where the slope of a root would be infinite.
        length = torch.addcmul(squares, twice, torch.cos(bearing_rad - mean)).clamp_min(1e-16)
        length = length.sqrt()
        rows.append(_log_i0e(length) + length + level)
    if points is not None:
        mean, log_weight = points
        rows.append(kappa * (torch.cos(bearing_rad - mean) - 1) + log_weight)
    if lapse is not None:
        rows.append(lapse.expand(1, len(bearing_rad)))
    # Rounding may lift a sum of weights over one by 1e-16.
    return torch.logsumexp(torch.cat(rows), 0).clamp_max(0.0)


@lru_cache(maxsize=512)
def _rows(frame: FrameDistribution, kappa: Any) -> tuple[Any, Any, Any]:
    """Return what does not depend on the bearing, of the spread parts, the points and the lapse.

    Means (P, 1), kappa^2 + c^2 (P, 1), 2 kappa c (P, 1), log levels (P, 1); means and log weights
    of points; the log of lapse times the mean over directions.
    """
    sharpness = torch.as_tensor(kappa, dtype=torch.float64)
    parts = [part for part in frame.parts if not _is_point(part.kappa)]
    spread = points = lapse = None
    if parts:
        c = _column([part.kappa for part in parts])
        level = _column([part.weight for part in parts]).log() - _log_i0e(c) - c - sharpness
        mean = _column([part.mean_rad for part in parts])
        spread = mean, sharpness**2 + c**2, 2 * sharpness * c, level
    parts = [part for part in frame.parts if _is_point(part.kappa)]
    if parts:
        points = (
            _column([part.mean_rad for part in parts]),
            _column([part.weight for part in parts]).log(),
        )
    if frame.lapse:
        lapse = torch.as_tensor(frame.lapse, dtype=torch.float64).log() + _log_mean(kappa)
    return spread, points, lapse


def _interpolated(table: Tensor, angle_rad: Tensor) -> Tensor:
    """Return a periodic table at some angles: in each interval the cubic through four nodes."""
    before, after, beyond = table.roll(1), table.roll(-1), table.roll(-2)
    # Newton's form in t from the left node: c0 + t (c1 + t (c2 + t c3)).
    c2 = (before + after) / 2 - table
    c3 = (beyond - before) / 6 + (table - after) / 2
    c1 = after - table - c2 - c3
    place = angle_rad * (len(table) / (2 * math.pi))
    left = place.floor()
    t = place.sub_(left)
    at = left.remainder_(len(table)).to(torch.int32)
    result = c3.index_select(0, at)
    for c in (c2, c1, table):
        result = result.mul_(t).add_(c.index_select(0, at))
    return result


def _column(values: Sequence[Any]) -> Tensor:
    """Return numbers, some of which may be tensors, one row each: shape (P, 1) or (P, S)."""
    if not any(isinstance(value, Tensor) for value in values):
        return torch.tensor(values, dtype=torch.float64)[:, None]
    each = [torch.as_tensor(value, dtype=torch.float64).reshape(-1) for value in values]
    return torch.stack(torch.broadcast_tensors(*each))


def _is_learnt(frame: FrameDistribution, kappa: Any) -> bool:
    numbers = [kappa, frame.lapse]
    for part in frame.parts:
        numbers += [part.mean_rad, part.kappa, part.weight]
    return any(isinstance(number, Tensor) for number in numbers)


def _is_point(kappa: Any) -> bool:
    return math.isinf(kappa) if isinstance(kappa, float | int) else bool(torch.isinf(kappa).all())


def _log_mean(kappa: Any) -> Tensor:
    """Return the log of exp(kappa (cos x - 1)) averaged over directions."""
    return (
        _log_mean_of(kappa)
        if isinstance(kappa, float)
        else _log_i0e(torch.as_tensor(kappa, dtype=torch.float64))
    )


@lru_cache(maxsize=64)
def _log_mean_of(kappa: float) -> Tensor:
    return _log_i0e(torch.as_tensor(kappa, dtype=torch.float64))


def _log_i0e(x: Tensor) -> Tensor:
    logarithm: Tensor = torch.special.i0e(x).log()
    return logarithm


LIKELIHOODS.add("student-vonmises", StudentVonMisesLikelihood())
