"""The second stage: numbers of the frame prior learnt from descriptions of known places."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.inference._frame_tuning import framed_examples, tune_frames
from sloop_ppl.inference._supervised_scores import Example
from sloop_ppl.inference.learning import log_scores
from sloop_ppl.models import PredictedPoint, preset
from sloop_ppl.models.frames import FRAME_PREDICTORS
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

GRID = symmetric_grid(21)
CITY = house_and_street(GRID, house=(0.0, 0.0), street_y=-30.0)
RULE = FRAME_PREDICTORS["nearest-street"]


def example(word, x, y):
    return Example(said(relation(word, "House")), CITY, {TARGET: GRID.cell_at(x, y)})


SOUTHWARDS = [example("front", 1.0 * i, -15.0) for i in range(-4, 5)]
"""All in front of a house that faces its street in the south."""
ANYWHERE = [example("front", 15 * np.cos(a), 15 * np.sin(a)) for a in np.linspace(0, 5.5, 9)]


def test_only_descriptions_with_a_frame_teach():
    near = example("near", 5.0, 5.0)
    kept = framed_examples([near, SOUTHWARDS[0]])
    assert [one.description for one in kept] == [SOUTHWARDS[0].description]


@pytest.mark.slow
def test_speakers_who_follow_the_prediction_are_found_surer_than_those_who_do_not():
    told: list[str] = []
    follow = tune_frames(SOUTHWARDS, preset("bayes"), RULE, progress=told.append)
    stray = tune_frames(ANYWHERE, preset("bayes"), RULE)
    assert list(follow.parameters) == ["frames"]
    assert set(follow.parameters["frames"]) == {"kappa", "absolute"}
    assert follow.parameters["frames"]["kappa"] > stray.parameters["frames"]["kappa"]
    assert follow.provenance["mean_log_score_after"] > follow.provenance["mean_log_score_before"]
    assert "mean log score" in told[0]
    tuned = follow.apply(preset("bayes"))
    model = replace(tuned, frame_prior=replace(tuned.frame_prior, predictor=RULE))
    after = float(log_scores(SOUTHWARDS, model).mean())
    assert after == pytest.approx(follow.provenance["mean_log_score_after"])


@pytest.mark.slow
def test_the_weight_of_the_maps_left_and_right_is_learnt():
    """The house faces south: its left is east, the map's left is west."""
    maps = [example("left", -15.0, 1.0 * i) for i in range(-4, 5)]
    own = [example("left", 15.0, 1.0 * i) for i in range(-4, 5)]
    absolute = [
        tune_frames(some, preset("bayes"), RULE).parameters["frames"]["absolute"]
        for some in (maps, own)
    ]
    assert absolute[0] > 0.85
    assert absolute[1] < 0.6


def test_what_cannot_be_tuned_is_named():
    with pytest.raises(InputError, match="No description says front, behind, left or right"):
        tune_frames([example("near", 0.0, 9.0)], preset("bayes"), RULE)
    certain = replace(preset("bayes"), name="certain", frame_prior=PredictedPoint())
    with pytest.raises(InputError, match="Model 'certain' has a frame prior without numbers"):
        tune_frames(SOUTHWARDS, certain, RULE)
