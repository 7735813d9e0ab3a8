from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference import infer_description, modes_of
from sloop_ppl.inference.frames import FramePosterior
from sloop_ppl.models import ground_relations, preset
from tests.mixture import MIXTURE
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(21), house=(12.0, -7.0), street_y=30.0)
BAYES = preset("bayes")
BEHIND = said(relation("behind", "House"))
BOTH = said(relation("behind", "House"), relation("left", "House"), relation("near", "MainSt"))


def posterior(description=BEHIND, model=MIXTURE, **options):
    return infer_description(description, CITY, model, **options)[0]


def seen_east(post):
    """The target was seen east of the house, whose street is north."""
    seen = np.full(CITY.grid.shape, -np.inf)
    seen[CITY.grid.cell_at(30.0, -7.0)] = 0.0
    return post.condition({TARGET: seen})


@pytest.mark.parametrize("model", ["bayes", "sloop-m4", "sloop-m2"])
def test_fronts_by_cell_sum_to_the_belief(model):
    post = posterior(BOTH, model)
    for index in (0, 1):
        table = post.joint_frame(TARGET, index)
        assert table.dims == ("angle", "y", "x")
        assert float(table.min()) >= 0
        np.testing.assert_allclose(table.sum("angle"), post.belief(TARGET), atol=1e-15)
        alone = post.frame(TARGET, relation=index)
        np.testing.assert_allclose(alone, table.sum(("y", "x")), atol=1e-15)
        assert float(alone["prior"].sum()) == pytest.approx(1)


def test_a_front_by_cell_is_bayes_rule_by_hand():
    """One component, a front from four bins: multiply prior and truth and normalise."""
    model = replace(MIXTURE, components=MIXTURE.components[:1])
    post = posterior(BEHIND, model)
    (term,) = ground_relations(BEHIND.relations, CITY)
    table = post.joint_frame(TARGET, bins=360).values.reshape(360, -1)
    angles, mass = model.frame_prior(term).bins(360)
    g = model.likelihood.log_g(term, torch.from_numpy(angles + term.offset_rad)).exp().numpy()
    by_hand = mass[:, None] * g
    by_hand = np.roll(by_hand / by_hand.sum(), -180, axis=0)  # the prior's bins start in the west
    assert 0.5 * np.abs(table - by_hand).sum() < 5e-3


def test_sensing_turns_the_front():
    before, after = posterior().frame(TARGET), seen_east(posterior()).frame(TARGET, "House")
    assert math.degrees(float(before.idxmax())) == pytest.approx(90)
    west = np.abs(np.degrees(after["angle"]) - 180) <= 45
    assert float(after[west].sum()) > float(before[west].sum()) + 0.2
    np.testing.assert_array_equal(before["prior"], after["prior"])
    assert before.attrs == {"ground": "House", "relation": "behind"}


def test_a_lapse_keeps_the_prior_of_the_front():
    sure = seen_east(posterior(BEHIND, replace(MIXTURE, lapse=0.0)))
    wary = seen_east(posterior(BEHIND, replace(MIXTURE, lapse=0.5)))
    told = [float(np.abs(p.frame(TARGET) - p.frame(TARGET)["prior"]).sum()) for p in (sure, wary)]
    assert told[1] < 0.8 * told[0]


def test_a_point_stays_a_point():
    front = posterior(BEHIND, "sloop").frame(TARGET)
    assert float(front.max()) == pytest.approx(1)
    assert math.degrees(float(front.idxmax())) == pytest.approx(90)


def test_a_shared_front_is_one_front():
    model = replace(MIXTURE, shared_frames=True)
    two = said(
        relation("front", "House"),
        relation("front", "House", figure="RedBike"),
        targets=(TARGET, "RedBike"),
    )
    post = posterior(two, model)
    # Equal but for how the prior is cut into bins.
    np.testing.assert_allclose(post.frame(TARGET), post.frame("RedBike"), rtol=1e-3)
    np.testing.assert_allclose(
        post.joint_frame(TARGET).sum("angle"), post.belief(TARGET), atol=1e-15
    )
    found = seen_east(post)
    np.testing.assert_allclose(found.frame(TARGET), found.frame("RedBike"), rtol=1e-3)
    east = found.frame("RedBike").sel(angle=0.0, method="nearest")
    assert float(east) > 3 * float(post.frame("RedBike").sel(angle=0.0, method="nearest"))


