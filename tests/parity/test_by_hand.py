"""Beliefs worked out on paper."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sloop_ppl.inference import infer_description
from sloop_ppl.models import preset
from tests.scenes import TARGET, house_and_street, point_city, relation, said, symmetric_grid


def belief(city, description, model, **options):
    posterior, _ = infer_description(description, city, model, **options)
    return posterior.belief(TARGET)


def test_near_one_point_on_a_5_by_5_map():
    """exp(-d^2 / 2 15^2) around the middle cell, cells 5 m apart, then the published cut."""
    city = point_city(symmetric_grid(), Pole=(0.0, 0.0))
    got = belief(city, said(relation("near", "Pole")), "sloop")
    # Squared distances in cells: middle 0, edges 1, corners 2, two away 4, knight 5, far 8.
    weight = {d: math.exp(-d / 18) for d in (0, 1, 2, 4, 5, 8)}
    count = {0: 1, 1: 4, 2: 4, 4: 4, 5: 8, 8: 4}
    total = sum(weight[d] * n for d, n in count.items())
    p = {d: weight[d] / total for d in weight}
    kept = {d for d in p if p[d] >= 1 / 25}
    # On paper: 1 + 4 x .946 + 4 x .895 + 4 x .801 + 8 x .757 + 4 x .641 = 20.2, so cells two away
    # (.0397) fall below uniform (.04) and the corners of the middle (.0443) do not.
    assert kept == {0, 1, 2}
    mass = sum(p[d] * count[d] for d in kept)
    assert got[2, 2] == pytest.approx(p[0] / mass, rel=1e-9)
    assert got[3, 3] == pytest.approx(p[2] / mass, rel=1e-9)
    assert got[2, 4] == pytest.approx(1e-12 / mass, rel=1e-6)


def test_at_and_between_are_products_of_their_grounds():
    city = point_city(symmetric_grid(), A=(-5.0, 0.0), B=(5.0, 0.0))
    got = belief(city, said(relation("at", "A", "B")), "sloop")
    # exp(-(dA^2 + dB^2) / 2 5^2) with distances in cells: 0 + 4 on A, 1 + 1 in the middle.
    assert got[2, 1] / got[2, 2] == pytest.approx(math.exp(-(0 + 4) / 2) / math.exp(-(1 + 1) / 2))


def test_east_of_a_point_is_a_cosine_times_a_gaussian():
    city = point_city(symmetric_grid(9), Pole=(0.0, 0.0))
    got = belief(city, said(relation("east", "Pole")), preset("sloop", "paper"))
    east, northeast = got[4, 6], got[6, 6]
    # A point has no extent, so the width is 5 m; 10 m east against 10 m east and 10 m north.
    assert northeast / east == pytest.approx(math.cos(math.pi / 4) * math.exp(-100 / 50), rel=1e-6)


def test_keyword_is_one_on_the_ground_and_one_over_the_cells_elsewhere():
    city = point_city(symmetric_grid(), A=(-10.0, -10.0), B=(10.0, 10.0))
    got = belief(city, said(relation("near", "A"), relation("front", "B")), "keyword")
    total = 2 + 23 / 25
    assert got[0, 0] == pytest.approx(1 / total)
    assert got[4, 4] == pytest.approx(1 / total)
    assert got[2, 2] == pytest.approx(1 / 25 / total)


def test_informed_is_a_gaussian_of_25_m_around_the_truth():
    city = point_city(symmetric_grid(11), Pole=(0.0, 0.0))
    got = belief(city, said(relation("near", "Pole")), "informed", truth={TARGET: (5.0, 0.0)})
    assert np.unravel_index(got.argmax(), got.shape) == (5, 6)
    assert got[5, 1] / got[5, 6] == pytest.approx(math.exp(-(25**2) / (2 * 25**2)))


def test_two_component_mixture_by_hand():
    city = point_city(symmetric_grid(), Pole=(0.0, 0.0), Post=(10.0, 0.0))
    what = said(relation("at", "Pole"), relation("at", "Post"))
    product = belief(city, what, "sloop")
    d = {
        ground: np.hypot(city.grid.x_m[None, :] - city.centroid(ground)[0], city.grid.y_m[:, None])
        for ground in ("Pole", "Post")
    }
    near = [np.exp(-(x**2) / (2 * 15**2)) for x in d.values()]
    near = sum(n / n.sum() for n in near) / 2
    expected = 0.8 * product + 0.2 * near
    np.testing.assert_allclose(belief(city, what, "sloop-m2"), expected, rtol=1e-9, atol=1e-15)


def test_four_component_weights_without_and_with_a_frame_word():
    city = house_and_street(symmetric_grid(21))
    framed, _ = infer_description(said(relation("front", "House")), city, "sloop-m4")
    # Nothing is left without the frame word, so that component is skipped: .6 : .1 : .05.
    assert framed.component(TARGET) == pytest.approx(
        {"product": 0.8, "no-frame": 0.0, "at": 0.1 / 0.75, "near": 0.05 / 0.75}
    )
    compass, _ = infer_description(said(relation("north", "House")), city, "sloop-m4")
    assert compass.component(TARGET) == pytest.approx(
        {"product": 0.6, "no-frame": 0.25, "at": 0.1, "near": 0.05}
    )


def test_the_front_of_a_house_faces_the_nearest_street():
    city = house_and_street(symmetric_grid(21), street_y=40.0)
    front = belief(city, said(relation("front", "House")), "sloop")
    behind = belief(city, said(relation("behind", "House")), "sloop")
    assert front[11:].sum() > 0.95
    assert behind[:10].sum() > 0.95


def test_left_and_right_are_those_of_the_map():
    city = house_and_street(symmetric_grid(21), street_y=-40.0)
    assert belief(city, said(relation("right", "House")), "sloop")[:, 11:].sum() > 0.95
    assert belief(city, said(relation("left", "House")), "sloop")[:, :10].sum() > 0.95


def test_both_sides_of_a_street_are_in_front_of_it():
    city = house_and_street(symmetric_grid(21), street_y=0.0)
    front = belief(city, said(relation("front", "MainSt")), "sloop")
    np.testing.assert_allclose(front, front[::-1], atol=1e-12)
    np.testing.assert_allclose(
        front, belief(city, said(relation("behind", "MainSt")), "sloop"), atol=1e-12
    )


def test_the_papers_text_cannot_tell_front_from_behind():
    city = house_and_street(symmetric_grid(21))
    paper = preset("sloop-m4", "paper")
    np.testing.assert_allclose(
        belief(city, said(relation("front", "House")), paper),
        belief(city, said(relation("behind", "House")), paper),
        rtol=1e-9,
    )
    assert {c.name: c.weight for c in paper.components} == {
        "product": 0.6,
        "no-frame": 0.25,
        "at": 0.05,
        "near": 0.1,
    }
