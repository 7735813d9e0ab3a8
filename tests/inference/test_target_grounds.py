"""Relations between targets: the exact joint of their cells, by brute force."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
import torch
from pyro.infer import TraceEnum_ELBO, config_enumerate

from sloop_ppl.errors import DescriptionError, InputError
from sloop_ppl.inference import Enumerate, Importance, Posterior, _pairs, infer_batch
from sloop_ppl.inference import infer_description as infer
from sloop_ppl.language import (
    HEARER,
    Candidate,
    Description,
    Distance,
    Reading,
    SpatialRelation,
    TargetObject,
)
from sloop_ppl.models import (
    LIKELIHOODS,
    Component,
    Latent,
    ObservationModel,
    PredictedSpread,
    build,
    preset,
)
from tests.scenes import point_city, symmetric_grid

GRID = symmetric_grid(6)
CITY = point_city(GRID, Pole=(2.5, 2.5), Tree=(-12.5, -7.5))
PLAIN = replace(preset("bayes"), temper=0.0)
RNG = np.random.default_rng(3)


def told(*relations, targets=("A", "B"), **options):
    return Description("", "", tuple(map(TargetObject, targets)), relations, **options)


def rel(figure, word, *grounds, **options):
    return SpatialRelation(figure, word, grounds, **options)


def sensed(*targets):
    return {t: np.log(RNG.uniform(0.05, 1.0, GRID.shape)) for t in targets}


def rows_by_hearer(model, city, word, **options):
    """Return phi(s1 | s2) as the belief in a figure that is so from a hearer in cell s2.

    Shape (S, S), the ground's cells first: one phrase, so that nothing is tempered.
    """
    centres = [city.grid.centre_of(*divmod(c, city.grid.n_cols)) for c in range(city.grid.size)]
    return np.stack(
        [
            infer(told(rel("A", word, HEARER, **options), targets=("A",), hearer=at), city, model)[
                0
            ].belief("A")
            for at in centres
        ]
    ).reshape(city.grid.size, city.grid.size)


def flat(posterior, target):
    return posterior.belief(target).reshape(-1)


def normalised(table):
    return table / table.sum()


OPTIONS = [
    ("near", {}),
    ("north", {}),
    ("at", {"negated": True}),
    ("near", {"distance": Distance(10, math.inf)}),
    ("left", {}),
]


@pytest.mark.parametrize(("word", "options"), OPTIONS)
def test_two_beliefs_are_the_marginals_of_their_joint(word, options):
    one, other = rel("A", "near", "Pole"), rel("B", "southwest", "Tree")
    said = told(one, rel("A", word, "B", **options), other)
    seen = sensed("A", "B")
    posterior = infer(said, CITY, PLAIN)[0].condition(seen)
    alone = infer(told(one, other), CITY, PLAIN)[0].condition(seen)
    rows = rows_by_hearer(PLAIN, CITY, word, **options)
    joint = normalised(rows * flat(alone, "B")[:, None] * flat(alone, "A"))
    np.testing.assert_allclose(flat(posterior, "A"), joint.sum(0), atol=1e-12)
    np.testing.assert_allclose(flat(posterior, "B"), joint.sum(1), atol=1e-12)
    got = posterior.joint.probabilities("B/cell", "A/cell")
    np.testing.assert_allclose(got, joint, atol=1e-12)
    evidence = (rows * flat(alone, "B")[:, None] * flat(alone, "A")).sum()
    assert float(posterior.log_evidence) == pytest.approx(
        float(alone.log_evidence) + math.log(evidence), abs=1e-9
    )


@pytest.mark.parametrize("name", ["sloop", "sloop-m2", "sloop-m4"])
def test_the_papers_models_take_it_beside_their_mixture(name):
    one, other = rel("A", "near", "Pole"), rel("B", "near", "Tree")
    model = preset(name)
    posterior, _ = infer(told(one, rel("A", "north", "B"), other), CITY, model)
    alone, _ = infer(told(one, other), CITY, model)
    plain = replace(model, components=(Component("product"),))  # the factor is never cut
    rows = rows_by_hearer(plain, CITY, "north")
    joint = normalised(rows * flat(alone, "B")[:, None] * flat(alone, "A"))
    np.testing.assert_allclose(flat(posterior, "A"), joint.sum(0), atol=1e-9)
    np.testing.assert_allclose(flat(posterior, "B"), joint.sum(1), atol=1e-9)


@pytest.mark.parametrize("name", ["uniform", "keyword"])
def test_models_that_take_no_phrase_as_it_was_said_take_none_of_these(name):
    posterior, _ = infer(told(rel("A", "near", "Pole"), rel("A", "north", "B")), CITY, name)
    alone, _ = infer(told(rel("A", "near", "Pole")), CITY, name)
    np.testing.assert_array_equal(posterior.belief("A"), alone.belief("A"))
    assert not posterior.is_coupled


def test_a_phrase_to_a_target_counts_to_the_temper():
    """Two phrases of A, each to the power 2^-t; that of B by itself."""
    model = replace(PLAIN, temper=0.5)
    said = told(rel("A", "near", "Pole"), rel("A", "north", "B"), rel("B", "near", "Tree"))
    posterior, _ = infer(said, CITY, model)
    one = flat(infer(told(rel("A", "near", "Pole")), CITY, PLAIN)[0], "A") ** 2**-0.5
    other = flat(infer(told(rel("B", "near", "Tree")), CITY, PLAIN)[0], "B")
    joint = rows_by_hearer(PLAIN, CITY, "north") ** 2**-0.5 * other[:, None] * one
    np.testing.assert_allclose(flat(posterior, "A"), normalised(joint.sum(0)), atol=1e-12)
    np.testing.assert_allclose(flat(posterior, "B"), normalised(joint.sum(1)), atol=1e-12)


def test_where_nothing_else_is_known_the_ground_may_be_anywhere():
    posterior, info = infer(told(rel("A", "north", "B")), CITY, PLAIN)
    np.testing.assert_allclose(posterior.belief("B"), 1 / 36, atol=1e-14)
    rows = rows_by_hearer(PLAIN, CITY, "north")
    np.testing.assert_allclose(flat(posterior, "A"), rows.mean(0), atol=1e-13)
    assert info.not_located == ()
    assert posterior.component("A") == {"product": 1.0, "no-frame": 0.0}
    assert posterior.related == {"A", "B"}


def test_mirrored_words_give_mirrored_beliefs_and_swapped_names_swapped_ones():
    north, _ = infer(told(rel("A", "north", "B")), CITY, "bayes")
    south, _ = infer(told(rel("A", "south", "B")), CITY, "bayes")
    east, _ = infer(told(rel("A", "east", "B")), CITY, "bayes")
    np.testing.assert_allclose(north.belief("A"), south.belief("A")[::-1], atol=1e-14)
    np.testing.assert_allclose(north.belief("A"), east.belief("A").T, atol=1e-14)
    swapped, _ = infer(told(rel("B", "north", "A")), CITY, "bayes")
    np.testing.assert_array_equal(swapped.belief("B"), north.belief("A"))
    np.testing.assert_array_equal(swapped.belief("A"), north.belief("B"))
    near, _ = infer(told(rel("A", "near", "B")), CITY, "bayes")
    np.testing.assert_allclose(near.belief("A"), near.belief("A").T, atol=1e-14)


@pytest.mark.parametrize("word", ["front", "behind", "left", "right"])
def test_the_front_of_a_target_may_face_any_way(word):
    posterior, _ = infer(told(rel("A", word, "B")), CITY, "bayes")
    belief = posterior.belief("A")
    np.testing.assert_allclose(belief, np.rot90(belief), atol=1e-14)
    facing, _ = infer(told(rel("A", word, "B")), CITY, "bayes", do={"frame": {"B": 0.3}})
    assert np.abs(facing.belief("A") - belief).sum() > 0.05


def brute(beliefs, factors):
    """Return the marginals of three targets' cells, from their beliefs and pairwise factors."""
    a, b, c = beliefs
    joint = a[:, None, None] * b[None, :, None] * c[None, None, :]
    for axes, table in factors:
        shape = [1, 1, 1]
        for axis in axes:
            shape[axis] = 36
        order = table if axes[0] < axes[1] else table.T
        joint = joint * order.reshape(shape)
    joint /= joint.sum()
    return joint.sum((1, 2)), joint.sum((0, 2)), joint.sum((0, 1)), joint