def test_two_shared_fronts_leave_no_gaps():
    model = replace(MIXTURE, shared_frames=True)
    four = said(
        relation("front", "House"),
        relation("front", "MainSt"),
        relation("left", "House", figure="RedBike"),
        relation("behind", "MainSt", figure="RedBike"),
        targets=(TARGET, "RedBike"),
    )
    front = posterior(four, model).frame(TARGET, "House")
    assert float(front.min()) > 0
    assert float(front.sum()) == pytest.approx(1)


@pytest.mark.parametrize(
    ("description", "options", "error", "message"),
    [
        (
            said(relation("near", "House")),
            {},
            InputError,
            (
                "Nothing that was said of 'RedCar' depends on a frame of reference under model "
                "'mixture'; expected front, behind, left or right"
            ),
        ),
        (
            BOTH,
            {},
            InputError,
            (
                "2 frames of 'RedCar' fit ground None and relation None; name one of the relations "
                "0 (behind House), 1 (left House)"
            ),
        ),
        (
            BOTH,
            {"relation": 2},
            InputError,
            (
                "0 frames of 'RedCar' fit ground None and relation 2; name one of the relations "
                "0 (behind House), 1 (left House)"
            ),
        ),
        (
            BEHIND,
            {"ground": "MainSt"},
            UnknownName,
            "Ground with a front 'MainSt' is unknown; expected one of House",
        ),
        (BEHIND, {"bins": 3}, InputError, "bins is 3; expected at least 4 directions"),
    ],
)
def test_a_frame_that_is_not_there(description, options, error, message):
    for ask in (posterior(description).frame, posterior(description).joint_frame):
        with pytest.raises(error) as caught:
            ask(TARGET, **options)
        assert str(caught.value) == message


def test_a_target_that_is_not_there():
    with pytest.raises(UnknownName, match="Target 'Bus' is unknown; expected one of RedCar"):
        posterior().frame("Bus")


# -- gains and modes ------------------------------------------------------------------------------


@pytest.mark.parametrize("kappa", [3.0, 60.0, 120.0])
@pytest.mark.parametrize("negated", [False, True])
def test_gains_are_those_of_the_joint_posterior(kappa, negated):
    """Smooth kernels by their Fourier series, sharp ones front by front: the same 72 fronts."""
    model = replace(BAYES, likelihood=replace(BAYES.likelihood, kappa_frame=kappa))
    text = said(relation("behind", "House", negated=negated), relation("near", "MainSt"))
    posterior, _ = infer_description(text, CITY, model)
    (framed,) = posterior.framed(TARGET)
    told = FramePosterior(posterior.joint, posterior.factors[framed.which], TARGET, framed)
    angles = np.array(posterior.joint.support(f"{TARGET}/frame_0"))
    expected = posterior.joint.probabilities(f"{TARGET}/frame_0")
    mass = model.frame_prior_for(framed.term).bins(len(angles))[1]
    for gain in (told.gain, told.gain_between):
        p = mass * gain(angles)
        np.testing.assert_allclose(p / p.sum(), expected, atol=1e-7)
    between = angles + 0.3 * (angles[1] - angles[0])
    np.testing.assert_allclose(told.gain_between(between), told.gain(between), atol=1e-7)


def von_mises(*parts):
    angles = 2 * np.pi * np.arange(72) / 72
    p = sum(w * np.exp(k * np.cos(angles - m)) / np.i0(k) for w, m, k in parts)
    return p / p.sum(), angles


@pytest.mark.parametrize(
    ("parts", "means"),
    [
        ([(1.0, 0.7, 0.0)], 1),
        ([(1.0, 0.7, 1.0)], [0.7]),
        ([(1.0, 0.7, 20.0)], [0.7]),
        ([(0.6, 1.5, 20.0), (0.4, -1.5, 20.0)], [1.5, -1.5]),
        ([(0.4, 0.0, 30.0), (0.33, 2.0, 30.0), (0.27, -2.0, 30.0)], [0.0, 2.0, -2.0]),
        ([(0.9, 1.5, 20.0), (0.1, -1.5, 20.0)], [1.5]),
    ],
)
def test_modes_are_where_the_mass_is(parts, means):
    modes = modes_of(*von_mises(*parts))
    if means == 1:  # nothing is known: one direction stands for all
        assert len(modes) == 1
        return
    np.testing.assert_allclose([mean for mean, _ in modes], means, atol=0.1)
    assert sorted(modes, key=lambda mode: -mode[1]) == list(modes)
    assert sum(mass for _, mass in modes) <= 1 + 1e-12
