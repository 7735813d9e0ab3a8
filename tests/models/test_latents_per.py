"""Latents per speaker, text, relation and ground; declared by a likelihood; with frames; saved."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import matplotlib as mpl
import numpy as np
import pyro.distributions as dist
import pytest
import torch
from pyro.infer import TraceEnum_ELBO, config_enumerate

from sloop_ppl.errors import InputError
from sloop_ppl.inference import Enumerate, Importance, Posterior, infer_description
from sloop_ppl.maps import load_map
from sloop_ppl.models import LIKELIHOODS, Component, Latent, build, preset
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

mpl.use("Agg")

CITY = house_and_street(symmetric_grid(21), house=(6.0, -8.0), street_y=20.0)
INNER = LIKELIHOODS["student-vonmises"]
TEXT = said(relation("near", "House"), relation("south", "MainSt"), relation("north", "House"))


@dataclass(frozen=True)
class Scaled:
    """Distances are judged twice too long or as they are; all that is told of one thing alike."""

    latents: tuple[Latent, ...]

    def log_g(self, term, direction_rad):
        return INNER.log_g(term, direction_rad) / (1.0 + 3.0 * term.latents["off"])


def scaled(per, prior=(0.7, 0.3), **changes):
    latent = Latent("off", (0, 1), prior, per=per)
    changes = {"components": (Component("literal"),), "lapse": 0.0, "temper": 0.0, **changes}
    return replace(preset("bayes"), name="mine", likelihood=Scaled((latent,)), **changes)


def by_hand(groups, prior=(0.7, 0.3), weights=None):
    """The product over groups of phrases of the sum over the value that they share."""
    total = np.ones(CITY.grid.size)
    for group in groups:
        mixed = np.zeros(CITY.grid.size)
        for value, p in enumerate(prior):
            product = np.ones(CITY.grid.size)
            for phrase in group:
                fixed = scaled("speaker", prior=tuple(float(v == value) for v in (0, 1)))
                product *= infer_description(said(phrase), CITY, fixed)[0].belief(TARGET).ravel()
            mixed += p * product
        total *= mixed
    return total / total.sum()


@pytest.mark.parametrize(
    ("per", "names", "groups"),
    [
        ("speaker", ("off",), [[0, 1, 2]]),
        ("description", ("off",), [[0, 1, 2]]),
        ("relation", tuple(f"{TARGET}/off_{j}" for j in range(3)), [[0], [1], [2]]),
        ("ground", ("off/House", "off/MainSt"), [[0, 2], [1]]),
    ],
)
def test_phrases_share_what_there_is_one_of(per, names, groups):
    posterior, _ = infer_description(TEXT, CITY, scaled(per))
    assert set(posterior.latents) == set(names)
    expected = by_hand([[TEXT.relations[j] for j in group] for group in groups])
    np.testing.assert_allclose(posterior.belief(TARGET).ravel(), expected, atol=1e-12)
    for name in names:
        values = posterior.latent(name)
        assert float(values.sum()) == pytest.approx(1.0)
        assert list(values.coords["prior"].values) == [0.7, 0.3]
        joint = posterior.joint_latent(name, TARGET)
        np.testing.assert_allclose(joint.sum(name), posterior.belief(TARGET), atol=1e-12)
        np.testing.assert_allclose(joint.sum(("y", "x")), values, atol=1e-12)


def test_each_text_of_a_speaker_has_its_own():
    texts = [replace(said(one), speaker="Ann") for one in TEXT.relations[:2]]
    model = scaled("description")
    posterior = infer_description(texts[0], CITY, model)[0].update(texts[1])
    assert posterior.latents == ("off", "off/text_1")
    expected = by_hand([[one] for one in TEXT.relations[:2]])
    np.testing.assert_allclose(posterior.belief(TARGET).ravel(), expected, atol=1e-12)
    shared = infer_description(texts[0], CITY, scaled("speaker"))[0].update(texts[1])
    expected = by_hand([TEXT.relations[:2]])
    np.testing.assert_allclose(shared.belief(TARGET).ravel(), expected, atol=1e-12)


@pytest.mark.parametrize("per", ["speaker", "relation", "ground"])
def test_every_engine_and_pyro_agree(per):
    model = scaled(per, lapse=0.1, temper=0.3)
    exact, _ = infer_description(TEXT, CITY, model)
    listed, _ = infer_description(TEXT, CITY, model, Enumerate(frame_bins=8))
    drawn, _ = infer_description(TEXT, CITY, model, Importance(8), rng=np.random.default_rng(0))
    for other in (listed, drawn):
        np.testing.assert_allclose(other.belief(TARGET), exact.belief(TARGET), atol=1e-12)
    elbo = TraceEnum_ELBO(max_plate_nesting=0)
    loss = elbo.loss(config_enumerate(build(TEXT, CITY, model)), lambda: None)
    assert -loss == pytest.approx(exact.log_evidence, abs=1e-9)


def test_it_is_drawn_as_a_picture_of_each_value():
    from sloop_ppl.plots import plot_latent

    posterior, _ = infer_description(TEXT, CITY, scaled("speaker"))
    axes = plot_latent(posterior, "off")
    assert axes.get_title() == "off"
    assert [label.get_text() for label in axes.get_yticklabels()] == ["0", "1"]
    shown = [text.get_text() for text in axes.texts]
    after = 100 * posterior.latent("off").values
    assert [float(text.split()[0]) for text in shown[-2:]] == pytest.approx(list(after), abs=0.6)


MINE = """
from dataclasses import dataclass
from sloop_ppl.models import LIKELIHOODS, Latent

