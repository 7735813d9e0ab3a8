from __future__ import annotations

import math
from dataclasses import dataclass

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
    (part,) = FRAME_PREDICTORS["nearest-street"](term("front")).parts
    assert (part.mean_rad, part.kappa, part.weight) == (pytest.approx(math.pi / 2), math.inf, 1)


def test_a_street_faces_both_ways_across_itself():
    parts = FRAME_PREDICTORS["nearest-street"](term("front", "MainSt")).parts
    assert sorted(part.mean_rad for part in parts) == pytest.approx([-math.pi / 2, math.pi / 2])
    assert [part.weight for part in parts] == [0.5, 0.5]


def test_without_a_street_nothing_is_known():
    lonely = term("front", "Pole", point_city(GRID, Pole=(0.0, 0.0)))
    assert FRAME_PREDICTORS["nearest-street"](lonely) == FrameDistribution((), lapse=1.0)
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


@dataclass(frozen=True)
class Told:
    """A predictor that tells what it was given."""

    frame: FrameDistribution

    def __call__(self, term):
        return self.frame


TWO_HILLS = FrameDistribution((FramePart(0.4, 9.0, 0.6), FramePart(2.9, 25.0, 0.3)), lapse=0.1)


def test_a_point_is_the_likeliest_front_of_a_mixture():
    """A peak is about weight sqrt(kappa) high: .6 x 3 beats .3 x 5, and .4 x 7 beats .6 x 3."""
    (part,) = PredictedPoint(Told(TWO_HILLS))(term("front")).parts
    assert part.mean_rad == pytest.approx(0.4, abs=1e-3)
    assert part.kappa == math.inf
    sharper = FrameDistribution((FramePart(0.4, 9.0, 0.6), FramePart(2.9, 49.0, 0.4)))
    assert sharper.modes() == (pytest.approx(2.9, abs=1e-3),)


def test_equal_modes_are_all_named():
    both_ways = FrameDistribution((FramePart(0.3, 5.0, 0.5), FramePart(0.3 - math.pi, 5.0, 0.5)))
    assert sorted(both_ways.modes()) == pytest.approx([0.3 - math.pi, 0.3], abs=1e-4)


def test_parts_that_overlap_peak_between_their_means():
    frame = FrameDistribution((FramePart(-0.2, 3.0, 0.5), FramePart(0.2, 3.0, 0.5)))
    assert frame.modes() == (pytest.approx(0.0, abs=1e-4),)


def test_what_is_uniform_has_no_mode():
    assert FrameDistribution((), lapse=1.0).modes() == ()
    assert FrameDistribution((FramePart(1.0, 0.0, 1.0),)).modes() == ()


def test_a_spread_keeps_the_parts_of_a_prediction():
    prior = PredictedSpread(Told(TWO_HILLS), kappa=4.0, lapse=0.2)(term("behind"))
    assert [part.weight for part in prior.parts] == pytest.approx([0.48, 0.24])
    assert [part.kappa for part in prior.parts] == pytest.approx([36 / 13, 100 / 29])
    assert prior.lapse == pytest.approx(0.28)


def test_a_speaker_without_scatter_takes_the_prediction_as_it_is():
    prior = PredictedSpread(Told(TWO_HILLS), kappa=math.inf, lapse=0.0)(term("front"))
    assert prior.parts == TWO_HILLS.parts
    assert prior.lapse == pytest.approx(TWO_HILLS.lapse)


@pytest.mark.parametrize("count", [8, 24, 72])
def test_bins_hold_the_mass_between_their_borders(count):
    arcs = TWO_HILLS.binned(count)
    assert arcs.sum() == pytest.approx(1)
    half = math.pi / count
    fine = np.linspace(0.4 - half, 0.4 + half, 20_001)
    centred = FrameDistribution((FramePart(0.0, 9.0, 1.0),)).binned(count)
    inside = np.exp(FramePart(0.4, 9.0).log_density(fine)).mean() * 2 * half
    assert centred[0] == pytest.approx(inside, rel=2e-2)


def test_a_point_falls_into_the_bin_round_it():
    for angle in (0.0, 0.1, -0.1, 2 * math.pi, -2 * math.pi):
        assert FrameDistribution.points((angle,)).binned(24)[0] == 1
    assert FrameDistribution.points((math.pi, math.pi / 2)).binned(24)[[6, 12]] == pytest.approx(
        0.5
    )


def test_the_density_integrates_to_one():
    angles = np.linspace(-math.pi, math.pi, 4000, endpoint=False)
    assert TWO_HILLS.density(angles).mean() * 2 * math.pi == pytest.approx(1)


def test_modes_are_where_a_fine_search_finds_the_greatest_density():
    rng = np.random.default_rng(0)
    fine = np.linspace(-math.pi, math.pi, 72_000, endpoint=False)
    for _ in range(10):
        shares = rng.dirichlet(np.ones(6))
        parts = tuple(
            FramePart(float(rng.uniform(-3.1, 3.1)), float(10 ** rng.uniform(-0.5, 3)), float(w))
            for w in shares[:5]
        )
        frame = FrameDistribution(parts, lapse=float(1 - shares[:5].sum()))
        found = fine[frame.density(fine).argmax()]
        assert math.remainder(frame.modes()[0] - found, 2 * math.pi) == pytest.approx(0, abs=1e-3)
