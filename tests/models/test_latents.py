"""A latent of one's own, added from outside: which of several landmarks of one name is meant."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
import torch
from pyro.infer import TraceEnum_ELBO, config_enumerate

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference import Enumerate, Importance, infer_description
from sloop_ppl.maps import CityMap, Landmark
from sloop_ppl.models import FrameDistribution, FramePart, Latent, build, preset
from tests.scenes import TARGET, relation, said, symmetric_grid

GRID = symmetric_grid(24, 10.0)


def square(x, y):
    return shapely.box(x - 5, y - 5, x + 5, y + 5)


CITY = CityMap(
    "kiosks",
    GRID,
    (
        Landmark("Kiosk", "poi", square(-75, -75), name="Sunny Kiosk"),
        Landmark("Kiosk2", "poi", square(75, 75), name="Sunny Kiosk"),
        Landmark("Kiosk3", "poi", square(75, -75), name="Sunny Kiosk"),
        Landmark("OldMill", "building", square(72, 45), name="Old Mill"),
    ),
)
"""Kiosk2 alone is north of the mill."""

NEAR_AND_NORTH = said(relation("near", "Kiosk"), relation("north", "OldMill"))
KIOSKS = ("Kiosk", "Kiosk2", "Kiosk3")


def which_kiosk(candidates=KIOSKS, prior=None, index=0):
    """The latent that a user adds: the ground of one relation among some candidates."""
    return Latent(
        "ground_0",
        candidates,
        prior or (1 / len(candidates),) * len(candidates),
        concerns=lambda relation: relation.index == index,
        given=lambda relation, ground: replace(relation, grounds=(ground,)),
    )


def model(*latents, **changes):
    return replace(preset("bayes"), latents=latents, **changes)


def test_the_kiosk_north_of_the_mill_is_meant():
    two = which_kiosk(("Kiosk2", "Kiosk3"))
    posterior, _ = infer_description(NEAR_AND_NORTH, CITY, model(two))
    p = dict(zip(two.support, posterior.joint.probabilities("ground_0"), strict=True))
    assert p["Kiosk2"] > 0.9
    x, y = posterior.mode(TARGET)
    assert math.hypot(x - 75, y - 75) < 20
    first, _ = infer_description(NEAR_AND_NORTH, CITY, model())  # reads the first by its id
    there = GRID.cell_at(75, 75)
    assert first.belief(TARGET)[there] < posterior.belief(TARGET)[there]
    assert first.entropy(TARGET) > posterior.entropy(TARGET)


def test_a_phrase_is_the_weighted_sum_of_candidates_each_normalised_by_itself():
    """By hand: phi = lapse / S + (1 - lapse) sum c g / sum g; temper and normaliser after it."""
    prior = (0.5, 0.2, 0.3)
    chosen = model(which_kiosk(prior=prior))
    got = infer_description(NEAR_AND_NORTH, CITY, chosen)[0].belief(TARGET)
    plain = replace(preset("bayes"), lapse=0.0, temper=0.0)

    def table(word, ground):
        return infer_description(said(relation(word, ground)), CITY, plain)[0].belief(TARGET)

    lapse, n = chosen.lapse, GRID.size
    near = sum(c * table("near", k) for c, k in zip(prior, KIOSKS, strict=True))
    phi = [lapse / n + (1 - lapse) * near, lapse / n + (1 - lapse) * table("north", "OldMill")]
    expected = (phi[0] * phi[1]) ** (2**-chosen.temper)
    np.testing.assert_allclose(got, expected / expected.sum(), rtol=1e-9)


@pytest.mark.parametrize("word", ["near", "front"])
def test_a_denied_phrase_is_the_weighted_sum_of_denials_each_by_its_own_peak(word):
    prior = (0.5, 0.2, 0.3)
    plain = model(lapse=0.0, temper=0.0, frame_prior=each_its_own)
    chosen = replace(plain, latents=(which_kiosk(prior=prior),))
    got = infer_description(said(relation(word, "Kiosk", negated=True)), CITY, chosen)[0]
    expected = sum(
        c * infer_description(said(relation(word, k, negated=True)), CITY, plain)[0].belief(TARGET)
        for c, k in zip(prior, KIOSKS, strict=True)
    )
    np.testing.assert_allclose(got.belief(TARGET), expected, rtol=1e-9)


def test_one_candidate_is_the_model_without_the_latent():
    got = infer_description(NEAR_AND_NORTH, CITY, model(which_kiosk(("Kiosk2",))))[0]
    plain = said(relation("near", "Kiosk2"), relation("north", "OldMill"))
    expected = infer_description(plain, CITY)[0]
    np.testing.assert_allclose(got.belief(TARGET), expected.belief(TARGET), atol=1e-14)


def test_nothing_else_said_leaves_the_prior_over_candidates():
    prior = (0.5, 0.2, 0.3)
    alone = said(relation("near", "Kiosk"))
    posterior, _ = infer_description(alone, CITY, model(which_kiosk(prior=prior)))
    np.testing.assert_allclose(posterior.joint.probabilities("ground_0"), prior, atol=1e-12)


def each_its_own(term):
    """A frame prior under which every kiosk faces another way."""
    turn = KIOSKS.index(term.ground) if term.ground in KIOSKS else 0
    return FrameDistribution((FramePart(2.0 * turn, 4.0, 0.8),), lapse=0.2)


@pytest.mark.parametrize("frame_word", [False, True])
def test_every_engine_follows(frame_word):
    word = "front" if frame_word else "near"
    what = said(relation(word, "Kiosk"), relation("north", "OldMill"))
    chosen = model(which_kiosk(), lapse=0.1, frame_prior=each_its_own)
    exact, _ = infer_description(what, CITY, chosen)
    full, _ = infer_description(what, CITY, chosen, Enumerate(720))
    np.testing.assert_allclose(full.belief(TARGET), exact.belief(TARGET), atol=1e-12)
    marginals = TraceEnum_ELBO(max_plate_nesting=0).compute_marginals(
        config_enumerate(build(what, CITY, chosen, frame_bins=360)), lambda: None
    )
    cells = marginals[f"{TARGET}/cell"].probs.reshape(GRID.shape)
    np.testing.assert_allclose(cells, exact.belief(TARGET), atol=1e-7)
    # Tempering holds for the phrase as a whole, so Pyro's own marginal of the latent is the one
    # before it; the joint posterior's is the same, given the cell.
    assert marginals["ground_0"].probs.shape == (3,)
    # A frame's density has a site for each kiosk, and draws of those that are not meant do no harm.
    rng, draws = np.random.default_rng(0), 2000 if frame_word else 10
    rough, _ = infer_description(what, CITY, chosen, Importance(draws), rng=rng)
    off = np.abs(rough.belief(TARGET) - exact.belief(TARGET)).sum() / 2
    assert off < (0.01 if frame_word else 1e-9)


def test_the_posterior_answers_joints_and_conditionals_of_the_latent():
    joint = infer_description(NEAR_AND_NORTH, CITY, model(which_kiosk()))[0].joint
    assert "ground_0" in joint.latents
    assert joint.support("ground_0") == KIOSKS
    both = joint.table("ground_0", f"{TARGET}/cell")
    assert both.dims == ("ground_0", f"{TARGET}/cell")
    np.testing.assert_allclose(both.sum(f"{TARGET}/cell"), joint.probabilities("ground_0"))
    cell = int(np.ravel_multi_index(GRID.cell_at(-75.0, -75.0), GRID.shape))
    there = joint.probabilities("ground_0", given={f"{TARGET}/cell": cell})
    column = both.values[:, cell]
    np.testing.assert_allclose(there, column / column.sum())
    assert there[0] > 0.9
    cells = joint.probabilities(f"{TARGET}/cell", given={"ground_0": "Kiosk3"})
    np.testing.assert_allclose(cells, both.values[2] / both.values[2].sum(), rtol=1e-9)


def test_a_latent_that_two_phrases_depend_on_is_drawn_once():
    """Both mean the same kiosk: the sum over kiosks of the products, by hand."""
    what = said(relation("near", "Kiosk"), relation("north", "Kiosk"))
    shared = Latent(
        "kiosk", KIOSKS, (0.5, 0.2, 0.3),
        concerns=lambda relation: relation.ground == "Kiosk",
        given=lambda relation, ground: replace(relation, grounds=(ground,)),
    )  # fmt: skip
    plain = model(lapse=0.0, temper=0.0)
    got, _ = infer_description(what, CITY, replace(plain, latents=(shared,)))

    def table(word, ground):
        return infer_description(said(relation(word, ground)), CITY, plain)[0].belief(TARGET)

    shares = zip((0.5, 0.2, 0.3), KIOSKS, strict=True)
    each = [c * table("near", k) * table("north", k) for c, k in shares]
    total = sum(each)
    np.testing.assert_allclose(got.belief(TARGET), total / total.sum(), rtol=1e-9)
    expected = np.array([table.sum() for table in each])
    np.testing.assert_allclose(
        got.joint.probabilities("kiosk"), expected / expected.sum(), rtol=1e-9
    )


def test_a_likelihood_may_ask_for_a_value_itself():
    """Without `given` the value stands in relation.latents: here a reach that is not known."""

    class Reach:
        def log_g(self, term, direction_rad):
            table = -term.off_m / term.latents["reach_m"]
            return table if direction_rad is None else table.expand(len(direction_rad), -1)

    reach = Latent("reach_m", (10.0, 40.0), (0.5, 0.5))
    chosen = replace(preset("bayes"), likelihood=Reach(), latents=(reach,), lapse=0.0, temper=0.0)
    got, _ = infer_description(said(relation("near", "OldMill")), CITY, chosen)
    off = torch.from_numpy(CITY.fields("OldMill").distance_m)
    each = [torch.softmax((-off / r).reshape(-1), 0).reshape(GRID.shape) for r in (10.0, 40.0)]
    np.testing.assert_allclose(got.belief(TARGET), (each[0] + each[1]) / 2, rtol=1e-9)


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda: Latent("a", ("x", "y"), (0.5, 0.6)), "prior of latent 'a' sums to 1.1; expected"),
        (lambda: Latent("a", ("x", "y"), (1.5, -0.5)), "probabilities of at least 0 that sum to 1"),
        (lambda: Latent("a", ("x", "y"), (1.0,)), "has 1 prior probabilities for 2 values"),
        (lambda: Latent("a", ("x", "x"), (0.5, 0.5)), "expected distinct values"),
        (lambda: Latent("", ("x",), (1.0,)), "expected a name that is not empty"),
    ],
)
def test_a_latent_that_is_none(made, message):
    with pytest.raises(InputError, match=message):
        made()


def test_a_name_used_twice_is_refused():
    for taken, message in (
        ((which_kiosk(), which_kiosk()), "Two latents are named 'ground_0'"),
        ((Latent(f"{TARGET}/cell", (1,), (1.0,)),), "has the name of a site of a target"),
    ):
        with pytest.raises(InputError, match=message):
            infer_description(NEAR_AND_NORTH, CITY, model(*taken))
    with pytest.raises(UnknownName, match="Latent 'ground_9' is unknown; expected one of"):
        infer_description(NEAR_AND_NORTH, CITY)[0].joint.probabilities("ground_9")


def test_a_model_with_latents_is_saved_by_its_name_alone(tmp_path):
    posterior, _ = infer_description(NEAR_AND_NORTH, CITY, model(which_kiosk()))
    with pytest.raises(InputError, match="declares latents with functions, which cannot be"):
        posterior.save(tmp_path / "p.nc")
