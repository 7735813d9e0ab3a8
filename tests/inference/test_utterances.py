from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import sloop_ppl as sloop
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference import infer_description
from sloop_ppl.models import preset
from sloop_ppl.models.simulation import SPEAKER
from tests.scenes import TARGET, relation, said

CITY = sloop.load_map("cleveland")
PRIOR = np.zeros(CITY.grid.shape)
PRIOR[CITY.grid.cell_at(-22.5, -37.5)] = 1.0  # on Velvet Dog
POSTERIOR = infer_description(said(relation("at", "VelvetDog")), CITY, prior=PRIOR)[0]


def test_what_is_said_fits_where_the_target_is():
    careful = replace(SPEAKER, lapse=0.0, components=SPEAKER.components[:1])
    drawn = POSTERIOR.utterances(
        TARGET, 60, rng=np.random.default_rng(0), speaker=careful, grounds=["VelvetDog"]
    )
    words = [one.description.relations[0].relation for one in drawn]
    assert {one.latents[TARGET].cell for one in drawn} == {CITY.grid.cell_at(-22.5, -37.5)}
    assert sum(word in ("at", "near") for word in words) > len(words) / 4


def test_places_are_drawn_from_the_belief():
    spread = infer_description(said(relation("near", "VelvetDog")), CITY)[0]
    drawn = spread.utterances(TARGET, 40, rng=np.random.default_rng(1), phrases=(1, 2))
    places = np.array([one.latents[TARGET].place_m for one in drawn])
    assert len({tuple(place) for place in places}) > 15
    apart = np.hypot(*(places - spread.expected(TARGET)).T).mean()
    assert apart == pytest.approx(
        spread.expected_distance(TARGET, spread.expected(TARGET)), rel=0.5
    )
    assert {len(one.description.relations) for one in drawn} == {1, 2}


def test_the_same_seed_gives_the_same_words_one_by_one():
    first, second = (POSTERIOR.utterances(TARGET, n, rng=np.random.default_rng(2)) for n in (3, 5))
    texts = [one.description.text for one in second]
    assert [one.description.text for one in first] == texts[:3]
    assert len(set(texts)) > 1


def test_utterances_that_cannot_be_drawn():
    rng = np.random.default_rng(0)
    with pytest.raises(InputError, match="n is 0; expected at least one utterance"):
        POSTERIOR.utterances(TARGET, 0, rng=rng)
    with pytest.raises(UnknownName, match="Target 'Bus' is unknown"):
        POSTERIOR.utterances("Bus", 1, rng=rng)
    with pytest.raises(InputError, match="so it cannot speak"):
        POSTERIOR.utterances(TARGET, 1, rng=rng, speaker=preset("keyword"))
