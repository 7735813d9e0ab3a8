"""What a speaker says of a ground, at every cell and at chosen ones."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from sloop_ppl.language import RELATIONS
from sloop_ppl.models import LIKELIHOODS, FrameDistribution, FramePart, ground_relations
from sloop_ppl.models._speaker import frame_angle_masses
from sloop_ppl.models._vocabulary import speaker_words
from sloop_ppl.models.grounded_relation import word_options
from sloop_ppl.models.program import log_words, word_weights
from sloop_ppl.models.simulation import SPEAKER
from tests.phrases import log_phrase
from tests.scenes import house_and_street, relation, symmetric_grid

CITY = house_and_street(symmetric_grid(9), house=(12.0, -7.0), street_y=15.0)
CELLS = np.array([3, 40, 40, 77, 12])
PLAIN = replace(SPEAKER, lapse=0.0)


def term_of(word, ground="House", **said):
    spoken = replace(relation(word, ground), **said)
    (term,) = ground_relations((spoken,), CITY, joint=True)
    return term


@pytest.mark.parametrize("name", LIKELIHOODS)
@pytest.mark.parametrize("ground", ["House", "MainSt", "Map"])
def test_a_likelihood_at_some_cells_is_what_it_is_on_the_whole_map(name, ground):
    for word in sorted(RELATIONS):
        term = term_of(word, ground)
        directions = None
        if term.needs_frame:
            directions = torch.tensor([0.3, -2.0], dtype=torch.float64)
        elif term.compass_rad is not None:
            directions = torch.tensor([term.compass_rad], dtype=torch.float64)
        whole = LIKELIHOODS[name].log_g(term, directions)
        some = LIKELIHOODS[name].log_g(term.at(CELLS), directions)
        torch.testing.assert_close(some, whole[..., CELLS], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("ground", ["House", "MainSt"])
def test_a_word_is_chosen_by_the_softmax_of_all_of_them(ground):
    term = term_of("left", ground)
    angles_rad = np.array([0.1, 2.0, -1.0])
    options, chosen = word_options(term)
    assert options[chosen].relation == "left"
    by_hand = np.zeros((len(speaker_words()), 3, CITY.grid.size))
    for i, option in enumerate(options):
        towards = option.compass_rad
        for b, front in enumerate(angles_rad):
            angle = front + option.offset_rad if option.needs_frame else towards
            direction = None if angle is None else torch.tensor([angle], dtype=torch.float64)
            log_g = SPEAKER.likelihood.log_g(option, direction)
            by_hand[i, b] = np.exp(log_g.reshape(-1).numpy())
    by_hand /= by_hand.sum(0)
    weighed = word_weights(SPEAKER.likelihood, options, angles_rad)
    for i in range(len(options)):
        np.testing.assert_allclose(weighed.log_chance(i).exp(), by_hand[i], rtol=1e-9)


def test_a_meaning_outside_the_vocabulary_is_one_more_word():
    options, chosen = word_options(term_of("across", "MainSt"))
    assert (len(options), chosen) == (len(speaker_words()) + 1, len(speaker_words()))
    assert word_options(term_of("beside"))[1] == speaker_words().index("near")


def test_phrases_at_known_cells_are_those_of_the_whole_map():
    words = ["left", "near", "northeast", "front", "at"]
    denied = np.array([False, False, True, True, False])
    chosen = [speaker_words().index(word) for word in words]
    options, _ = word_options(term_of("near").at(CELLS))
    told = log_words(options, PLAIN, np.array(chosen), denied, n_angles=360)
    expected = [
        float(log_phrase(term_of(word, negated=bool(no)), CITY, PLAIN)[cell])
        for word, no, cell in zip(words, denied, CELLS, strict=True)
    ]
    np.testing.assert_allclose(told, expected, atol=1e-10)
    fewer = log_words(options, PLAIN, np.array(chosen), denied)
    np.testing.assert_allclose(fewer, expected, atol=1e-8)


def test_the_fronts_of_a_frame_carry_gradients_in_its_concentration():
    parts = (FramePart(0.4, 3.0, 0.5), FramePart(-2.0, np.inf, 0.3))
    frame = FrameDistribution(parts, lapse=0.2)
    angles, mass = frame.bins(36)
    angles_rad, log_mass = frame_angle_masses(frame, 36)
    np.testing.assert_allclose(angles_rad, angles, atol=1e-12)
    np.testing.assert_allclose(log_mass[:, 0].exp(), mass, atol=1e-12)
    kappa = torch.tensor([3.0, 5.0], dtype=torch.float64, requires_grad=True)
    learnt = FrameDistribution((replace(parts[0], kappa=kappa), parts[1]), lapse=0.2)
    angles_rad, log_mass = frame_angle_masses(learnt, 36)
    np.testing.assert_allclose(angles_rad, angles, atol=1e-12)
    np.testing.assert_allclose(log_mass[:, 0].detach().exp(), mass, atol=1e-12)
    np.testing.assert_allclose(log_mass.detach().exp().sum(0), 1)
    resultant = log_mass.exp().T @ torch.cos(angles_rad - 0.4)
    (slope,) = torch.autograd.grad(resultant.sum(), kappa)
    assert bool((slope > 0).all())  # the surer the front, the more of it lies that way


def test_every_word_has_the_front_that_decides_it():
    assert SPEAKER.frame_prior_for(term_of("near")) == SPEAKER.frame_prior_for(term_of("left"))
