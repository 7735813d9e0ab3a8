"""The speaker run forward."""

from dataclasses import replace

import numpy as np
import pytest

import sloop_ppl as sloop
from sloop_ppl.errors import InputError
from sloop_ppl.language import SpatialRelation, TargetObject
from sloop_ppl.maps import bundled_maps
from sloop_ppl.models import Latent, preset
from sloop_ppl.models._vocabulary import in_english, speakable_grounds, speaker_words
from sloop_ppl.models.simulation import (
    SPEAKER,
    _choose_words,
    _Ground,
    _Phrase,
    _word_chances,
    simulate,
)
from tests.phrases import log_phrase_given_frame

DECLARED = replace(SPEAKER, latents=(Latent("mood", ("good", "bad"), (0.5, 0.5)),))


@pytest.fixture(scope="module")
def city():
    return sloop.load_map("cleveland")


@pytest.mark.parametrize("name", bundled_maps())
def test_the_parser_reads_back_what_is_said(name):
    city = sloop.load_map(name)
    rng = np.random.default_rng(0)
    for _ in range(25):
        said = simulate(city, ["RedBike", "GreenToyota"], rng).description
        read = sloop.parse(said.text, city)
        assert [(r.figure, r.relation, r.grounds) for r in read.relations] == [
            (r.figure, r.relation, r.grounds) for r in said.relations
        ]


def test_every_word_of_every_ground_is_read_back(city):
    for ground in speakable_grounds(city)[:3]:
        for word in speaker_words():
            relation = SpatialRelation("RedBike", word, (ground,))
            text = in_english([relation], [TargetObject("RedBike", ("red bike",))], city)
            (read,) = sloop.parse(text, city).relations
            assert (read.relation, read.grounds) == (word, (ground,)), text


def test_words_are_chosen_as_inference_weighs_them(city):
    about = _Ground.of("Ivy", city, SPEAKER)
    places = [(0.3, 100), (-2.0, 900), (1.0, 100)]
    phrases = [_Phrase(about, cell, front, False, False, 0.5) for front, cell in places]
    chosen = _word_chances(phrases, SPEAKER)
    unfailing = replace(SPEAKER, lapse=0.0)
    np.testing.assert_allclose(chosen.sum(1), 1)
    for (front, cell), chances in zip(places, chosen, strict=True):
        weighed = [
            float(
                log_phrase_given_frame(
                    about.term.as_relation(word), city, unfailing, np.array([front])
                )[0, cell].exp()
            )
            for word in speaker_words()
        ]
        np.testing.assert_allclose(chances, weighed, rtol=1e-9)


def test_each_word_is_said_as_often_as_it_is_likely(city):
    about = _Ground.of("Ivy", city, SPEAKER)
    level = (np.arange(400) + 0.5) / 400
    phrases = [_Phrase(about, 100, 0.3, False, False, float(u)) for u in level]
    said = list(_choose_words(phrases, SPEAKER))
    chances = _word_chances(phrases[:1], SPEAKER)[0]
    for word, chance in zip(speaker_words(), chances, strict=True):
        assert said.count(word) == pytest.approx(400 * chance, abs=1), word
    slips = [_Phrase(about, 100, 0.3, True, True, float(u)) for u in level]
    assert set(_choose_words(slips, SPEAKER)) == set(speaker_words())


def test_latents_follow_their_priors(city):
    names = [f"T{i}" for i in range(600)]
    told = simulate(city, names, np.random.default_rng(5), phrases=2).latents
    drawn = [told[name] for name in names]
    uninformative = np.mean([one.component == "uninformative" for one in drawn])
    slips = np.mean([slip for one in drawn for slip in one.lapses])
    # Five standard deviations: fails by chance once in a million.
    assert uninformative == pytest.approx(0.15, abs=5 * (0.15 * 0.85 / 600) ** 0.5)
    assert slips == pytest.approx(0.1, abs=5 * (0.1 * 0.9 / 1200) ** 0.5)
    rows = np.array([one.cell for one in drawn])
    np.testing.assert_allclose(rows.mean(0), 20, atol=5 * 11.8 / 600**0.5)


def test_a_prior_places_the_target_and_grounds_are_chosen(city):
    prior = np.zeros(city.grid.shape)
    prior[7, 9] = 1.0
    rng = np.random.default_rng(0)
    drawn = simulate(city, ["MyDog"], rng, phrases=1, grounds=["Ivy"], prior=prior)
    assert drawn.latents["MyDog"].cell == (7, 9)
    assert drawn.latents["MyDog"].place_m == (city.grid.x_m[9], city.grid.y_m[7])
    assert drawn.description.relations[0].grounds == ("Ivy",)


def test_the_same_seed_says_the_same(city):
    one, other = (simulate(city, ["RedBike"], np.random.default_rng(3)) for _ in range(2))
    assert one == other


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (preset("informed"), "Model 'informed' has no component that is a plain product"),
        (preset("keyword"), "Model 'keyword' has no component that is a plain product"),
        (DECLARED, "Model 'speaker' declares latents, which a speaker does not draw"),
    ],
)
def test_what_cannot_be_run_forward_is_refused(city, model, message):
    with pytest.raises(InputError, match=message):
        simulate(city, ["RedBike"], np.random.default_rng(0), model=model)


def test_bad_input(city):
    with pytest.raises(InputError, match="should get 2 to 2 phrases; expected 1 to 1"):
        simulate(city, ["RedBike"], np.random.default_rng(0), phrases=2, grounds=["Ivy"])
    with pytest.raises(InputError, match="Relation 'between' of 1 grounds has no template"):
        in_english(
            [SpatialRelation("RedBike", "between", ("Ivy",))], [TargetObject("RedBike")], city
        )
