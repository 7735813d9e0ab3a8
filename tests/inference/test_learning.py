"""Parameters learnt from known cells."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

import sloop_ppl as sloop
from sloop_ppl.errors import InputError
from sloop_ppl.inference import infer_description
from sloop_ppl.inference.learning import Example, _Free, _grouped, _scores, fit, log_scores
from sloop_ppl.models import LIKELIHOODS, preset
from sloop_ppl.models.simulate import SPEAKER, simulate
from sloop_ppl.models.tuning import load_parameters, with_parameters


@pytest.fixture(scope="module")
def examples():
    city = sloop.load_map("cleveland", cell_m=10.0)
    rng = np.random.default_rng(0)
    drawn = [simulate(city, ["RedBike"], rng, phrases=2) for _ in range(12)]
    return [
        Example(one.description, city, {"RedBike": one.latents["RedBike"].cell}) for one in drawn
    ]


@pytest.fixture(scope="module")
def model():
    student = replace(preset("bayes"), likelihood=LIKELIHOODS["student-vonmises"])
    return replace(student, lapse=0.1, temper=0.3)


def test_the_score_is_that_of_the_posterior(examples, model):
    expected = []
    for example in examples:
        posterior, _ = infer_description(example.description, example.city, model)
        expected.append(math.log(posterior.belief("RedBike")[example.cells["RedBike"]]))
    np.testing.assert_allclose(log_scores(examples, model).numpy(), expected, atol=1e-9)


def test_every_learnt_number_has_the_right_gradient(examples, model):
    free = _Free(model, ["near_m", "tail", "kappa_frame", "lapse", "temper", "kappa", "weights"])
    groups = _grouped(examples, model)

    def loss(z):
        return torch.cat([_scores(free.at(z), free.log_weights(z), g) for g in groups]).sum()

    z = free.start.clone().requires_grad_(True)
    (gradient,) = torch.autograd.grad(loss(z), z)
    for i in range(len(z)):
        step = torch.zeros_like(z)
        step[i] = 1e-5
        with torch.no_grad():
            slope = float((loss(z + step) - loss(z - step)) / 2e-5)
        assert float(gradient[i]) == pytest.approx(slope, rel=1e-4, abs=1e-5), i
    assert bool((gradient.abs() > 1e-6).all())


def test_fitting_raises_the_score_and_what_it_found_reloads(examples, model, tmp_path):
    lines = []
    found = fit(
        examples, model, learn=["near_m", "directed_m", "lapse", "weights"], iterations=10,
        progress=lines.append,
    )  # fmt: skip
    told = found.provenance
    assert told["mean_log_score_after"] > told["mean_log_score_before"]
    assert told["targets"] == 12
    assert lines[0].startswith("5 iterations: mean log score")
    found.save(tmp_path / "fitted.json")
    tuned = with_parameters(model, load_parameters(tmp_path / "fitted.json"))
    assert tuned == found.apply(model)
    score = float(log_scores(examples, tuned).mean())
    assert score == pytest.approx(told["mean_log_score_after"], abs=1e-6)


def test_what_is_held_out_stops_it(examples, model):
    found = fit(examples[:6], model, learn=["lapse"], held_out=examples[6:], iterations=200)
    assert found.provenance["iterations"] < 200
    assert found.provenance["held_out"] == 6


def test_numbers_without_data_keep_their_prior(examples, model):
    found = fit(examples[:1], model, learn=["between_m"], iterations=5)
    assert found.parameters["likelihood"]["between_m"] == pytest.approx(8.0)


@pytest.mark.parametrize(
    ("changed", "learn", "message"),
    [
        ({}, ["width"], "'width' of model 'bayes' cannot be learnt; expected one of contact_m"),
        ({}, [], "Model 'bayes' has nothing to learn"),
        ({"shared_frames": True}, None, "such a model cannot be fitted"),
    ],
)
def test_what_cannot_be_learnt(examples, model, changed, learn, message):
    with pytest.raises(InputError, match=message):
        fit(examples, replace(model, **changed), learn=learn)


def test_no_cell_is_known(examples, model):
    blind = replace(examples[0], cells={})
    with pytest.raises(InputError, match="No example says anything of a target whose cell"):
        fit([blind], model)


def test_a_speaker_s_frames_are_not_among_what_is_learnt():
    with pytest.raises(InputError, match="'kappa' of model 'speaker' cannot be learnt"):
        _Free(SPEAKER, ["kappa"])