LINKS = {
    "chain": [("A", "near", "B"), ("B", "north", "C")],
    "star": [("A", "west", "C"), ("B", "near", "C")],
    "circle": [("A", "near", "B"), ("B", "north", "C"), ("C", "east", "A")],
    "both ways": [("A", "near", "B"), ("B", "south", "A"), ("C", "at", "B"), ("A", "west", "B")],
}


@pytest.mark.parametrize("name", LINKS)
def test_chains_stars_and_circles_of_targets(name):
    seen = sensed("A", "B", "C")
    said = told(*(rel(f, w, g) for f, w, g in LINKS[name]), targets=("A", "B", "C"))
    posterior = infer(said, CITY, PLAIN)[0].condition(seen)
    beliefs = [normalised(np.exp(seen[t]).reshape(-1)) for t in "ABC"]
    factors = []
    for figure, word, ground in LINKS[name]:
        rows = rows_by_hearer(PLAIN, CITY, word)  # ground first
        factors.append((("ABC".index(ground), "ABC".index(figure)), rows))
    *marginals, joint = brute(beliefs, factors)
    for target, expected in zip("ABC", marginals, strict=True):
        np.testing.assert_allclose(flat(posterior, target), expected, atol=1e-12)
    for one, other in itertools.permutations((0, 1, 2), 2):
        got = posterior.joint.probabilities(*(f"{'ABC'[i]}/cell" for i in (one, other)))
        expected = joint.sum(({0, 1, 2} - {one, other}).pop())
        np.testing.assert_allclose(got, expected if one < other else expected.T, atol=1e-12)


