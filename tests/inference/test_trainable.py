"""A model that is being trained can be asked all that any other can."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.inference import infer_batch, infer_description
from sloop_ppl.models import LIKELIHOODS, GaussianLikelihood, preset
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(9), house=(6.0, -8.0), street_y=18.0)
SAID = said(relation("behind", "House"), relation("front", "House"), relation("near", "MainSt"))
PLAIN = replace(preset("bayes"), likelihood=LIKELIHOODS["neural"], lapse=0.1)
TRAINING = replace(PLAIN, likelihood=LIKELIHOODS["neural"].trainable())


@pytest.mark.parametrize("shared", [False, True])
def test_every_question_has_the_same_answer(shared):
    plain, training = (
        infer_description(SAID, CITY, replace(model, shared_frames=shared))[0]
        for model in (PLAIN, TRAINING)
    )
    np.testing.assert_allclose(plain.belief(TARGET), training.belief(TARGET), rtol=1e-9)
    for ask in (
        lambda p: [one.mean_rad for one in p.frames(TARGET)],
        lambda p: [one.p for one in p.lapses(TARGET)],
        lambda p: [one.bits for one in p.influence(TARGET)],
        lambda p: p.frame(TARGET, relation=0).values.tolist(),
        lambda p: p.draws(TARGET, 5, rng=np.random.default_rng(0))["front"].values.tolist(),
        lambda p: [table.tolist() for table in p.phrase_tables(TARGET)],
    ):
        np.testing.assert_allclose(ask(training), ask(plain), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("engine", ["enumerate", "importance"])
def test_other_engines_run_it_too(engine):
    plain, training = (
        infer_description(SAID, CITY, model, engine, rng=np.random.default_rng(0))[0]
        for model in (PLAIN, TRAINING)
    )
    np.testing.assert_allclose(plain.belief(TARGET), training.belief(TARGET), rtol=1e-9)
    (batched,) = infer_batch([SAID], CITY, TRAINING)
    assert batched[TARGET].sum() == pytest.approx(1)


@pytest.mark.parametrize("model", [None, 3, GaussianLikelihood()])
def test_what_is_no_model_is_refused(model):
    with pytest.raises(InputError, match=r"expected a name of .* or an ObservationModel"):
        infer_description(SAID, CITY, model)


def test_a_seed_is_no_generator():
    with pytest.raises(InputError, match="rng is a int; expected a generator"):
        infer_description(SAID, CITY, engine="importance", rng=3)
