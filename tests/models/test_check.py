"""Each check of `check_likelihood` catches the fault it is for, and says what is wrong."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import pytest
import torch

from sloop_ppl.errors import InputError
from sloop_ppl.models.check import check_likelihood
from sloop_ppl.models.likelihoods import Parameter, StudentVonMisesLikelihood

SOUND = StudentVonMisesLikelihood()


@dataclass(frozen=True)
class Faulty:
    """A sound likelihood with one thing done to what it returns."""

    fault: object

    def log_g(self, term, direction_rad):
        return self.fault(SOUND.log_g(term, direction_rad), term, direction_rad)


def plain(term):
    return -term.distance_m / 20


FAULTS = {
    "positive": (
        lambda log_g, term, a: log_g + 1,
        r"log_g of Faulty for relation 'on' of an area is 1 at its highest; expected at most 0",
    ),
    "square": (
        lambda log_g, term, a: log_g.reshape(*log_g.shape[:-1], 24, 24),
        r"has shape \(24, 24\); expected \(576,\), that is \(S cells,\)",
    ),
    "one direction only": (
        lambda log_g, term, a: log_g if a is None else log_g[0],
        r"'north' of an area has shape \(576,\); expected \(1, 576\), that is \(B directions, S ",
    ),
    "single precision": (
        lambda log_g, term, a: log_g.float(),
        r"has dtype torch.float32; expected torch.float64",
    ),
    "numpy": (
        lambda log_g, term, a: log_g.numpy(),
        r"is a ndarray; expected a torch.Tensor",
    ),
    "log of zero": (
        lambda log_g, term, a: torch.where(log_g > -2, log_g, -math.inf),
        r"is -inf at \d+ of 576 places; expected finite logs: give g a small floor",
    ),
    "not a number": (
        lambda log_g, term, a: log_g / term.distance_m * term.distance_m,
        r"is nan at \d+ of 576 places",
    ),
    "directions that mix": (
        lambda log_g, term, a: log_g if a is None else log_g.mean(0, keepdim=True) + 0 * log_g,
        r"relation 'front' of an area gives direction 0.30 rad another value alone than among 5;",
    ),
    "compass from the term": (
        lambda log_g, term, a: (
            log_g
            if a is None
            else plain(term)
            + torch.cos(term.bearing_rad - (term.compass_rad or a[:, None]))
            - 1
            + 0 * log_g
        ),
        r"Turning map and direction does not do so to log_g of Faulty for relation 'north' of an",
    ),
    "anticlockwise only": (
        lambda log_g, term, a: (
            log_g if a is None else plain(term) + torch.sin(term.bearing_rad - a[:, None]) - 1
        ),
        r"Mirroring map and direction does not do so to log_g of Faulty",
    ),
    "tables of the whole map": (
        lambda log_g, term, a: (
            log_g
            if a is not None
            else -torch.from_numpy(term.city.fields(term.ground).distance_m).reshape(-1) / 20
        ),
        r"'on' of an area at 5 of its cells .GroundedRelation.at. has shape .576,.; expected .5,.",
    ),
    "cells that mix": (
        lambda log_g, term, a: log_g - log_g.detach().max(),
        r"relation 'on' of an area gives some cells other values alone than among all; expected",
    ),
    "widths in cells": (
        lambda log_g, term, a: (
            log_g if a is not None else -((term.distance_m / term.city.grid.cell_m / 3) ** 2)
        ),
        r"Halving the cells moves .* of an? (area|line|point); expected at most 0.25:",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_named(fault):
    spoil, message = FAULTS[fault]
    with pytest.raises(InputError, match=message):
        check_likelihood(Faulty(spoil))


def test_what_has_no_log_g_is_no_likelihood():
    with pytest.raises(InputError, match=r"object has no method log_g\(term, direction_rad\)"):
        check_likelihood(object())


@dataclass(frozen=True)
class Learning:
    parameters: ClassVar = (Parameter("width_m", "m", 0.0, math.inf, 10.0, 0.7, "width"),)
    width_m: float = 10.0

    def log_g(self, term, direction_rad):
        flat = -((term.distance_m / self.width()) ** 2)
        return flat if direction_rad is None else flat.expand(len(direction_rad), -1)

    def width(self):
        return self.width_m


def test_a_sound_one_passes():
    check_likelihood(Learning())


class Detached(Learning):
    def width(self):
        return float(torch.as_tensor(self.width_m).detach())


class Rooted(Learning):
    def width(self):
        return 10 + 0 * torch.as_tensor(self.width_m - 10.0).sqrt()


class Nameless(Learning):
    parameters: ClassVar = (Parameter("reach_m", "m", 0.0, math.inf, 10.0, 0.7, "reach"),)


def test_a_parameter_that_nothing_depends_on_is_named():
    with pytest.raises(InputError, match="No gradient of Detached reaches parameter 'width_m'"):
        check_likelihood(Detached())


def test_a_gradient_that_is_not_finite_is_named():
    with pytest.raises(InputError, match="gradient of Rooted in 'width_m' is nan for relation 'on"):
        check_likelihood(Rooted())


def test_a_parameter_without_a_field_is_named():
    with pytest.raises(InputError, match="Nameless declares parameter 'reach_m' but has no such"):
        check_likelihood(Nameless())


def test_a_parameter_out_of_its_range_is_named():
    with pytest.raises(InputError, match="'width_m' is -1 m; expected more than 0 and less than"):
        check_likelihood(Learning(-1.0))


class Swapped(Learning):
    """Knows a marginal, of the wrong frame."""

    def log_g(self, term, direction_rad):
        return SOUND.log_g(term, direction_rad) + 0 * torch.as_tensor(self.width_m)

    def log_marginal(self, term, frame):
        return SOUND.log_marginal(term.as_relation("left"), frame)


def test_a_marginal_that_is_not_the_integral_is_named():
    Swapped.parameters = ()
    with pytest.raises(
        InputError,
        match=r"log_marginal of Swapped for relation 'front' of an area under a point is off by .* "
        r"from quadrature of log_g; correct it, or leave log_marginal out",
    ):
        check_likelihood(Swapped())
