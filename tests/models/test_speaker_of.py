"""A listener's speaker form gives each phrase a probability and runs forward."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference import infer_description, rank_models
from sloop_ppl.maps import load_map
from sloop_ppl.models import Component, Latent, preset, speaker_of
from sloop_ppl.models.simulation import SPEAKER, simulate
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(9, 10.0), house=(12.0, -7.0), street_y=30.0)


def test_what_becomes_of_bayes():
    listener, speaker = preset("bayes"), speaker_of("bayes")
    assert speaker.normalisation == "speaker"
    assert speaker.temper == speaker.error_m == 0
    assert speaker.lapse == listener.lapse
    assert speaker.likelihood == listener.likelihood
    literal, uninformative = speaker.components
    assert literal == Component("literal", listener.components[0].weight)
    assert (uninformative.name, uninformative.combine) == ("uninformative", "uninformative")
    assert uninformative.weight == pytest.approx(listener.components[1].weight)
    assert speaker_of(speaker) is speaker
    assert speaker_of(SPEAKER) == SPEAKER


@pytest.mark.parametrize("name", ["bayes", "sloop", "sloop-m2", "sloop-m4"])
def test_it_runs_forward_and_what_it_says_is_understood(name):
    city = load_map("cleveland")
    drawn = simulate(city, ["RedBike"], np.random.default_rng(0), model=name, phrases=2)
    assert len(drawn.description.relations) == 2
    posterior, _ = infer_description(drawn.description, city, name)
    assert posterior.speaking().belief("RedBike").sum() == pytest.approx(1)


def test_the_words_that_could_have_been_said_have_probabilities_that_sum_to_one():
    """The evidence of one phrase, summed over all words of its ground."""
    from sloop_ppl.models._vocabulary import speaker_words

    total = sum(
        np.exp(float(infer_description(said(relation(w, "House")), CITY, "bayes")[0]
                     .speaking().log_evidence))
        for w in speaker_words()
    )  # fmt: skip
    assert total == pytest.approx(1, abs=1e-6)


def test_models_are_ranked_by_their_speaker_forms():
    what = said(relation("near", "House"), relation("on", "MainSt"))
    forms = {n: infer_description(what, CITY, n)[0].speaking() for n in ("bayes", "sloop")}
    first, second = rank_models(forms)
    assert first.bits_behind == 0 < second.bits_behind


def test_utterances_are_those_of_the_models_own_speaker(monkeypatch):
    city = load_map("cleveland")
    posterior, _ = infer_description(said(relation("near", "Ivy")), city, "bayes")
    (one,) = posterior.utterances(TARGET, 1, rng=np.random.default_rng(0))
    (own,) = posterior.utterances(
        TARGET, 1, rng=np.random.default_rng(0), speaker=speaker_of("bayes")
    )
    assert one == own


def test_what_cannot_speak_says_so():
    for name in ("uniform", "keyword", "informed"):
        with pytest.raises(InputError, match=f"Model '{name}' has no component that is a plain"):
            speaker_of(name)
    latent = Latent("which", ("a", "b"), (0.5, 0.5))
    with pytest.raises(InputError, match="declares latents, which a speaker does not draw"):
        speaker_of(replace(preset("bayes"), latents=(latent,)))
    with pytest.raises(UnknownName, match="Model 'nobody' is unknown"):
        speaker_of("nobody")