def test_what_is_sensed_of_one_moves_the_other():
    posterior, _ = infer(told(rel("A", "near", "Pole"), rel("A", "east", "B")), CITY, PLAIN)
    at = np.full(GRID.shape, -np.inf)
    at[4, 1] = 0.0
    found = posterior.condition({"B": at})
    alone = flat(infer(told(rel("A", "near", "Pole")), CITY, PLAIN)[0], "A")
    row = rows_by_hearer(PLAIN, CITY, "east")[4 * 6 + 1]
    np.testing.assert_allclose(flat(found, "A"), normalised(alone * row), atol=1e-13)
    assert posterior.is_coupled
    far = posterior.condition({"A": at})
    assert np.abs(far.belief("B") - posterior.belief("B")).sum() > 0.1


def test_updates_commute_and_of_one_speaker_are_one_description():
    texts = [
        told(rel("A", "near", "Pole"), targets=("A",), speaker="Eve"),
        told(rel("B", "near", "Tree"), targets=("B",), speaker="Eve"),
        told(rel("A", "north", "B"), targets=("A",), speaker="Eve"),  # B is known from before
    ]
    first, _ = infer(texts[1], CITY, "bayes")
    post = first.update(texts[0]).update(texts[2])
    whole, _ = infer(told(*(t.relations[0] for t in texts), speaker="Eve"), CITY, "bayes")
    other = first.update(texts[2]).update(texts[0])
    for target in "AB":
        np.testing.assert_allclose(post.belief(target), whole.belief(target), atol=1e-13)
        np.testing.assert_allclose(post.belief(target), other.belief(target), atol=1e-13)
    bob = told(rel("B", "at", "A"), speaker="Bob")
    one = post.update(bob)
    two = infer(bob, CITY, "bayes")[0].update(replace(texts[1], targets=texts[1].targets))
    two = two.update(texts[0]).update(texts[2])
    for target in "AB":
        np.testing.assert_allclose(one.belief(target), two.belief(target), atol=1e-13)


def test_engines_agree():
    said = told(rel("A", "behind", "Pole"), rel("A", "near", "B"), rel("B", "right", "Tree"))
    exact, _ = infer(said, CITY, PLAIN)
    all_of_it, _ = infer(said, CITY, PLAIN, Enumerate(frame_bins=720))
    drawn, _ = infer(said, CITY, PLAIN, Importance(20_000), rng=np.random.default_rng(0))
    for target in "AB":
        np.testing.assert_allclose(exact.belief(target), all_of_it.belief(target), atol=1e-10)
        assert np.abs(exact.belief(target) - drawn.belief(target)).sum() < 0.02


