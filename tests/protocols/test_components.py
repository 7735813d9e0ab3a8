"""Every registered combination, component set and normalisation keeps its promises."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
import torch

from sloop_ppl.inference import infer_description
from sloop_ppl.inference._enumeration import description_tables, enumerated_sites
from sloop_ppl.models import (
    COMBINATIONS,
    PRESETS,
    Component,
    Program,
    ground_description,
    ground_relations,
    preset,
    program_data,
)
from sloop_ppl.models._vocabulary import speaker_words
from sloop_ppl.models.presets import Normalisation
from tests.phrases import log_phrase, log_phrase_given_frame
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(11), house=(6.0, -8.0), street_y=20.0)
BAYES = preset("bayes")
WORDS = (
    relation("behind", "House"),
    relation("near", "MainSt"),
    relation("left", "House"),
    relation("on", "House", negated=True),
    relation("south", "MainSt"),
)
SAID = said(*WORDS)
NORMALISATIONS = get_args(Normalisation)
LISTENING = [name for name in PRESETS if not preset(name).needs_truth]


def program_of(model, what=SAID):
    """The program with frames, lapses and all that is of one phrase summed out."""
    return Program(program_data(ground_description(what, CITY, model), CITY, model), "summed")


def with_normalisation(name):
    return replace(BAYES, name=name, normalisation=name, lapse=0.05)


# -- combinations ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", COMBINATIONS)
@pytest.mark.parametrize("count", [1, 2, 5])
def test_a_combination_gives_rows_of_log_probabilities(name, count):
    terms = ground_relations(WORDS[:count], CITY)
    rows = COMBINATIONS[name](terms, lambda term: log_phrase(term, CITY, BAYES))
    assert rows.dim() == 2
    assert 1 <= len(rows) <= count
    assert rows.shape[1] == CITY.grid.size
    assert rows.dtype == torch.float64
    assert torch.isfinite(rows).all()
    assert (rows <= 1e-12).all()


@pytest.mark.parametrize("name", COMBINATIONS)
def test_a_combination_does_not_heed_the_order(name):
    terms = ground_relations(WORDS, CITY)
    one, other = (
        COMBINATIONS[name](some, lambda term: log_phrase(term, CITY, BAYES)).sum(0)
        for some in (terms, terms[::-1])
    )
    torch.testing.assert_close(one, other, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", COMBINATIONS)
def test_a_combination_makes_a_model_of_its_own(name):
    model = replace(BAYES, components=(Component("only", combine=name),))
    posterior = infer_description(SAID, CITY, model)[0]
    assert posterior.belief(TARGET).sum() == pytest.approx(1)
    assert posterior.component(TARGET) == {"only": pytest.approx(1.0)}


# -- component sets -------------------------------------------------------------------------------


@pytest.mark.parametrize("name", LISTENING)
def test_weights_are_those_of_the_components_that_apply(name):
    model = preset(name)
    weights = program_of(model).data.log_weight[0].exp()
    assert float(weights.sum()) == pytest.approx(1)
    every = np.array([part.weight for part in model.components])
    applies = (weights > 0).numpy()
    np.testing.assert_allclose(weights, every * applies / (every * applies).sum(), rtol=1e-12)
    assert applies[0], "the first component stands for all when nothing else applies"


@pytest.mark.parametrize("name", LISTENING)
def test_the_order_of_relations_is_irrelevant(name):
    one = infer_description(SAID, CITY, name)[0].belief(TARGET)
    other = infer_description(said(*WORDS[::-1]), CITY, name)[0].belief(TARGET)
    np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-15)
    assert one.sum() == pytest.approx(1)


@pytest.mark.parametrize("name", LISTENING)
@pytest.mark.parametrize("words", [(), WORDS[:1], WORDS[2:3], WORDS[3:4]])
def test_whatever_is_said_some_component_applies(name, words):
    """Nothing; frame words alone; a denied phrase alone."""
    posterior = infer_description(said(*words), CITY, name)[0]
    assert posterior.belief(TARGET).sum() == pytest.approx(1)
    assert np.isfinite(posterior.log_evidence)


@pytest.mark.parametrize("name", [name for name in LISTENING if len(preset(name).components) > 1])
def test_the_mixture_is_the_weighted_mean_of_its_components(name):
    """Under 'map' normalisation, by each component's own model."""
    model = preset(name)
    mixture = np.zeros(CITY.grid.shape)
    weights = program_of(model).data.log_weight[0].exp().tolist()
    for part, weight in zip(model.components, weights, strict=True):
        if weight:
            alone = replace(model, components=(part,))
            mixture += weight * infer_description(SAID, CITY, alone)[0].belief(TARGET)
    got = infer_description(SAID, CITY, model)[0].belief(TARGET)
    np.testing.assert_allclose(got, mixture, rtol=1e-9, atol=1e-15)


