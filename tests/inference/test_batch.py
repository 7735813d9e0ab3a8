from dataclasses import replace

import numpy as np
import pytest

import sloop_ppl as sloop
from sloop_ppl.errors import BeliefCollapse, InputError
from sloop_ppl.inference import infer_batch, infer_description
from sloop_ppl.models import preset

TEXTS = (
    "the red bike is behind Velvet Dog and left of Ivy",
    "the green toyota is near Rumor, and the red bike is in front of Ivy and north of Rumor",
    "the red honda is not near Ivy",
)


@pytest.fixture(scope="module")
def city():
    return sloop.load_map("cleveland")


@pytest.fixture(scope="module")
def said(city):
    return [sloop.parse(text, city) for text in TEXTS]


@pytest.mark.parametrize("name", ["bayes", "sloop", "sloop-m4", "keyword", "shared"])
def test_a_batch_is_what_each_gives_alone(city, said, name, monkeypatch):
    monkeypatch.setattr("sloop_ppl.inference.infer._TOGETHER", 3)  # of four targets
    model = replace(preset("bayes"), shared_frames=True) if name == "shared" else preset(name)
    for beliefs, description in zip(infer_batch(said, city, model), said, strict=True):
        alone, _ = infer_description(description, city, model)
        assert tuple(beliefs) == alone.targets
        for target, belief in beliefs.items():
            np.testing.assert_allclose(belief, alone.belief(target), atol=1e-12)


def test_a_prior_counts(city, said):
    prior = np.zeros(city.grid.shape)
    prior[3, 4] = 1.0
    for beliefs in infer_batch(said, city, prior=prior):
        for belief in beliefs.values():
            assert belief[3, 4] == pytest.approx(1.0)


def test_nothing_gives_nothing(city):
    assert infer_batch([], city) == ()


def test_bad_input(city, said):
    with pytest.raises(InputError, match="infer each description by itself"):
        infer_batch(said, city, "informed")
    with pytest.raises(InputError, match="was read on map 'cleveland'; expected 'austin'"):
        infer_batch(said, sloop.load_map("austin"))
    assert issubclass(BeliefCollapse, InputError)