def test_targets_that_share_a_frame_and_lie_by_each_other():
    """Fix the front that both phrases share at each of its angles and mix by evidence."""
    model = replace(
        PLAIN,
        components=(Component("product"),),
        frame_prior=PredictedSpread(kappa=1.0, lapse=0.2, absolute=0.0),
        shared_frames=True,
    )
    pair = rel("A", "near", "B")
    framed = (rel("A", "front", "Pole"), rel("B", "behind", "Pole"))
    posterior, _ = infer(told(*framed, pair), CITY, model)
    apart, _ = infer(told(*framed), CITY, model)
    names = ("frame/Pole", "A/cell")
    a = apart.joint.probabilities(*names)
    b = apart.joint.probabilities("frame/Pole", "B/cell")
    share = a.sum(1, keepdims=True)
    rows = rows_by_hearer(replace(model, shared_frames=False), CITY, "near")
    joint = np.einsum("fa,fb,ba->ba", a, b / share, rows)
    # p(a, b | front) factorises; p(front | both) is that of the two phrases together
    np.testing.assert_allclose(flat(posterior, "A"), normalised(joint.sum(0)), atol=1e-11)
    np.testing.assert_allclose(flat(posterior, "B"), normalised(joint.sum(1)), atol=1e-11)


@pytest.mark.parametrize("lapse", [0.1, 0.0])
def test_large_maps_are_multiplied_block_by_block(monkeypatch, lapse):
    model = replace(PLAIN, lapse=lapse, likelihood=LIKELIHOODS["gaussian-clipped"])
    links = LINKS["both ways"]
    said = told(*(rel(f, w, g) for f, w, g in links), targets=("A", "B", "C"))
    seen = sensed("A", "B", "C")
    whole = infer(said, CITY, model)[0].condition(seen)
    monkeypatch.setattr(_pairs, "_DENSE", 0)
    monkeypatch.setattr(_pairs, "_BLOCK", 36 * 7)
    parted = infer(said, CITY, model)[0].condition(seen)
    monkeypatch.setattr(_pairs, "_DEEP", 1.0)
    deep = infer(said, CITY, model)[0].condition(seen)
    for target in "ABC":
        np.testing.assert_allclose(parted.belief(target), whole.belief(target), atol=1e-13)
        np.testing.assert_allclose(deep.belief(target), whole.belief(target), atol=1e-13)


@pytest.mark.parametrize(
    ("word", "denied"), [("near", False), ("north", False), ("left", False), ("at", True)]
)
def test_one_phrase_on_a_large_map_is_a_convolution(monkeypatch, word, denied):
    city = point_city(symmetric_grid(11), Pole=(2.5, 2.5), Tree=(-22.5, -17.5))
    pair = rel("A", word, "B", negated=denied)
    said = told(pair, rel("A", "near", "Pole"), rel("B", "near", "Tree"))
    seen = {t: np.log(RNG.uniform(0.05, 1.0, city.grid.shape)) for t in "AB"}
    for model in (PLAIN, preset("bayes"), replace(PLAIN, likelihood=LIKELIHOODS["box"])):
        whole = infer(said, city, model)[0].condition(seen)
        with monkeypatch.context() as changed:
            changed.setattr(_pairs, "_DENSE", 0)
            parted = infer(said, city, model)[0].condition(seen)
            (member,) = parted.joint.factors[-1].members
            assert member.kernel.expansion() is not None
            for target in "AB":
                np.testing.assert_allclose(
                    parted.belief(target), whole.belief(target), rtol=1e-8, atol=1e-12
                )


def test_a_circle_on_a_large_map_is_one_error(monkeypatch):
    monkeypatch.setattr(_pairs, "MOST_NUMBERS", 1000)
    said = told(*(rel(f, w, g) for f, w, g in LINKS["circle"]), targets=("A", "B", "C"))
    with pytest.raises(InputError, match="must not form a circle on a map of so many cells"):
        infer(said, CITY, PLAIN)[0].belief("A")
    infer(told(*(rel(f, w, g) for f, w, g in LINKS["chain"]), targets=("A", "B", "C")), CITY, PLAIN)


