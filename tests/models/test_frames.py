from __future__ import annotations

import math

import numpy as np
import pytest

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import CityMap
from sloop_ppl.models import (
    FRAME_PREDICTORS,
    FrameDistribution,
    FramePart,
    PredictedPoint,
    PredictedSpread,
    ground_relations,
)
from tests.scenes import house_and_street, point_city, relation, symmetric_grid

GRID = symmetric_grid(21)


def term(word, ground="House", city=None):
    city = city or house_and_street(GRID, street_y=30.0)
    return ground_relations((relation(word, ground),), city)[0]


def test_a_house_faces_its_street():
    (front,) = FRAME_PREDICTORS["nearest-street"](term("front"))
    assert front == pytest.approx(math.pi / 2)


def test_a_street_faces_both_ways_across_itself():
    fronts = sorted(FRAME_PREDICTORS["nearest-street"](term("front", "MainSt")))
    assert fronts == pytest.approx([-math.pi / 2, math.pi / 2])


def test_without_a_street_nothing_is_known():
    lonely = term("front", "Pole", point_city(GRID, Pole=(0.0, 0.0)))
    assert FRAME_PREDICTORS["nearest-street"](lonely) == ()
    assert PredictedPoint()(lonely) == FrameDistribution((), lapse=1.0)
    assert PredictedSpread()(lonely) == FrameDistribution((), lapse=1.0)


def test_left_and_right_face_north_when_they_are_the_maps():
    (part,) = PredictedPoint()(term("left")).parts
    assert (part.mean_rad, part.kappa) == (math.pi / 2, math.inf)


def test_a_spread_shares_left_and_right_between_map_and_ground():
    city = house_and_street(GRID, street_y=-30.0)
    prior = PredictedSpread(kappa=3.0, lapse=0.25, absolute=0.5)(term("left", city=city))
    absolute, relative = prior.parts
    assert (absolute.mean_rad, absolute.weight) == (pytest.approx(math.pi / 2), 0.5)
    assert (relative.mean_rad, relative.weight) == (pytest.approx(-math.pi / 2), 0.375)
    assert prior.lapse == pytest.approx(0.125)


def test_weights_must_sum_to_one():
    with pytest.raises(InputError, match=r"sum to 0.7; expected 1"):
        FrameDistribution((FramePart(0.0, 2.0, 0.5),), lapse=0.2)


def test_a_von_mises_density_integrates_to_one():
    angles = np.linspace(-math.pi, math.pi, 100_001)[:-1]
    for kappa in (0.0, 1.0, 30.0, 2000.0):
        density = np.exp(FramePart(1.0, kappa).log_density(angles))
        assert density.mean() * 2 * math.pi == pytest.approx(1, abs=1e-6)


def test_a_point_has_no_density():
    with pytest.raises(ValueError, match="A point has no density"):
        FramePart(0.0, math.inf).log_density(np.zeros(1))


def test_a_ground_must_be_on_the_map():
    city = CityMap("empty", GRID, ())
    with pytest.raises(UnknownName, match="Landmark of map empty 'Barn' is unknown"):
        ground_relations((relation("near", "Barn"),), city)