# -- normalisations -------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NORMALISATIONS)
def test_tables_are_log_probabilities(name):
    sites = enumerated_sites(program_of(with_normalisation(name)))
    holds = [sites[f"{TARGET}/holds_{j}"].values for j in range(len(WORDS))]
    holds += [sites[site].values for site in (f"{TARGET}/together",) if site in sites]
    for log_p in holds:
        assert torch.isfinite(log_p).all()
        assert (log_p <= 1e-12).all()
    for factor in {f"{TARGET}/{site}" for site in ("temper", "normaliser")} & set(sites):
        assert torch.isfinite(sites[factor].values).all()


@pytest.mark.parametrize("name", NORMALISATIONS)
def test_updates_commute_and_order_is_irrelevant(name):
    model = with_normalisation(name)
    first, second = said(*WORDS[:2]), said(*WORDS[2:])
    one = infer_description(first, CITY, model)[0].update(second).belief(TARGET)
    other = infer_description(second, CITY, model)[0].update(first).belief(TARGET)
    np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("name", NORMALISATIONS)
def test_a_phrase_is_the_mean_over_its_fronts(name):
    model = with_normalisation(name)
    for word in WORDS[:3]:
        (term,) = ground_relations((word,), CITY)
        prior = model.frame_prior(term.as_relation("front") if name == "speaker" else term)
        fronts, mass = prior.bins(720)
        given = log_phrase_given_frame(term, CITY, model, fronts).exp()
        mean = torch.from_numpy(mass) @ given
        torch.testing.assert_close(mean, log_phrase(term, CITY, model).exp(), rtol=1e-4, atol=1e-7)


def test_truth_leaves_phrases_as_they_are():
    plain = replace(with_normalisation("truth"), temper=0.0)
    sites = enumerated_sites(program_of(plain))
    spoken = {f"{TARGET}/holds_{j}" for j in range(len(WORDS))}
    assert set(sites) - spoken <= {f"{TARGET}/{site}" for site in ("component", "cell")}


def test_map_makes_each_component_a_distribution_over_cells():
    program = program_of(with_normalisation("map"))
    (log_p,) = description_tables(program)  # the components' weights are part of it
    log_weight = program.data.log_weight[0]
    sums = torch.logsumexp(log_p, -1) - log_weight
    sums = sums[log_weight > -torch.inf]
    torch.testing.assert_close(sums, torch.zeros_like(sums), atol=1e-9, rtol=0)


def test_speaker_makes_words_a_distribution_at_every_cell():
    """Given ground, cell and front the words that could be said sum to one."""
    model = replace(with_normalisation("speaker"), lapse=0.0)
    fronts = np.linspace(-np.pi, np.pi, 7)
    total = sum(
        log_phrase_given_frame(term, CITY, model, fronts).exp()
        for term in ground_relations(
            tuple(relation(word, "House") for word in speaker_words()), CITY
        )
    )
    torch.testing.assert_close(total, torch.ones_like(total))