def test_contradictions_beyond_underflow_are_weighed():
    """Two phrases of a model without lapses that no cells satisfy, thousands of nats deep."""
    model = ObservationModel(
        "deep",
        (Component("product"),),
        replace(LIKELIHOODS["gaussian-clipped"], at_m=0.2, near_m=0.2),
        PredictedSpread(),
    )
    said = told(rel("A", "at", "Pole"), rel("B", "at", "Tree"), rel("A", "near", "B"))
    posterior, _ = infer(said, CITY, model)
    for target in "AB":
        assert posterior.belief(target).sum() == pytest.approx(1.0)
    # so narrow that only the least sum of squares is left: A, B and the way between them
    x, y = np.meshgrid(GRID.x_m, GRID.y_m)
    to_pole = ((x - 2.5) ** 2 + (y - 2.5) ** 2).reshape(-1)
    to_tree = ((x + 12.5) ** 2 + (y + 7.5) ** 2).reshape(-1)
    squares = to_pole[:, None] + to_tree + cell_distances() ** 2
    best = np.isclose(squares, squares.min())
    np.testing.assert_allclose(flat(posterior, "A"), normalised(best.sum(1)), atol=1e-9)
    np.testing.assert_allclose(flat(posterior, "B"), normalised(best.sum(0)), atol=1e-9)


def test_the_program_has_the_same_marginals():
    said = told(rel("A", "near", "Pole"), rel("A", "north", "B"), rel("B", "left", "Tree"))
    program = build(said, CITY, "bayes", frame_bins=24)
    marginals = TraceEnum_ELBO(max_plate_nesting=0).compute_marginals(
        config_enumerate(program), lambda: None
    )
    posterior, _ = infer(said, CITY, "bayes", Enumerate(frame_bins=24))
    for target in "AB":
        got = marginals[f"{target}/cell"].probs.reshape(GRID.shape)
        np.testing.assert_allclose(got, posterior.belief(target), atol=1e-9)


def test_a_posterior_is_kept(tmp_path):
    from sloop_ppl.maps import load_map

    city = load_map("cleveland", cell_m=20)
    said = told(
        rel("RedBike", "near", "Ivy"), rel("RedBike", "north", "B"), targets=("RedBike", "B")
    )
    posterior, _ = infer(said, city, "bayes")
    posterior.save(tmp_path / "p.nc")
    again = Posterior.load(tmp_path / "p.nc")
    later = told(rel("B", "near", "RedBike"), targets=("B",))
    for target in ("RedBike", "B"):
        np.testing.assert_array_equal(again.belief(target), posterior.belief(target))
        np.testing.assert_allclose(
            again.update(later).belief(target), posterior.update(later).belief(target), atol=1e-14
        )
    assert again.is_coupled


def test_questions_about_a_phrase_to_a_target():
    said = told(rel("A", "near", "B"), rel("A", "west", "Pole"), rel("B", "at", "Tree"))
    posterior, _ = infer(said, CITY, PLAIN)
    first, second = posterior.lapses("A")
    assert [r.relation for r in posterior.relations("A")] == ["near", "west"]
    assert 0 < first.p < 1
    assert first.prior == pytest.approx(PLAIN.lapse)
    assert second.prior == pytest.approx(PLAIN.lapse)
    near, west = posterior.phrase_tables("A")
    rows = rows_by_hearer(PLAIN, CITY, "near")
    np.testing.assert_allclose(
        near.reshape(-1), normalised(flat(posterior, "B") @ rows), atol=1e-12
    )
    assert west.sum() == pytest.approx(1.0)
    bits = [influence.bits for influence in posterior.influence("A")]
    assert len(bits) == 2
    assert min(bits) > 0
    (check,) = posterior.predictive("A")
    assert check.index == 1
    draws = posterior.draws("A", 50, rng=np.random.default_rng(0))
    assert set(draws["component"].values.flat) <= {"product", "no-frame"}
    assert posterior.frames("A") == ()
    assert len(posterior.grounded("A")) == 1


