"""What must hold of any belief, whatever is said."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sloop_ppl.inference import infer_description
from sloop_ppl.language import RELATIONS
from sloop_ppl.maps import CityMap, Grid, Landmark
from sloop_ppl.models import PRESETS
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

LISTENING = [name for name in PRESETS if name != "informed"]
words = st.sampled_from(sorted(RELATIONS))
coordinates = st.floats(-45, 45).map(lambda v: round(v, 2))


@st.composite
def relations(draw, city):
    grounds = st.sampled_from([m.id for m in city.landmarks])
    return tuple(
        relation(draw(words), draw(grounds), negated=draw(st.booleans()))
        for _ in range(draw(st.integers(1, 4)))
    )


CITY = house_and_street(symmetric_grid(21), house=(12.0, -7.0), street_y=30.0)


def belief(description, city=CITY, model="sloop-m4"):
    return infer_description(description, city, model)[0].belief(TARGET)


@pytest.mark.parametrize("model", LISTENING)
@settings(max_examples=25, deadline=None)
@given(spoken=relations(CITY))
def test_a_belief_is_finite_and_sums_to_one(model, spoken):
    got = belief(said(*spoken), model=model)
    assert np.isfinite(got).all()
    assert (got >= 0).all()
    assert got.sum() == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("model", LISTENING)
@settings(max_examples=15, deadline=None)
@given(spoken=relations(CITY), data=st.data())
def test_the_order_of_relations_is_irrelevant(model, spoken, data):
    shuffled = data.draw(st.permutations(spoken))
    np.testing.assert_allclose(
        belief(said(*spoken), model=model), belief(said(*shuffled), model=model), atol=1e-9
    )


@pytest.mark.parametrize("model", ["sloop", "sloop-m2", "sloop-m4", "bayes"])
@pytest.mark.parametrize(("word", "mirrored"), [("front", "behind"), ("north", "south")])
@settings(max_examples=15, deadline=None)
@given(x=coordinates)
def test_front_and_behind_mirror_each_other(model, word, mirrored, x):
    """A house on the axis whose street lies far north: what is in front lies as much behind."""
    city = house_and_street(symmetric_grid(21), house=(x, 0.0), street_y=50.0)
    np.testing.assert_allclose(
        belief(said(relation(word, "House")), city, model),
        belief(said(relation(mirrored, "House")), city, model)[::-1],
        atol=1e-7,  # the network that predicts the front counts in single precision
    )


@pytest.mark.parametrize("model", ["sloop", "sloop-m2", "sloop-m4", "bayes"])
@settings(max_examples=15, deadline=None)
@given(y=coordinates)
def test_left_and_right_mirror_each_other(model, y):
    city = house_and_street(symmetric_grid(21), house=(0.0, y), street_y=50.0)
    np.testing.assert_allclose(
        belief(said(relation("left", "House")), city, model),
        belief(said(relation("right", "House")), city, model)[:, ::-1],
        atol=1e-12,
    )


def _moved(city: CityMap, dx: float, dy: float) -> CityMap:
    from shapely.affinity import translate

    grid = city.grid
    return CityMap(
        city.name,
        Grid(grid.west_m + dx, grid.south_m + dy, grid.east_m + dx, grid.north_m + dy, 5.0),
        tuple(
            Landmark(m.id, m.kind, translate(m.geometry, dx, dy), m.name, width_m=m.width_m)
            for m in city.landmarks
        ),
    )


@settings(max_examples=20, deadline=None)
@given(spoken=relations(CITY), dx=st.integers(-400, 400), dy=st.integers(-400, 400))
def test_moving_the_map_moves_the_belief(spoken, dx, dy):
    np.testing.assert_allclose(
        belief(said(*spoken)), belief(said(*spoken), _moved(CITY, dx, dy)), atol=1e-9
    )


def _turned(city: CityMap) -> CityMap:
    """Turn the landmarks of a symmetric grid by 90 degrees anticlockwise."""
    from shapely.affinity import rotate

    return CityMap(
        city.name,
        city.grid,
        tuple(
            Landmark(m.id, m.kind, rotate(m.geometry, 90, origin=(0, 0)), m.name, width_m=m.width_m)
            for m in city.landmarks
        ),
    )


@settings(max_examples=20, deadline=None)
@given(words=st.lists(st.sampled_from(["front", "behind", "near", "at"]), min_size=1, max_size=3))
def test_turning_the_map_turns_the_belief(words):
    spoken = said(*(relation(word, "House") for word in words))
    np.testing.assert_allclose(
        np.rot90(belief(spoken), -1), belief(spoken, _turned(CITY)), atol=1e-9
    )


def test_one_relation_is_the_product_of_one():
    alone, _ = infer_description(said(relation("near", "House")), CITY, "sloop-m4")
    product, _ = infer_description(said(relation("near", "House")), CITY, "sloop")
    joint = alone.joint_component(TARGET).sel(component="product")
    np.testing.assert_allclose(joint / joint.sum(), product.belief(TARGET), atol=1e-12)


@pytest.mark.parametrize("model", ["sloop", "sloop-m2", "sloop-m4", "bayes"])
@pytest.mark.parametrize("word", ["behind", "near", "on", "northeast", "left"])
def test_halving_the_cell_keeps_the_belief(model, word):
    """The mass of each 10 m block moves by less than .02 in total variation."""
    from sloop_ppl.maps import load_map

    blocks = []
    for cell_m in (5.0, 2.5):
        city = load_map("cleveland", cell_m)
        got = belief(said(relation(word, "StoneBlock"), relation("near", "West6thSt")), city, model)
        side = round(10 / cell_m)
        south = got.shape[0] % side  # blocks are laid from the north-west, as the cells are
        got = np.pad(got, ((side - south if south else 0, 0), (0, -got.shape[1] % side)))
        blocks.append(got.reshape(got.shape[0] // side, side, -1, side).sum((1, 3)))
    assert blocks[0].shape == blocks[1].shape
    assert 0.5 * np.abs(blocks[0] - blocks[1]).sum() < 0.02
