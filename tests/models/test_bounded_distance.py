"""Bounds on a said distance: flat within, a Gaussian beyond, one number as before."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from sloop_ppl.inference import infer_description
from sloop_ppl.language import Distance, SpatialRelation
from sloop_ppl.models import LIKELIHOODS, preset
from sloop_ppl.models.grounded_relation import ground_relations
from tests.scenes import TARGET, point_city, said, symmetric_grid

CITY = point_city(symmetric_grid(41), Pole=(0.0, 0.0))
PLACES_M = (0.0, 20.0, 50.0, 60.0, 90.0)
"""Distances east of the pole, which stands in the middle of a cell, at which log g is read."""


def log_g(name, word="near", **distance):
    (term,) = ground_relations((SpatialRelation(TARGET, word, ("Pole",), **distance),), CITY)
    direction = term.directions(None)
    table = LIKELIHOODS[name].log_g(term, direction).reshape(-1, CITY.grid.size)[0]
    row = table.reshape(CITY.grid.shape)[20]
    return [float(row[20 + round(x / 5)]) for x in PLACES_M]


@pytest.mark.parametrize("name", ["gaussian-clipped", "student-vonmises", "attention-vector-sum"])
@pytest.mark.parametrize(
    ("distance", "expected"),
    [
        # near has a width of 15 m: greater than .2 x 50 m
        (Distance(0, 50), [0, 0, 0, -(10**2) / (2 * 15**2), -(40**2) / (2 * 15**2)]),
        # .4 x 50 m = 20 m is greater than that width
        (Distance(0, 50, 0.4), [0, 0, 0, -(10**2) / 800, -(40**2) / 800]),
        (Distance(50, math.inf), [-(50**2) / 450, -(30**2) / 450, 0, 0, 0]),
        (Distance(20, 60, 0.5), [-(20**2) / 450, 0, 0, 0, -(30**2) / (2 * 30**2)]),
        (Distance(0, math.inf), [0, 0, 0, 0, 0]),
    ],
)
def test_within_bounds_is_flat_and_beyond_a_gaussian_of_the_greater_width(name, distance, expected):
    np.testing.assert_allclose(log_g(name, distance=distance), expected, atol=1e-12)


def test_a_direction_multiplies_the_bounds():
    """Due east of the pole cos is 1; "east within 50 m" of a directed width of 20 m."""
    got = log_g("gaussian-clipped", "east", distance=Distance(0, 50))[1:]
    np.testing.assert_allclose(got, [0, 0, -(10**2) / 200, -(40**2) / 200], atol=1e-12)


def test_a_box_reaches_a_deviation_beyond_each_bound():
    floor = math.log(LIKELIHOODS["box"].floor)
    got = log_g("box", distance=Distance(50, 60, 0.3))  # 15 m and 18 m
    np.testing.assert_allclose(got, [floor, floor, 0, 0, floor], atol=1e-12)


def test_a_network_falls_off_with_the_distance_to_the_bounds():
    got = log_g("neural", distance=Distance(15, 60))
    assert got[1] == got[2] == got[3]
    assert got[0] < got[1]
    assert got[4] < got[1]


@pytest.mark.parametrize("name", sorted(set(LIKELIHOODS)))
def test_equal_bounds_are_the_ring_of_one_number_bit_for_bit(name):
    number, bounds = log_g(name, distance_m=25.0), log_g(name, distance=Distance(25, 25))
    assert number == bounds
    assert number == log_g(name, distance=Distance(25, 25, 0.05))


def test_a_vague_number_is_a_wider_ring():
    # a stone's throw: sigma .5 x 40 m in place of a quarter of it
    got = log_g("gaussian-clipped", distance=Distance(40, 40, 0.5))
    np.testing.assert_allclose(got, [-(d**2) / (2 * 20**2) for d in (40, 20, 10, 20, 50)])


def test_bounds_count_only_for_models_that_heed_a_distance():
    near = SpatialRelation(TARGET, "near", ("Pole",))
    within = replace(near, distance=Distance(40, 60))
    for name, heeds in (("bayes", True), ("sloop", False)):
        plain, _ = infer_description(said(near), CITY, name)
        bounded, _ = infer_description(said(within), CITY, name)
        assert np.array_equal(plain.belief(TARGET), bounded.belief(TARGET)) is not heeds
    best = np.hypot(*(np.array(bounded.mode(TARGET))))
    assert best < 5  # sloop still means the pole


def test_a_denied_bound_leaves_the_rest():
    """ "Not within 50 m": 1 - denial g / max g, so that 60 m is likelier than 20 m."""
    denied = SpatialRelation(TARGET, "near", ("Pole",), negated=True, distance=Distance(0, 50))
    belief = infer_description(said(denied), CITY, "bayes")[0].belief(TARGET)[20]
    assert belief[20] == belief[24] < belief[32] < belief[38]


def test_widths_that_are_learnt_keep_their_gradient():
    width = torch.tensor(15.0, dtype=torch.float64, requires_grad=True)
    (term,) = ground_relations(
        (SpatialRelation(TARGET, "near", ("Pole",), distance=Distance(20, math.inf)),), CITY
    )
    table = replace(LIKELIHOODS["gaussian-clipped"], near_m=width).log_g(term, None)
    table.sum().backward()
    assert torch.isfinite(width.grad)
    assert width.grad > 0


def test_bayes_puts_at_least_80_m_outside():
    far = SpatialRelation(TARGET, "near", ("Pole",), distance=Distance(80, math.inf))
    posterior, _ = infer_description(said(far), CITY, replace(preset("bayes"), lapse=0.0))
    apart = np.hypot(CITY.grid.x_m[None, :], CITY.grid.y_m[:, None])
    belief = posterior.belief(TARGET)
    assert belief[apart >= 80].sum() > 0.7
    np.testing.assert_allclose(belief[apart >= 80], belief[0, 0], rtol=1e-12)


def test_bounds_are_kept_in_files(tmp_path):
    from sloop_ppl.inference import Posterior
    from sloop_ppl.maps import load_map

    city = load_map("cleveland", cell_m=20)
    far = SpatialRelation(TARGET, "near", ("Ivy",), distance=Distance(50, math.inf, 0.3))
    posterior, _ = infer_description(said(far), city, "bayes")
    posterior.save(tmp_path / "p.nc")
    again = Posterior.load(tmp_path / "p.nc")
    assert again.relations(TARGET) == (far,)
    np.testing.assert_array_equal(again.belief(TARGET), posterior.belief(TARGET))