def test_the_lapse_of_a_phrase_to_a_target_by_brute_force():
    said = told(rel("A", "near", "Pole"), rel("A", "at", "B"), rel("B", "at", "Tree"))
    model = replace(PLAIN, lapse=0.2)
    posterior, _ = infer(said, CITY, model)
    meant = rows_by_hearer(replace(model, lapse=0.0), CITY, "at")
    alone, _ = infer(told(*said.relations[::2]), CITY, model)
    both = flat(alone, "B")[:, None] * flat(alone, "A")
    lapsed = 0.2 * (both / 36).sum()
    expected = lapsed / (lapsed + 0.8 * (both * meant).sum())
    assert posterior.lapses("A")[1].p == pytest.approx(expected, abs=1e-12)


def test_several_at_once_are_each_inferred_by_itself():
    said = [told(rel("A", "near", "Pole"), rel("A", "north", "B")), told(rel("A", "at", "Tree"))]
    for beliefs, one in zip(infer_batch(said, CITY), said, strict=True):
        posterior, _ = infer(one, CITY)
        for target in "AB":
            np.testing.assert_allclose(beliefs[target], posterior.belief(target), atol=1e-14)


def test_between_a_place_and_a_target_is_near_each():
    said = told(rel("A", "between", "Pole", "B"), rel("B", "near", "Tree"))
    each = told(rel("A", "near", "Pole"), rel("A", "near", "B"), rel("B", "near", "Tree"))
    for target in "AB":
        np.testing.assert_allclose(
            infer(said, CITY)[0].belief(target), infer(each, CITY)[0].belief(target), atol=1e-14
        )


def test_a_landmark_of_the_same_id_comes_first():
    said = told(rel("A", "near", "Pole"), targets=("A", "Pole"))
    posterior, _ = infer(said, CITY)
    assert not posterior.is_coupled


def test_a_target_cannot_be_its_own_ground():
    with pytest.raises(DescriptionError) as caught:
        infer(told(rel("A", "near", "A")), CITY)
    assert str(caught.value) == (
        "Relation 'near' of 'A' is to 'A' itself; expected a landmark or another target"
    )


def test_latents_of_a_phrase_are_summed_within_it():
    wide = Latent(
        "wide",
        (False, True),
        (0.3, 0.7),
        concerns=lambda relation: relation.relation == "near",
        given=lambda relation, value: replace(relation, relation="at") if value else relation,
        per="relation",
    )
    model = replace(PLAIN, latents=(wide,), lapse=0.0)
    posterior, _ = infer(told(rel("A", "near", "B"), rel("B", "at", "Tree")), CITY, model)
    plain = replace(PLAIN, lapse=0.0)
    alone = flat(infer(told(rel("B", "at", "Tree")), CITY, plain)[0], "B")
    rows = 0.3 * rows_by_hearer(plain, CITY, "near") + 0.7 * rows_by_hearer(plain, CITY, "at")
    np.testing.assert_allclose(flat(posterior, "A"), alone @ rows, atol=1e-12)


def test_speakers_relate_targets_too():
    from sloop_ppl.models import speaker_of

    model = speaker_of("bayes")
    posterior, _ = infer(told(rel("A", "north", "B"), rel("B", "at", "Pole")), CITY, model)
    rows = posterior.joint.factors[-1].table().values
    assert torch.isfinite(rows).all()
    assert posterior.belief("A")[4:].sum() > posterior.belief("A")[:3].sum()


def test_imagined_places_are_drawn_together():
    from sloop_ppl.bridge.searching import imagined_places

    posterior, _ = infer(told(rel("A", "at", "B")), CITY, replace(PLAIN, lapse=0.0))
    apart = []
    for seed in range(60):
        places = imagined_places(posterior, {}, rng=np.random.default_rng(seed))
        apart.append(math.dist(places["A"], places["B"]))
    # independent cells lie 16 m apart in the mean; P(mean < 11 by chance) < 1e-4
    expected = float((posterior.joint.probabilities("A/cell", "B/cell") * cell_distances()).sum())
    assert np.mean(apart) == pytest.approx(expected, abs=4 * np.std(apart) / math.sqrt(60))
    assert expected < 11


