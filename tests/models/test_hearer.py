"""Who listens as a ground: a point, on the map or off it, whose front no one knows."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sloop_ppl.errors import DescriptionError
from sloop_ppl.inference import infer_description
from sloop_ppl.language import HEARER, Description, SpatialRelation, TargetObject
from sloop_ppl.models import LIKELIHOODS, preset
from sloop_ppl.models.grounded_relation import ground_relations, with_hearer
from tests.scenes import TARGET, house_and_street, point_city, symmetric_grid

CITY = point_city(symmetric_grid(21), Pole=(0.0, 0.0))


def told(*words, hearer=(0.0, 0.0), grounds=(HEARER,)):
    relations = tuple(SpatialRelation(TARGET, word, grounds) for word in words)
    return Description("", "", (TargetObject(TARGET),), relations, hearer=hearer)


def grounded(word, hearer):
    terms = ground_relations((SpatialRelation(TARGET, word, (HEARER,)),), CITY)
    return with_hearer(terms, hearer)[0]


@pytest.mark.parametrize("place", [(3.0, -12.0), (-200.0, 90.0)])
def test_distance_and_bearing_are_those_of_the_point(place):
    term = grounded("near", place)
    east = CITY.grid.x_m[None, :] - place[0]
    north = CITY.grid.y_m[:, None] - place[1]
    np.testing.assert_allclose(term.distance_m.reshape(21, 21), np.hypot(east, north))
    np.testing.assert_allclose(term.bearing_rad.reshape(21, 21), np.arctan2(north, east))
    np.testing.assert_array_equal(term.nearest_bearing_rad, term.bearing_rad)
    assert int(term.on_ground.sum()) == (place == (3.0, -12.0))
    assert (term.form, term.kind, term.is_line) == ("point", "point", False)


@pytest.mark.parametrize("name", sorted(set(LIKELIHOODS)))
@pytest.mark.parametrize("word", ["near", "at", "northeast", "between", "across", "along"])
def test_every_likelihood_reads_a_hearer_off_the_map(name, word):
    term = grounded(word, (400.0, 0.0))
    table = LIKELIHOODS[name].log_g(term, term.directions(None))
    assert np.isfinite(table.numpy()).all()
    assert float(table.max()) <= 0


@pytest.mark.parametrize("model", ["bayes", "sloop", "sloop-m4", "keyword", "uniform"])
def test_where_the_pole_stands_the_hearer_means_what_the_pole_does(model):
    for word in ("near", "at", "west"):
        got = infer_description(told(word), CITY, model)[0].belief(TARGET)
        pole = infer_description(told(word, grounds=("Pole",)), CITY, model)[0].belief(TARGET)
        if model == "bayes" and word == "west":  # the pole's distance counts from its cell
            np.testing.assert_allclose(got, pole, atol=1e-6)
        else:
            np.testing.assert_allclose(got, pole, atol=1e-12)


def test_east_of_a_hearer_west_of_the_map_is_nearest_to_the_hearer():
    belief = infer_description(told("east", hearer=(-60.0, 20.0)), CITY, "bayes")[0].belief(TARGET)
    row, col = np.unravel_index(belief.argmax(), belief.shape)
    assert (row, col) == (CITY.grid.cell_at(0, 20)[0], 0)


def test_a_frame_word_of_a_hearer_turns_all_ways_alike():
    for model in ("bayes", "sloop", "sloop-m2"):
        for word in ("front", "behind", "left", "right"):
            belief = infer_description(told(word), CITY, model)[0].belief(TARGET)
            np.testing.assert_allclose(belief, belief.T, atol=1e-12)
            np.testing.assert_allclose(belief, belief[::-1], atol=1e-12)
    posterior, _ = infer_description(told("left"), CITY, "bayes")
    np.testing.assert_allclose(posterior.frame(TARGET)["prior"].values, 1 / 72, atol=1e-12)


def test_the_hearers_heading_can_be_set():
    posterior, _ = infer_description(
        told("left"), CITY, "bayes", do={"frame": {HEARER: 0.0}}
    )  # who faces east has north on the left
    x, y = posterior.expected(TARGET)
    assert y > 3
    assert abs(x) < 1e-9


def test_between_a_house_and_the_hearer_is_a_region():
    town = house_and_street(symmetric_grid(21), house=(-40.0, 0.0), street_y=50.0)
    for hearer in ((40.0, 0.0), (90.0, 0.0)):
        said = told("between", hearer=hearer, grounds=("House", HEARER))
        belief = infer_description(said, town, "bayes")[0].belief(TARGET)
        middle = belief[10, town.grid.cell_at(0, 0)[1]]
        assert middle > 2 * belief[10, 0]
        assert middle > 2 * belief[16, 10]


@pytest.mark.parametrize("model", ["bayes", "sloop"])
def test_without_a_hearer_the_error_names_the_field(model):
    with pytest.raises(DescriptionError) as caught:
        infer_description(told("north", hearer=None), CITY, model)
    assert str(caught.value) == (
        "Relation 'north' of 'RedCar' is to who listens, and the field 'hearer' of the description "
        "is not set; expected a place in metres: hearer=(x_m, y_m) in Python, --hearer X,Y, or the "
        "field 'hearer' of a line"
    )


@pytest.mark.parametrize("place", [(math.nan, 0.0), (1.0,), "here", (math.inf, 0.0), 3])
def test_a_hearer_that_is_no_place_is_refused(place):
    with pytest.raises(DescriptionError, match="expected two finite numbers"):
        told("near", hearer=place)


def test_speakers_read_a_hearer_too():
    from sloop_ppl.models import speaker_of

    belief = infer_description(told("north"), CITY, speaker_of(preset("bayes")))[0].belief(TARGET)
    assert belief[11:].sum() > 0.55


def test_posteriors_with_a_hearer_are_kept(tmp_path):
    from sloop_ppl.inference import Posterior
    from sloop_ppl.maps import load_map

    city = load_map("cleveland", cell_m=20)
    posterior, _ = infer_description(told("north", "near", hearer=(5.0, -70.0)), city, "bayes")
    posterior.save(tmp_path / "p.nc")
    again = Posterior.load(tmp_path / "p.nc")
    assert again.descriptions[0].hearer == (5.0, -70.0)
    np.testing.assert_array_equal(again.belief(TARGET), posterior.belief(TARGET))
    assert [t.points for t in again.grounded(TARGET)] == [{HEARER: (5.0, -70.0)}] * 2
