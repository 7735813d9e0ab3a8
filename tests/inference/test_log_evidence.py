from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.inference import LogEvidence, infer_description, rank_models
from sloop_ppl.models import PredictedPoint, preset
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(21), house=(12.0, -7.0), street_y=30.0)
BEHIND = said(relation("behind", "House"))
SPEAKER = replace(preset("bayes"), name="spread", normalisation="speaker")
POINT = replace(SPEAKER, name="point", frame_prior=PredictedPoint())


def posterior(model, description=BEHIND, **options):
    return infer_description(description, CITY, model, **options)[0]


def test_evidence_of_unlike_models_cannot_be_ordered():
    one, other = posterior("bayes").log_evidence, posterior("sloop").log_evidence
    message = (
        "Log evidence of model 'bayes' ('map' normalisation) and of 'sloop' ('map') cannot be "
        "ranked; expected 'speaker' normalisation over one vocabulary: only then do both give a "
        "probability to the same words"
    )
    for ask in (
        lambda: one < other,
        lambda: one <= other,
        lambda: one > other,
        lambda: one >= other,
        lambda: min(other, one),
    ):
        with pytest.raises(InputError) as caught:
            ask()
        assert str(caught.value) == message


def test_models_are_not_ranked_by_sorting():
    with pytest.raises(InputError, match="cannot be ranked"):
        max([posterior("bayes"), posterior("sloop")], key=lambda p: p.log_evidence)


def test_evidence_is_a_float_otherwise():
    evidence = posterior("bayes").log_evidence
    assert isinstance(evidence, float)
    assert evidence < 0
    assert (evidence < posterior("bayes", prior=np.ones(CITY.grid.shape)).log_evidence) is False
    again = pickle.loads(pickle.dumps(evidence))
    assert (again, again.model, again.normalisation) == (evidence, "bayes", "map")
    assert type(evidence + 1) is float


def test_speakers_over_one_vocabulary_are_ordered():
    one, other = posterior(SPEAKER).log_evidence, posterior(POINT).log_evidence
    assert (one > other) is (float(one) > float(other))
    fewer = LogEvidence(-1.0, "speaker", "fewer", ["near"])
    with pytest.raises(InputError, match="over one vocabulary"):
        assert one < fewer


def test_models_are_ranked_by_the_probability_of_what_was_said():
    """Seen to the south of a house that faces north, the car is behind it."""
    prior = np.full(CITY.grid.shape, 1e-9)
    prior[CITY.grid.cell_at(12.0, -22.0)] = 1
    ranked = rank_models([posterior(SPEAKER, prior=prior), posterior(POINT, prior=prior)])
    assert [score.name for score in ranked] == ["point", "spread"]
    assert ranked[0].bits_behind == 0
    assert ranked[1].bits_behind > 0
    assert sum(score.p for score in ranked) == pytest.approx(1)
    assert ranked[0].p / ranked[1].p == pytest.approx(2 ** ranked[1].bits_behind)


@pytest.mark.parametrize(
    ("posteriors", "message"),
    [
        ([], "There is no posterior to rank; expected at least one"),
        (
            ["bayes"],
            (
                "Model 'bayes' has 'map' normalisation, so its log evidence ranks no models; "
                "expected 'speaker' for all of them: "
                "dataclasses.replace(model, normalisation='speaker')"
            ),
        ),
        (
            [SPEAKER, SPEAKER],
            (
                "Two of the posteriors have models of the same name; give a mapping of name to "
                "posterior"
            ),
        ),
    ],
)
def test_what_cannot_be_ranked(posteriors, message):
    with pytest.raises(InputError) as caught:
        rank_models([posterior(model) for model in posteriors])
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("other", "what"),
    [
        (lambda: posterior(POINT, said(relation("left", "House"))), "what was said"),
        (lambda: posterior(POINT, prior=np.eye(21) + 1), "their prior"),
        (
            lambda: posterior(POINT).condition({TARGET: np.eye(21)}),
            "what was sensed",
        ),
    ],
)
def test_models_of_unlike_tasks_cannot_be_ranked(other, what):
    with pytest.raises(InputError) as caught:
        rank_models([posterior(SPEAKER), other()])
    assert str(caught.value) == (
        f"Models 'spread' and 'point' cannot be ranked: they differ in {what}; infer both from "
        "the same"
    )
