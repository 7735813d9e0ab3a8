"""The speaker run forward."""

from dataclasses import replace

import numpy as np
import pytest

import sloop_ppl as sloop
from sloop_ppl.errors import InputError
from sloop_ppl.language import SpatialRelation, TargetObject
from sloop_ppl.maps import bundled_maps
from sloop_ppl.models import ground_relations, log_phrase_given_front, preset
from sloop_ppl.models.simulate import SPEAKER, _word_chances, simulate
from sloop_ppl.models.templates import TEMPLATES, in_english, speakable_grounds
from sloop_ppl.models.vocabulary import SPEAKER_WORDS


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
        for word in SPEAKER_WORDS:
            relation = SpatialRelation("RedBike", word, (ground,))
            text = in_english([relation], [TargetObject("RedBike", ("red bike",))], city)
            (read,) = sloop.parse(text, city).relations
            assert (read.relation, read.grounds) == (word, (ground,)), text


def test_words_are_chosen_as_inference_weighs_them(city):
    about = SpatialRelation("RedBike", "front", ("Ivy",))
    (term,) = ground_relations((about,), city)
    for front, cell in ((0.3, 100), (-2.0, 900)):
        weighed = [
            float(
                log_phrase_given_front(
                    term.as_relation(word), SPEAKER, np.array([front]), lapse=False
                )[0, cell].exp()
            )
            for word in SPEAKER_WORDS
        ]
        assert sum(weighed) == pytest.approx(1.0)
        np.testing.assert_allclose(_word_chances(term, SPEAKER, front, cell), weighed, rtol=1e-9)


def test_latents_follow_their_priors(city):
    rng = np.random.default_rng(5)
    drawn = [simulate(city, ["RedBike"], rng, phrases=2).latents["RedBike"] for _ in range(600)]
    careless = np.mean([one.component == "careless" for one in drawn])
    slips = np.mean([slip for one in drawn for slip in one.lapses])
    # Five standard deviations: fails by chance once in a million.
    assert careless == pytest.approx(0.15, abs=5 * (0.15 * 0.85 / 600) ** 0.5)
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
        (preset("bayes"), "Model 'bayes' has 'map' normalisation, which gives words no"),
        (replace(preset("bayes"), normalisation="speaker"), "Component 'no-frame' of model"),
        (replace(SPEAKER, temper=0.5), "Model 'speaker' tempers, blurs or shares frames"),
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
    assert set(TEMPLATES) == set(SPEAKER_WORDS)
