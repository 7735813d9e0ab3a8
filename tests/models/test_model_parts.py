"""A model written as data is the model that is made from it again."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace

import pytest

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.models import (
    FRAME_PRIORS,
    LIKELIHOODS,
    PRESETS,
    Component,
    GaussianLikelihood,
    intervene,
    preset,
)
from sloop_ppl.models._model_parts import model_from_parts, parts_of
from sloop_ppl.models.tuning import with_parameters
from tests.mixture import MIXTURE


@dataclass(frozen=True)
class Mine:
    """The paper's likelihood by another name."""

    def log_g(self, term, direction_rad):
        return GaussianLikelihood().log_g(term, direction_rad)


def again(model):
    return model_from_parts(json.loads(json.dumps(parts_of(model))))


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_comes_back(name):
    assert again(preset(name)) == preset(name)


@pytest.mark.parametrize("name", LIKELIHOODS)
def test_every_likelihood_comes_back(name):
    model = replace(MIXTURE, likelihood=LIKELIHOODS[name])
    assert again(model) == model


@pytest.mark.parametrize("name", FRAME_PRIORS)
def test_every_frame_prior_comes_back(name):
    model = replace(MIXTURE, frame_prior=FRAME_PRIORS[name])
    assert again(model) == model


def test_numbers_and_switches_come_back():
    model = with_parameters(
        replace(MIXTURE, name="mine", likelihood=LIKELIHOODS["student-vonmises"]),
        {
            "likelihood": {"near_m": 11.5, "kappa_frame": 2.25},
            "model": {"lapse": 0.07, "temper": 0.4, "error_m": 3.0, "heed_distance": False},
            "frames": {"kappa": 1.5},
            "weights": {"at": 0.3},
        },
    )
    model = replace(
        model,
        normalisation="speaker",
        components=(*model.components, Component("uninformative", 0.1, combine="uninformative")),
    )
    assert again(model) == model


def test_the_papers_text_comes_back():
    assert again(preset("sloop-m4", "paper")) == preset("sloop-m4", "paper")


def test_a_component_set_from_outside_comes_back():
    model = intervene(MIXTURE, {"component": "near"})
    assert [part.name for part in again(model).components] == ["near"]


@pytest.mark.parametrize(
    ("model", "part"),
    [
        (replace(MIXTURE, likelihood=Mine()), "likelihood"),
        (replace(MIXTURE, likelihood=GaussianLikelihood(floor=1e-3)), "likelihood"),
        (intervene(MIXTURE, {"frame": 0.3}), "frame prior"),
    ],
)
def test_what_is_not_registered_is_named(model, part):
    told = f"The {part} of model 'mixture' is none of the registered ones"
    with pytest.raises(InputError, match=told):
        parts_of(model)


def test_a_model_registered_as_a_whole_goes_by_its_name(monkeypatch):
    monkeypatch.setattr(PRESETS, "_entries", dict(PRESETS._entries))
    PRESETS.add("own", replace(MIXTURE, name="own", likelihood=Mine()))
    assert parts_of(preset("own")) == {"name": "own", "variant": "published"}
    assert again(preset("own")) == preset("own")


def test_a_likelihood_of_ones_own_goes_by_its_name(monkeypatch):
    monkeypatch.setattr(LIKELIHOODS, "_entries", dict(LIKELIHOODS._entries))
    LIKELIHOODS.add("mine", Mine())
    model = preset(replace(MIXTURE, likelihood=Mine()))
    assert again(model) == model
    assert model.likelihood is not Mine()


@pytest.mark.parametrize(
    ("where", "change", "message"),
    [
        ((), {"lapses": 0.1}, "Part of a model 'lapses' is unknown.*did you mean 'lapse'"),
        (("likelihood", "parameters"), {"nearm": 3.0}, "'nearm' is unknown.*did you mean 'near_m'"),
        (("likelihood", "parameters"), {"near_m": -3.0}, "'near_m' is -3 m"),
        (("likelihood",), {"name": "boxx"}, "Likelihood 'boxx' is unknown"),
        (("likelihood",), {"name": "box"}, "Parameter of BoxLikelihood 'near_m' is unknown"),
        (("frame_prior", "numbers"), {"kapa": 1.0}, "'kapa' is unknown.*did you mean 'kappa'"),
        (("frame_prior", "numbers"), {"kappa": float("nan")}, "'kappa' is NaN"),
        (("frame_prior", "numbers"), {"lapse": 1.5}, "'lapse' of frames is 1.5"),
        (("frame_prior",), {"predictor": "nearest"}, "Frame predictor 'nearest' is unknown"),
        (("components", 0), {"combine": "prod"}, "Combination 'prod' is unknown"),
        (("components", 0), {"size": 1}, "Part of a component 'size' is unknown"),
        ((), {"lapse": 1.5}, "has lapse 1.5; expected"),
    ],
)
def test_what_is_unknown_or_out_of_range_is_named(where, change, message):
    parts = parts_of(MIXTURE)
    inner = parts
    for key in where:
        inner = inner[key]
    inner.update(change)
    with pytest.raises(InputError, match=message):
        model_from_parts(parts)


def test_what_is_missing_is_named():
    parts = parts_of(MIXTURE)
    del parts["temper"], parts["components"]
    with pytest.raises(InputError, match="part of a model is missing: temper, components"):
        model_from_parts(parts)
    with pytest.raises(UnknownName, match="Model 'bays' is unknown"):
        model_from_parts({"name": "bays", "variant": "published"})


def test_infinite_concentrations_are_data():
    model = replace(MIXTURE, frame_prior=FRAME_PRIORS["fixed"])
    assert math.isinf(again(model).frame_prior.kappa)
