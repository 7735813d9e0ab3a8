"""Questions to a posterior: joint tables, regions, draws, influences."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference import hpd_places, infer_description, probability_in
from sloop_ppl.inference.influence import bits_between
from tests.mixture import MIXTURE
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(21), house=(12.0, -7.0), street_y=30.0)
BEHIND = said(relation("behind", "House"))
BOTH = said(relation("behind", "House"), relation("near", "MainSt"))
GRID = CITY.grid


def posterior(description=BOTH, model=MIXTURE, **options):
    return infer_description(description, CITY, model, **options)[0]


def half_plane(side: float):
    west, south, _, north = GRID.cells_extent_m
    return shapely.box(west, south, side, north)


def test_components_by_cell_sum_to_the_belief_and_to_the_components():
    post = posterior().update(said(relation("left", "House")))
    for which in (0, 1, -1):
        joint = post.joint_component(TARGET, which)
        np.testing.assert_allclose(joint.sum("component"), post.belief(TARGET), atol=1e-15)
        told = dict(zip(joint["component"].values, joint.sum(("y", "x")).values, strict=True))
        assert told == pytest.approx(post.component(TARGET, which))
        share = post.responsibilities(TARGET, which)
        np.testing.assert_allclose(share.sum("component"), 1)
        np.testing.assert_allclose(share * post.belief(TARGET), joint, atol=1e-15)


def test_responsibilities_tell_where_a_component_matters():
    share = posterior(BEHIND).responsibilities(TARGET).sel(component="product")
    south, north = (share.sel(x=12.0, y=y, method="nearest") for y in (-17.0, 3.0))
    assert float(south) > float(north) + 0.1  # the house faces north


def test_responsibilities_of_an_excluded_cell_are_unknown():
    prior = np.ones(GRID.shape)
    prior[0] = 0
    share = posterior(prior=prior).responsibilities(TARGET)
    assert np.isnan(share[:, 0]).all()
    assert np.isfinite(share[:, 1:]).all()


@pytest.mark.parametrize("ask", ["joint_component", "responsibilities"])
def test_a_mixture_that_is_not_there(ask):
    silent = said(relation("near", "House"), targets=(TARGET, "RedBike"))
    post = posterior(silent)
    with pytest.raises(InputError, match="Nothing was said of 'RedBike', so it has no mixture"):
        getattr(post, ask)("RedBike")
    with pytest.raises(InputError, match="Description 1 of 'RedCar' does not exist; expected 0"):
        getattr(post, ask)(TARGET, 1)
    with pytest.raises(UnknownName, match="Target 'Bus' is unknown"):
        getattr(post, ask)("Bus")


def test_a_cell_counts_by_the_share_of_its_area():
    belief = np.zeros(GRID.shape)
    belief[10, 10] = 1.0  # about the origin, 5 m wide
    quarter = shapely.box(0, 0, 50, 50)
    assert probability_in(belief, GRID, quarter) == pytest.approx(0.25)
    far = shapely.box(500, 500, 600, 600)
    assert probability_in(belief, GRID, far) == 0
    ring = shapely.box(-40, -40, 40, 40) - shapely.box(-10, -10, 10, 10)
    assert probability_in(belief, GRID, ring) == 0
    assert probability_in(belief, GRID, shapely.MultiPolygon([quarter, far])) > 0.2


@settings(max_examples=25, deadline=None)
@given(st.floats(-52, 52))
def test_the_two_sides_of_a_line_hold_everything(side):
    belief = posterior().belief(TARGET)
    west, south, east, north = GRID.cells_extent_m
    left, right = shapely.box(west, south, side, north), shapely.box(side, south, east, north)
    held = sum(probability_in(belief, GRID, half) for half in (left, right))
    assert held == pytest.approx(1)


@pytest.mark.parametrize(
    ("area", "message"),
    [
        (shapely.Point(0, 0), ("An area is a Point; expected a shapely Polygon or MultiPolygon in "
         "metres from the map's centre")),
        ([(0, 0), (1, 1)], ("An area is a list; expected a shapely Polygon or MultiPolygon in "
         "metres from the map's centre")),
        (shapely.Polygon(), "An area is empty; expected a polygon with an inside"),
        (shapely.Polygon([(0, 0), (9, 9), (9, 0), (0, 9)]), ("An area is not valid "
         "(Self-intersection[4.5 4.5]); mend it with shapely.make_valid")),
    ],
)  # fmt: skip
def test_an_area_that_is_none(area, message):
    with pytest.raises(InputError) as caught:
        posterior().probability_in(TARGET, area)
    assert str(caught.value) == message


def test_expected_distance_of_a_sure_belief():
    prior = np.zeros(GRID.shape)
    prior[GRID.cell_at(20.0, 0.0)] = 1
    x, y = posterior(prior=prior).mode(TARGET)
    told = posterior(prior=prior).expected_distance(TARGET, (x - 3.0, y + 4.0))
    assert told == pytest.approx(5)
    with pytest.raises(InputError, match="expected finite x and y in metres"):
        posterior().expected_distance(TARGET, (math.nan, 0.0))


def test_connected_places_of_a_belief():
    belief = np.zeros(GRID.shape)
    belief[2, 2], belief[3, 3], belief[15, 4] = 0.2, 0.1, 0.7
    first, second = hpd_places(belief, GRID, 0.99)
    assert (first.p, first.cells) == (pytest.approx(0.7), 1)
    assert (second.p, second.cells) == (pytest.approx(0.3), 2)
    assert second.mode_m == pytest.approx(GRID.centre_of(2, 2))


def test_influence_is_the_divergence_from_the_belief_without():
    post = posterior()
    behind, near = post.influence(TARGET)
    assert (behind.relation.relation, near.relation.relation) == ("behind", "near")
    only_near = posterior(said(relation("near", "MainSt"))).belief(TARGET)
    np.testing.assert_allclose(behind.without, only_near, atol=1e-12)
    assert behind.bits == pytest.approx(bits_between(post.belief(TARGET), only_near))
    assert behind.bits > 0.1


def test_influence_of_the_only_relation_is_all_that_was_gained():
    (only,) = posterior(BEHIND).influence(TARGET)
    np.testing.assert_allclose(only.without, 1 / GRID.size)
    entropy = posterior(BEHIND).entropy(TARGET)
    assert only.bits == pytest.approx((math.log(GRID.size) - entropy) / math.log(2))


def test_influence_keeps_prior_sensing_and_other_descriptions():
    prior = np.random.default_rng(3).uniform(0.5, 1, GRID.shape)
    unseen = np.zeros(GRID.shape)
    unseen[:8] = -3.0
    later = said(relation("left", "House"))
    post = posterior(BEHIND, prior=prior).update(later).condition({TARGET: unseen})
    behind, left = post.influence(TARGET)
    with_prior = posterior(later, prior=prior).condition({TARGET: unseen})
    np.testing.assert_allclose(behind.without, with_prior.belief(TARGET), atol=1e-12)
    first = posterior(BEHIND, prior=prior).condition({TARGET: unseen})
    np.testing.assert_allclose(left.without, first.belief(TARGET), atol=1e-12)


def test_a_phrase_that_is_said_twice_loses_one_of_the_two():
    twice = said(relation("near", "MainSt"), relation("near", "MainSt"))
    once = posterior(said(relation("near", "MainSt"))).belief(TARGET)
    for influence in posterior(twice).influence(TARGET):
        np.testing.assert_allclose(influence.without, once, atol=1e-12)


def test_models_that_do_not_listen_are_not_influenced():
    post = posterior(BOTH, "informed", truth={TARGET: (0.0, 0.0)})
    assert [influence.bits for influence in post.influence(TARGET)] == [0.0, 0.0]


def test_draws_follow_the_joint_posterior():
    """Each frequency lies within 5 standard errors: a false alarm once in a million runs."""
    post, n = posterior(said(relation("behind", "House"))), 20_000
    draws = post.draws(TARGET, n, rng=np.random.default_rng(5))

    def agree(drawn, p):
        assert abs(float(drawn) - p) < 5 * math.sqrt(p * (1 - p) / n)

    agree((draws["x"] < 12).mean(), float(post.belief(TARGET)[:, GRID.x_m < 12].sum()))
    agree((draws["component"] == "product").mean(), post.component(TARGET)["product"])
    fine = post.joint_frame(TARGET, bins=360)
    south = fine["y"] < -10
    northward = np.cos(fine["angle"] - np.pi / 2) > np.cos(np.radians(30.5))
    facing = np.cos(draws["front"][:, 0] - np.pi / 2) > np.cos(np.radians(30.5))
    agree(facing.mean(), float(fine.where(northward, 0).sum()))
    both = float(fine.where(northward & south, 0).sum())
    agree((facing & (draws["y"] < -10)).mean(), both)


def test_draws_of_several_descriptions():
    post = posterior(BEHIND).update(said(relation("left", "House")))
    draws = post.draws(TARGET, 50, rng=np.random.default_rng(5))
    assert dict(draws.sizes) == {"draw": 50, "description": 2, "frame": 2}
    assert list(draws["relation"].values) == ["behind", "left"]
    again = post.draws(TARGET, 50, rng=np.random.default_rng(5))
    assert draws.identical(again)
    with pytest.raises(InputError, match="n is 0; expected at least one draw"):
        post.draws(TARGET, 0, rng=np.random.default_rng(5))


def test_a_model_that_was_told_the_truth_has_tables_of_phrases():
    """It listens to none of them; what they say by themselves can be asked all the same."""
    told = posterior(BOTH, "informed", truth={TARGET: (0.0, 0.0)})
    deaf = posterior(BOTH, "sloop")
    for table, expected in zip(told.phrase_tables(TARGET), deaf.phrase_tables(TARGET), strict=True):
        np.testing.assert_allclose(table, expected, atol=1e-12)


def test_draws_of_a_target_of_which_nothing_was_said():
    silent = said(relation("near", "House"), targets=(TARGET, "RedBike"))
    draws = posterior(silent).draws("RedBike", 10, rng=np.random.default_rng(1))
    assert dict(draws.sizes) == {"draw": 10, "description": 0, "frame": 0}