def cell_distances():
    x, y = np.meshgrid(GRID.x_m, GRID.y_m)
    at = np.stack([x.reshape(-1), y.reshape(-1)], -1)
    return np.linalg.norm(at[:, None] - at, axis=-1)


def test_a_search_for_two_moves_both_beliefs():
    from sloop_ppl.bridge.searching import search

    said = told(rel("A", "at", "B"), rel("B", "near", "Tree"))
    posterior, _ = infer(said, CITY, PLAIN)
    places = {"A": (-12.5, -7.5), "B": (-12.5, -7.5)}
    episode = search(
        posterior, CITY, places, "greedy", rng=np.random.default_rng(0), start=(-2.5, -7.5, 180.0)
    )
    assert set(episode.found_targets) == {"A", "B"}
    before, after = posterior.belief("A"), episode.posterior.belief("A")
    assert np.abs(before - after).sum() > 0.1


# What is open: readings, alternatives, and mentions that may be a target.


def marginals_of(joint):
    """Return the beliefs of A and of B from their joint, shape (B's cells, A's cells)."""
    joint = joint / joint.sum()
    return joint.sum(0), joint.sum(1)


def check(posterior, joint):
    for target, expected in zip("AB", marginals_of(joint), strict=True):
        np.testing.assert_allclose(flat(posterior, target), expected, atol=1e-12)


def alone_of(model, *relations):
    return [flat(infer(told(*relations), CITY, model)[0], target) for target in "AB"]


def test_readings_are_summed_with_the_relation_between_targets():
    common = rel("A", "near", "Pole"), rel("B", "near", "Tree")
    north, south = rel("A", "north", "B"), rel("A", "south", "B")
    said = told(
        *common,
        north,
        readings=(Reading(0.7, (*common, north)), Reading(0.3, (*common, south))),
    )
    posterior, _ = infer(said, CITY, PLAIN)
    a, b = alone_of(PLAIN, *common)
    both = b[:, None] * a
    parts = [rows_by_hearer(PLAIN, CITY, word) * both for word in ("north", "south")]
    check(posterior, 0.7 * parts[0] + 0.3 * parts[1])
    shares = np.array([0.7 * parts[0].sum(), 0.3 * parts[1].sum()])
    np.testing.assert_allclose(
        posterior.joint.probabilities("reading"), shares / shares.sum(), atol=1e-12
    )
    # what is sensed of both decides the reading
    seen = sensed("A", "B")
    weights = np.exp(seen["B"]).reshape(-1, 1) * np.exp(seen["A"]).reshape(-1)
    check(posterior.condition(seen), (0.7 * parts[0] + 0.3 * parts[1]) * weights)


def test_a_reading_in_which_nothing_was_said_of_it():
    near, at = rel("A", "near", "Pole"), rel("A", "at", "B")
    said = told(near, at, readings=(Reading(0.8, (near, at)), Reading(0.2, ())))
    posterior, _ = infer(said, CITY, PLAIN)
    a, _ = alone_of(PLAIN, near)
    rows = rows_by_hearer(PLAIN, CITY, "at")
    check(posterior, 0.8 * rows * a / 36 + 0.2 / 36**3)
    lapse, prior = posterior.lapses("A")[1].p, PLAIN.lapse
    meant = 0.8 * rows * a / 36
    unsaid = 0.2 / 36 / (meant.sum() + 0.2 / 36)
    lapsed = (0.8 * prior / 36 * a[None, :] / 36 * np.ones((36, 1))).sum()
    expected = lapsed / (meant.sum() + 0.2 / 36) + unsaid * prior
    assert lapse == pytest.approx(expected, abs=1e-10)


def test_alternatives_between_a_target_and_a_place():
    said = told(
        rel("A", "at", "B", either=(0, 0)),
        rel("A", "near", "Pole", either=(0, 1)),
        rel("B", "near", "Tree"),
    )
    posterior, _ = infer(said, CITY, PLAIN)
    a, b = alone_of(PLAIN, rel("A", "near", "Pole"), rel("B", "near", "Tree"))
    rows = rows_by_hearer(PLAIN, CITY, "at")
    # the phrase of the other branch says nothing: it is as likely everywhere
    check(posterior, b[:, None] * (0.5 * rows + 0.5 * a) / 36)


