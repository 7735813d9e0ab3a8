"""How expected each phrase was: by brute force, and calibrated by simulation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kstest

from sloop_ppl.inference import infer_description
from sloop_ppl.maps import load_map
from sloop_ppl.models import speaker_of
from sloop_ppl.models._vocabulary import speaker_words
from sloop_ppl.models.simulation import SPEAKER, simulate
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(9, 10.0), house=(12.0, -7.0), street_y=30.0)


def test_words_are_weighed_by_their_evidence_given_the_others():
    """p(word | others) is a ratio of evidences of the speaker form."""
    others = relation("near", "MainSt")
    what = said(relation("behind", "House"), others)
    posterior, _ = infer_description(what, CITY, "bayes")
    check, _ = posterior.predictive(TARGET)
    speaks = speaker_of("bayes")
    base = float(infer_description(said(others), CITY, speaks)[0].log_evidence)
    for word in speaker_words():
        both = infer_description(said(others, relation(word, "House")), CITY, speaks)[0]
        # The uninformative component speaks of both phrases, so the mixture does not factorise:
        # compare under a speaker who is never uninformative.
        assert check.words[word] > 0
        del both
    literal = speaker_of("sloop")
    posterior, _ = infer_description(what, CITY, "sloop")
    check, _ = posterior.predictive(TARGET)
    base = float(infer_description(said(others), CITY, literal)[0].log_evidence)
    for word in speaker_words():
        both, _ = infer_description(said(others, relation(word, "House")), CITY, literal)
        expected = np.exp(float(both.log_evidence) - base)
        assert check.words[word] == pytest.approx(expected, rel=1e-6, abs=1e-12)
    assert sum(check.words.values()) == pytest.approx(1)


def test_rank_and_tail_are_those_of_the_word_said():
    what = said(relation("north", "House"), relation("on", "MainSt"))
    posterior, _ = infer_description(what, CITY, "bayes")
    check, _ = posterior.predictive(TARGET)
    ranked = sorted(check.words.values(), reverse=True)
    own = check.words["north"]
    assert check.p == own
    assert check.rank == ranked.index(own) + 1
    assert check.tail == pytest.approx(sum(p for p in ranked if p < own) + own / 2)
    assert check.rank <= 3, "the street runs north of the house"
    odd, _ = infer_description(
        said(relation("south", "House"), relation("on", "MainSt")), CITY, "bayes"
    )
    assert odd.predictive(TARGET)[0].tail < 0.1 < check.tail


def test_a_denied_phrase_has_the_probability_that_another_word_is_chosen():
    plain, denied = (
        infer_description(said(relation("near", "House", negated=n), relation("on", "MainSt")),
                          CITY, "bayes")[0].predictive(TARGET)[0]
        for n in (False, True)
    )  # fmt: skip
    assert denied.p == pytest.approx(1 - plain.p)
    expected = denied.p > plain.p
    assert denied.rank == (1 if expected else 2)
    assert denied.tail == pytest.approx(0.5 * denied.p + (plain.p if expected else 0.0))


@pytest.mark.slow
def test_tails_of_simulated_phrases_are_uniform():
    """Ties are broken at random; a right model fails once in a thousand seeds."""
    city = load_map("cleveland", cell_m=20)
    rng = np.random.default_rng(4)
    tails = []
    for _ in range(150):
        drawn = simulate(city, ["RedBike"], rng, model=SPEAKER, phrases=3)
        posterior, _ = infer_description(drawn.description, city, SPEAKER)
        check = posterior.predictive("RedBike")[0]
        # `tail` counts half of its own: spread it over the word's share.
        own = check.words[check.relation.relation]
        tails.append(check.tail + (rng.random() - 0.5) * own)
    assert kstest(tails, "uniform").pvalue > 1e-3
