"""The speaker is the unit: what one says in two texts is one longer text; several multiply."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.inference import Posterior, infer_description
from sloop_ppl.maps import load_map
from sloop_ppl.models import PredictedSpread, preset
from tests.mixture import MIXTURE
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(15), house=(12.0, -7.0), street_y=30.0)
BAYES = preset("bayes")
MODELS = {
    "bayes": BAYES,
    "sloop-m4": preset("sloop-m4"),
    "tempered mixture": replace(MIXTURE, temper=0.5, lapse=0.1),
    "shared error": replace(BAYES, error_m=8.0),
    "unreliable": replace(BAYES, unreliable=0.2),
    "shared frames": replace(
        BAYES, shared_frames=True, frame_prior=PredictedSpread(kappa=0.5, lapse=0.0, absolute=0.0)
    ),
}
PHRASES = (
    relation("behind", "House"),
    relation("near", "MainSt", negated=True),
    relation("left", "House"),
    relation("south", "MainSt", figure="Other"),
)


def by(speaker, *relations):
    return replace(said(*relations, targets=(TARGET, "Other")), speaker=speaker)


def apart(one, other):
    return max(0.5 * np.abs(one.belief(t) - other.belief(t)).sum() for t in (TARGET, "Other"))


@pytest.mark.parametrize("name", MODELS)
def test_updates_by_one_speaker_are_one_longer_description(name):
    whole, _ = infer_description(by("Ann", *PHRASES), CITY, MODELS[name])
    for order in itertools.islice(itertools.permutations(PHRASES), 0, 24, 5):
        part, _ = infer_description(by("Ann", order[0]), CITY, MODELS[name])
        for phrase in order[1:]:
            part = part.update(by("Ann", phrase))
        assert apart(part, whole) < 1e-9
        assert float(part.log_evidence) == pytest.approx(float(whole.log_evidence), abs=1e-9)
        assert len(part.factors) == 1
        assert len(part.descriptions) == 4


@pytest.mark.parametrize("name", MODELS)
def test_several_speakers_multiply(name):
    """Beliefs from a uniform prior multiply, cell by cell."""
    alone = [
        infer_description(by(None, phrase), CITY, MODELS[name])[0].belief(TARGET)
        for phrase in PHRASES[:3]
    ]
    for speakers in (("Ann", "Bo", "Cy"), (None, None, None), ("Ann", None, "Bo")):
        texts = [by(s, p) for s, p in zip(speakers, PHRASES[:3], strict=True)]
        together, _ = infer_description(texts[0], CITY, MODELS[name])
        for text in texts[1:]:
            together = together.update(text)
        expected = alone[0] * alone[1] * alone[2]
        np.testing.assert_allclose(
            together.belief(TARGET), expected / expected.sum(), rtol=1e-8, atol=1e-14
        )


def test_the_order_of_two_speakers_texts_is_irrelevant():
    texts = [
        by("Ann", PHRASES[0]),
        by("Bo", PHRASES[1]),
        by("Ann", PHRASES[2]),
        by("Bo", PHRASES[3]),
    ]
    found = []
    for order in itertools.permutations(range(4)):
        posterior, _ = infer_description(texts[order[0]], CITY, BAYES)
        for i in order[1:]:
            posterior = posterior.update(texts[i])
        found.append(posterior)
    assert max(apart(found[0], other) for other in found[1:]) < 1e-9
    assert {len(p.factors) for p in found} == {2}


def test_shared_frames_do_not_depend_on_the_order():
    model = replace(BAYES, shared_frames=True)
    told = (relation("front", "House"), relation("left", "House"))
    one, other = (
        infer_description(said(*some), CITY, model)[0].belief(TARGET) for some in (told, told[::-1])
    )
    np.testing.assert_allclose(one, other, atol=1e-12)


def test_a_model_that_is_told_the_place_keeps_it():
    place = {TARGET: (10.0, 5.0)}
    first, _ = infer_description(said(relation("near", "House")), CITY, "informed", truth=place)
    after = first.update(said(relation("on", "MainSt")))
    x, y = after.expected(TARGET)
    assert abs(x - 10.0) < 5
    assert abs(y - 5.0) < 5


def test_one_speaker_is_tempered_by_all_that_was_said():
    """Two equal phrases of one speaker weigh less than those of two speakers."""
    near = relation("near", "House")
    one = infer_description(by("Ann", near), CITY, BAYES)[0]
    same, other = one.update(by("Ann", near)), one.update(by("Bo", near))
    assert other.entropy(TARGET) < same.entropy(TARGET) < one.entropy(TARGET)


def test_questions_count_relations_on_whoever_speaks():
    posterior, _ = infer_description(by("Ann", PHRASES[0]), CITY, BAYES)
    posterior = posterior.update(by("Bo", PHRASES[1])).update(by("Ann", PHRASES[2]))
    words = [r.relation for r in posterior.relations(TARGET)]
    assert words == ["behind", "left", "near"], "speaker by speaker"
    assert [lapse.relation.relation for lapse in posterior.lapses(TARGET)] == words
    assert [i.relation.relation for i in posterior.influence(TARGET)] == words
    assert len(posterior.phrase_tables(TARGET)) == 3
    assert [f.relation for f in posterior.framed(TARGET)] == [0, 1]
    without = infer_description(by("Ann", PHRASES[0]), CITY, BAYES)[0].update(by("Bo", PHRASES[1]))
    np.testing.assert_allclose(
        posterior.influence(TARGET)[1].without, without.belief(TARGET), atol=1e-12
    )


def test_speakers_survive_saving(tmp_path):
    city = load_map("cleveland")
    first = replace(said(relation("behind", "VelvetDog")), speaker="Ann")
    posterior, _ = infer_description(first, city)
    posterior = posterior.update(replace(said(relation("near", "Ivy")), speaker="Bo"))
    posterior.save(tmp_path / "p.nc")
    again = Posterior.load(tmp_path / "p.nc")
    more = replace(said(relation("left", "Ivy")), speaker="Ann")
    np.testing.assert_allclose(
        again.update(more).belief(TARGET), posterior.update(more).belief(TARGET), atol=1e-12
    )
    assert [f.speaker for f in again.factors] == ["Ann", "Bo"]


def test_an_unreliable_speaker_is_believed_less_where_phrases_contradict_each_other():
    """By hand: (1 - u) of the product of phrases and u of nothing, for one target, temper 0."""
    model = replace(BAYES, lapse=0.0, temper=0.0, unreliable=0.25)
    sure = replace(model, unreliable=0.0)
    near, far = relation("near", "House"), relation("on", "MainSt")
    posterior, _ = infer_description(by("Ann", near, far), CITY, model)
    each = [infer_description(by(None, r), CITY, sure)[0].belief(TARGET) for r in (near, far)]
    n = CITY.grid.size
    product = 0.75 * each[0] * each[1]
    nothing = 0.25 / n**2
    expected = (product + nothing) / (product + nothing).sum()
    np.testing.assert_allclose(posterior.belief(TARGET), expected, rtol=1e-9)
    reliable = posterior.latent("reliable")
    assert float(reliable[0]) == pytest.approx(product.sum() / (product + nothing).sum())
    assert float(reliable["prior"][0]) == 0.75


def test_a_share_that_is_none_is_refused():
    with pytest.raises(InputError, match=r"has unreliable 1\.0; expected at least 0"):
        replace(BAYES, unreliable=1.0)
    with pytest.raises(InputError, match=r"has denial 1\.5; expected 0 to 1"):
        replace(BAYES, denial=1.5)