BANK = (Candidate("B", 0.6), Candidate("Pole", 0.3), Candidate(None, 0.1))


def mention_joint(word, b):
    rows = rows_by_hearer(PLAIN, CITY, word)
    pole = alone_of(PLAIN, rel("A", word, "Pole"))[0]
    return b[:, None] * (0.6 * rows + 0.3 * pole + 0.1 / 36)


@pytest.mark.parametrize("top", ["B", "Pole"])
def test_a_mention_that_may_be_a_target_or_a_place(top):
    slot = tuple(sorted(BANK, key=lambda c: c.ground != top))
    said = told(rel("A", "north", top, candidates=(slot,)), rel("B", "near", "Tree"))
    posterior, _ = infer(said, CITY, PLAIN)
    b = alone_of(PLAIN, rel("B", "near", "Tree"))[1]
    check(posterior, mention_joint("north", b))
    rows = rows_by_hearer(PLAIN, CITY, "north")
    p = posterior.joint.table("ground_0")
    assert float(p.sel(ground_0="B")) == pytest.approx(0.6 * (b @ rows).sum(), abs=1e-12)
    assert len(posterior.grounds("A")) == 1
    again = posterior.condition(sensed("A", "B"))
    assert again.belief("A").sum() == pytest.approx(1.0)


def test_two_phrases_of_one_mention_mean_the_same():
    slot = (*BANK[:1], Candidate("Pole", 0.4))
    slot = (replace(slot[0], probability=0.6), slot[1])
    said = told(
        rel("A", "north", "B", candidates=(slot,), mentions=(0,)),
        rel("A", "near", "B", candidates=(slot,), mentions=(0,)),
        rel("B", "near", "Tree"),
    )
    posterior, _ = infer(said, CITY, PLAIN)
    b = alone_of(PLAIN, rel("B", "near", "Tree"))[1]
    words = ("north", "near")
    bike = np.prod([rows_by_hearer(PLAIN, CITY, w) for w in words], 0)
    pole = np.prod([alone_of(PLAIN, rel("A", w, "Pole"))[0] for w in words], 0)
    check(posterior, b[:, None] * (0.6 * bike + 0.4 * pole))


def test_not_near_it_denies_places_and_targets():
    said = told(rel("A", "near", "B", candidates=(BANK,), negated=True), rel("B", "near", "Tree"))
    posterior, _ = infer(said, CITY, PLAIN)
    each = told(
        rel("A", "near", "B", negated=True),
        rel("A", "near", "Pole", negated=True),
        rel("B", "near", "Tree"),
    )
    apart, _ = infer(each, CITY, PLAIN)
    for target in "AB":
        np.testing.assert_allclose(posterior.belief(target), apart.belief(target), atol=1e-10)


def test_the_papers_models_take_the_most_probable_of_what_is_open():
    north, south = rel("A", "north", "B"), rel("A", "south", "B")
    said = told(north, readings=(Reading(0.7, (north,)), Reading(0.3, (south,))))
    got, plain = infer(said, CITY, "sloop")[0], infer(told(north), CITY, "sloop")[0]
    np.testing.assert_allclose(got.belief("A"), plain.belief("A"), atol=1e-14)
    open_, _ = infer(told(rel("A", "north", "B", candidates=(BANK,))), CITY, "sloop")
    np.testing.assert_allclose(open_.belief("A"), plain.belief("A"), atol=1e-14)


def test_the_program_has_the_same_marginals_where_much_is_open():
    near = rel("A", "near", "B", candidates=(BANK,))
    north, south = rel("A", "north", "B"), rel("A", "south", "B")
    said = told(near, north, readings=(Reading(0.7, (near, north)), Reading(0.3, (near, south))))
    program = build(said, CITY, "bayes", frame_bins=8)
    marginals = TraceEnum_ELBO(max_plate_nesting=0).compute_marginals(
        config_enumerate(program), lambda: None
    )
    posterior, _ = infer(said, CITY, "bayes")
    for name in ("A/cell", "B/cell", "reading", "ground_0"):
        expected = posterior.joint.probabilities(name)
        np.testing.assert_allclose(marginals[name].probs.reshape(-1), expected, atol=1e-9)
