"""Language in pomdp-py's own terms equals inference."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pomdp_py
import pytest

from sloop_ppl.bridge.pomdp import LanguageObservationModel, Utterance, as_histogram
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference import infer_description
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(9), street_y=18.0)
BEHIND, NEAR = said(relation("behind", "House")), said(relation("near", "MainSt"))
BOTH = said(relation("behind", "House"), relation("near", "MainSt"))
PRIOR = np.random.default_rng(3).uniform(0.01, 1, CITY.grid.shape)


class Place(pomdp_py.ObjectState):
    def __init__(self, row, col):
        super().__init__("target", {"pose": (row, col)})


def place_of(state):
    return state["pose"]


class Nothing(pomdp_py.Action):
    pass


def updated(histogram, observation, model):
    return pomdp_py.update_histogram_belief(
        histogram, Nothing(), observation, model, None, static_transition=True
    )


@pytest.mark.parametrize("name", ["keyword", "sloop", "sloop-m2", "sloop-m4", "bayes"])
@pytest.mark.parametrize("description", [BEHIND, BOTH])
@pytest.mark.parametrize("wrap", [Utterance, lambda d: d])
def test_a_histogram_update_is_inference(name, description, wrap):
    model = LanguageObservationModel(CITY, TARGET, place_of, name)
    got = updated(as_histogram(PRIOR, Place), wrap(description), model)
    expected, _ = infer_description(description, CITY, name, prior=PRIOR)
    for (row, col), p in np.ndenumerate(expected.belief(TARGET)):
        assert got[Place(row, col)] == pytest.approx(p, abs=1e-12)


def test_two_updates_are_two_descriptions():
    model = LanguageObservationModel(CITY, TARGET, place_of)
    got = updated(updated(as_histogram(PRIOR, Place), BEHIND, model), NEAR, model)
    expected = infer_description(BEHIND, CITY, prior=PRIOR)[0].update(NEAR).belief(TARGET)
    for (row, col), p in np.ndenumerate(expected):
        assert got[Place(row, col)] == pytest.approx(p, abs=1e-12)


def test_nothing_said_changes_nothing():
    model = LanguageObservationModel(CITY, TARGET, place_of)
    before = as_histogram(PRIOR, Place)
    after = updated(before, Utterance(None), model)
    assert all(after[s] == pytest.approx(before[s], abs=1e-15) for s in before)


def test_samples_follow_the_probabilities():
    model = LanguageObservationModel(CITY, TARGET, place_of, utterances=(BEHIND, NEAR),
                                     rng=np.random.default_rng(0))  # fmt: skip
    state, n = Place(6, 4), 2000
    weights = np.array([model.probability(d, state, None) for d in (BEHIND, NEAR)])
    p = weights[0] / weights.sum()
    assert 0.02 < p < 0.98
    share = Counter(model.sample(state, None) for _ in range(n))[BEHIND] / n
    assert abs(share - p) < 4 * np.sqrt(p * (1 - p) / n)
    assert model.get_distribution(state, None)[BEHIND] == pytest.approx(p)
    assert model.argmax(state, None) == (BEHIND if p > 0.5 else NEAR)


def test_cells_with_one_state_add_up_and_others_are_left_out():
    halves = as_histogram(np.array([[1.0, 2.0], [3.0, 2.0]]), lambda row, col: col)
    assert halves[0] == pytest.approx(0.5)
    south = as_histogram(np.ones((2, 3)), lambda row, col: None if row else col)
    assert sorted(south) == [0, 1, 2]
    assert south[1] == pytest.approx(1 / 3)
    fence = as_histogram(np.ones((2, 3)), Place, among=lambda row, col: col != 1)
    assert len(list(fence)) == 4


def test_mistakes_are_told():
    with pytest.raises(InputError, match="No state of the domain has a positive probability"):
        as_histogram(np.ones((2, 2)), lambda row, col: None)
    with pytest.raises(InputError, match=r"expected a table \(H, W\)"):
        as_histogram(np.array([1.0, -1.0]), Place)
    with pytest.raises(UnknownName, match="Target 'Cat' is unknown"):
        LanguageObservationModel(CITY, "Cat", place_of).probability(NEAR, Place(0, 0), None)
    with pytest.raises(InputError, match="Nothing can be drawn"):
        LanguageObservationModel(CITY, TARGET, place_of).sample(Place(0, 0), None)


def test_a_table_of_xarray_is_read_by_its_coordinates():
    import xarray

    weights = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]])
    coords = {"y": [-5.0, 0.0, 5.0], "x": [-5.0, 0.0, 5.0]}
    table = xarray.DataArray(weights, dims=("y", "x"), coords=coords)
    wanted = as_histogram(weights, lambda row, col: (row, col))
    for turned in (table.sortby("y", ascending=False), table.transpose("x", "y")):
        assert as_histogram(turned, lambda row, col: (row, col)) == wanted
    wide = xarray.concat([table, table.assign_coords(y=table.y + 20.0)], "y")
    with pytest.raises(InputError, match="lacks cells"):
        as_histogram(wide, lambda row, col: (row, col))