@dataclass(frozen=True)
class Mine:
    latents = (Latent("off", (0, 1), (0.7, 0.3)),)

    def log_g(self, term, direction_rad):
        sound = LIKELIHOODS["student-vonmises"].log_g(term, direction_rad)
        return sound / (1.0 + 3.0 * term.latents["off"])
"""


def test_a_latent_of_a_file_is_saved_by_the_file(tmp_path):
    from sloop_ppl.models.user import load_model

    (tmp_path / "mine.py").write_text(MINE)
    model = load_model(f"{tmp_path / 'mine.py'}:Mine")
    city = load_map("cleveland")
    posterior, _ = infer_description(said(relation("near", "Ivy")), city, model)
    posterior.save(tmp_path / "kept.nc")
    again = Posterior.load(tmp_path / "kept.nc")
    assert again.latents == ("off",)
    np.testing.assert_array_equal(again.latent("off"), posterior.latent("off"))
    np.testing.assert_array_equal(again.belief(TARGET), posterior.belief(TARGET))


# -- frames -------------------------------------------------------------------------------------


def sense(to):
    """In one meaning the phrase is behind, in the other it says something without a frame."""
    return Latent(
        "sense",
        ("behind", to),
        (0.6, 0.4),
        concerns=lambda term: term.relation == "behind",
        given=lambda term, value: replace(term, relation=value),
    )


BEHIND = said(relation("behind", "House"), relation("near", "MainSt"))


def test_a_frame_that_only_one_meaning_has():
    model = replace(preset("bayes"), name="mine", latents=(sense("near"),))
    exact, _ = infer_description(BEHIND, CITY, model)
    listed, _ = infer_description(BEHIND, CITY, model, Enumerate())
    np.testing.assert_allclose(listed.belief(TARGET), exact.belief(TARGET), atol=1e-9)
    assert exact.framed(TARGET) == exact.frames(TARGET) == ()  # no one frame to tell of
    joint = exact.joint.probabilities("sense", f"{TARGET}/frame_0")
    np.testing.assert_allclose(joint.sum(1), exact.latent("sense"), atol=1e-9)
    _, mass = model.frame_prior_for(exact.grounded(TARGET)[0]).bins(72)
    np.testing.assert_allclose(joint[1] / joint[1].sum(), mass, atol=1e-9)  # tells nothing of it
    assert np.abs(joint[0] / joint[0].sum() - mass).max() > 1e-3
    assert exact.draws(TARGET, 3, rng=np.random.default_rng(0)).sizes["draw"] == 3
    drawn, _ = infer_description(
        BEHIND, CITY, model, Importance(2000), rng=np.random.default_rng(0)
    )
    np.testing.assert_allclose(drawn.belief(TARGET), exact.belief(TARGET), atol=1e-3)


def test_a_latent_that_changes_nothing_changes_nothing():
    other = Latent("far", (0, 1), (0.5, 0.5), given=lambda term, _: term)
    model = replace(preset("bayes"), name="mine", latents=(other,))
    posterior, _ = infer_description(BEHIND, CITY, model)
    plain, _ = infer_description(BEHIND, CITY, "bayes")
    np.testing.assert_allclose(posterior.belief(TARGET), plain.belief(TARGET), atol=1e-12)


def test_pyro_sums_a_model_that_cuts_where_phrases_exclude_each_other():
    contrary = said(relation("on", "House"), relation("on", "MainSt"))
    elbo = TraceEnum_ELBO(max_plate_nesting=0)
    loss = elbo.loss(config_enumerate(build(contrary, CITY, "sloop")), lambda: None)
    exact, _ = infer_description(contrary, CITY, "sloop")
    assert -loss == pytest.approx(exact.log_evidence, abs=1e-6)


def test_a_name_that_two_sites_would_have_is_refused():
    def latent(name, per="speaker"):
        return Latent(name, (0, 1), (0.5, 0.5), per=per, given=lambda term, _: term)

    for pair, message in (
        ((latent("q", "ground"), latent("q/House")), "Two latents have a site named 'q/House'"),
        ((latent("q"), latent("q[1]")), r"Latent 'q\[1\]' has a bracket"),
        ((latent("holds", "relation"),), "Latent 'holds' has a name that the program uses"),
        ((latent("x"),), "Latent 'x' has a name that the program uses"),
    ):
        with pytest.raises(InputError, match=message):
            infer_description(TEXT, CITY, replace(preset("bayes"), latents=pair))


def test_a_support_that_no_file_can_hold_is_not_saved(tmp_path):
    odd = Latent("q", ("a", ("t", 1)), (0.5, 0.5))
    posterior, _ = infer_description(TEXT, CITY, replace(preset("bayes"), latents=(odd,)))
    with pytest.raises(InputError, match="cannot be written"):
        posterior.save(tmp_path / "q.nc")


# -- what is refused ----------------------------------------------------------------------------


def denying(term, value):
    return replace(term, negated=not term.negated) if value else term


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (
            replace(preset("sloop"), latents=(Latent("a", (0, 1), (0.5, 0.5)),)),
            "cuts cells below uniform, which is not defined where phrases share a latent",
        ),
        (
            replace(preset("bayes"), latents=(Latent("a", (0, 1), (0.5, 0.5), given=denying),)),
            "expected it to leave `negated` alone",
        ),
        (
            replace(preset("bayes"), latents=(Latent("reliable", (0, 1), (0.5, 0.5)),)),
            "Latent 'reliable' has a name that the program uses",
        ),
        (
            replace(
                preset("bayes"),
                latents=(Latent("a", (0, 1), (0.5, 0.5), concerns=lambda term: term.nothing),),
            ),
            "`concerns` of latent 'a' fails for 'near House': AttributeError",
        ),
        (
            replace(
                preset("bayes"),
                latents=(Latent("a", (0, 1), (0.5, 0.5), given=lambda term, _: term.relation),),
            ),
            "`given` of latent 'a' returned 'near'",
        ),
    ],
)
def test_what_cannot_be_is_one_line(model, message):
    with pytest.raises(InputError, match=message) as caught:
        infer_description(TEXT, CITY, model)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"priors": {"sigma": 1.0}}, "is unknown|expected a distribution"),
        ({"log_prior": np.zeros(3)}, "log_prior is a ndarray of shape"),
        ({"log_prior": torch.zeros(1, 3)}, r"expected a torch tensor of shape \(1, 441\)"),
        ({"frame_bins": 7.5}, "frame_bins is 7.5; expected a whole number"),
        ({"frame_bins": 0}, "expected a whole number of angles above 0"),
    ],
)
def test_build_refuses_bad_options_in_one_line(options, message):
    with pytest.raises(InputError, match=message):
        build(TEXT, CITY, "bayes", **options)
    with pytest.raises(InputError, match="built of a str and a CityMap"):
        build("near the house", CITY)


def test_a_prior_that_is_a_distribution_is_taken():
    name = "near_m"
    with pytest.raises(InputError, match=f"prior of '{name}' is 0.5; expected a distribution"):
        build(TEXT, CITY, priors={name: 0.5})
    program = build(TEXT, CITY, priors={name: dist.LogNormal(0.0, 0.1)})
    assert math.isfinite(float(build_trace(program)))


def build_trace(program):
    import pyro

    return pyro.poutine.trace(program).get_trace().log_prob_sum()
