"""Scores of predicted fronts, and cross-validation over towns."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from support.facing_block import facing_town

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.eval import bundled_examples
from sloop_ppl.eval._frame_descriptions import score_described_frames, second_stage
from sloop_ppl.eval._frame_files import frame_lines, score_frames
from sloop_ppl.eval._frame_scores import FrameScores, fit_points, score_frame, spread_points
from sloop_ppl.eval._frames import FOLDS, cross_validate_frames
from sloop_ppl.maps import write_map
from sloop_ppl.models.frames import FrameDistribution, FramePart

UNIFORM = FrameDistribution((), lapse=1.0)
ARC = 2 * math.pi / 24


def test_uniform_is_worth_one_in_24_and_90_degrees():
    score = score_frame(UNIFORM, 1.0)
    assert score.log_score == pytest.approx(-math.log(24))
    assert score.deviation_deg == 90
    assert (score.in50, score.in90) == pytest.approx((0.5, 0.9))


def test_a_point_is_right_or_worth_nothing():
    right = score_frame(FrameDistribution.points((0.3,)), 0.3)
    assert (right.deviation_deg, right.log_score) == pytest.approx((0, 0))
    assert (right.in50, right.in90) == pytest.approx((0.5, 0.9))
    wrong = score_frame(FrameDistribution.points((0.3,)), 0.3 - math.pi)
    assert wrong.deviation_deg == pytest.approx(180)
    assert wrong.log_score == pytest.approx(math.log(1e-300))
    assert (wrong.in50, wrong.in90) == (0, 0)


def test_levels_of_two_points_by_hand():
    """.7 at east, .3 at north: the 50 % arc is 5/7 of the eastern one, the 90 % arc both but .1."""
    two = FrameDistribution((FramePart(0.0, math.inf, 0.7), FramePart(math.pi / 2, math.inf, 0.3)))
    east, north = score_frame(two, 0.0), score_frame(two, math.pi / 2)
    assert (east.in50, east.in90) == pytest.approx((5 / 7, 1))
    assert (north.in50, north.in90) == pytest.approx((0, 2 / 3))


def test_arcs_of_an_honest_prediction_hold_what_they_say():
    """If labels are drawn from the prediction, half lie in the 50 % arc; 4 standard errors."""
    frame = FrameDistribution((FramePart(0.4, 20.0, 0.6), FramePart(2.5, 3.0, 0.25)), lapse=0.15)
    rng = np.random.default_rng(0)
    angles, mass = frame.bins(1440)
    drawn = rng.choice(angles, size=600, p=mass / mass.sum())
    scores = FrameScores.of([score_frame(frame, float(a)) for a in drawn])
    assert scores.arc50 == pytest.approx(0.5, abs=4 * 0.5 / math.sqrt(600))
    assert scores.arc90 == pytest.approx(0.9, abs=4 * 0.3 / math.sqrt(600))


def test_deviations_go_round_the_circle_and_average_over_equal_modes():
    assert score_frame(FrameDistribution.points((3.1,)), -3.1).deviation_deg == pytest.approx(
        math.degrees(2 * math.pi - 6.2)
    )
    both = FrameDistribution.points((0.0, math.pi))
    assert score_frame(both, 0.0).deviation_deg == pytest.approx(90)


def test_the_best_spread_of_points_is_found():
    """Three in four labels within a degree, one anywhere: a sharp peak and a lapse of a quarter."""
    rng = np.random.default_rng(1)
    means = rng.uniform(-math.pi, math.pi, 800)
    labels = np.where(np.arange(800) % 4, means + 0.01 * rng.normal(size=800),
                      rng.uniform(-math.pi, math.pi, 800))  # fmt: skip
    points = [FrameDistribution.points((m,)) for m in means]
    kappa, lapse = fit_points(points, labels)
    assert kappa >= 300
    assert 0.2 <= lapse <= 0.3
    made = spread_points(points[0], kappa, lapse)
    assert made.parts[0].kappa == kappa
    assert made.lapse == pytest.approx(lapse)
    assert spread_points(UNIFORM, kappa, lapse) == UNIFORM


def test_austin_is_held_out_as_one_and_some_maps_only_train():
    assert FOLDS["austin_campus"] == FOLDS["citysim"] == "austin"
    assert FOLDS["paris"] is None


TOWNS = {f"town{i}": facing_town(f"town{i}", blocks=5, turn_rad=0.4 * i, seed=i) for i in range(2)}


@pytest.mark.slow
def test_towns_are_held_out_in_turn():
    lines: list[str] = []
    found = cross_validate_frames(
        TOWNS, ("ego-ctx", "ego"), epochs=8, rng=np.random.default_rng(0), progress=lines.append
    )
    assert found.folds == ("town0", "town1")
    assert found.predictors == ("ego-ctx", "ego", "nearest-street", "random")
    told = found.to_json()
    assert json.loads(json.dumps(told)) == told
    for row in told["predictors"].values():
        assert list(row) == ["n", "mean_deviation_deg", "median_deviation_deg", "mean_log_score",
                             "arc50", "arc90"]  # fmt: skip
        assert row["n"] == 120
    rows = told["predictors"]
    assert rows["ego-ctx"]["mean_log_score"] > rows["ego"]["mean_log_score"]
    assert rows["ego-ctx"]["mean_log_score"] > rows["nearest-street"]["mean_log_score"]
    assert rows["random"]["mean_deviation_deg"] == pytest.approx(90, abs=25)
    disputed = found.select("nearest-street", disputed=True)
    assert 0 < len(disputed) < 120
    assert min(score.deviation_deg for score in disputed) > 15
    assert told["address_against_entrance"]["n"] == 0
    assert any("without town1" in line for line in lines)


def test_one_town_alone_cannot_be_held_out():
    with pytest.raises(InputError, match="1 cities have 50 labelled buildings or more"):
        cross_validate_frames({"town0": TOWNS["town0"]}, rng=np.random.default_rng(0))


@pytest.mark.slow
def test_a_folder_is_scored_tabled_and_drawn(tmp_path):
    for name, town in TOWNS.items():
        write_map(town, tmp_path / f"{name}.geojson")
    report = score_frames(tmp_path, recipes="ego", epochs=1)
    assert "descriptions" not in report.to_json()
    assert any("each city held out" in str(line) for line in frame_lines(report))
    words = [t.get_text() for ax in report.figure().axes for t in ax.texts]
    assert any("not reproducible" in word for word in words)


def test_recipes_are_checked_before_the_work(tmp_path):
    with pytest.raises(UnknownName, match="Recipe 'ctxx' is unknown"):
        score_frames(tmp_path, recipes="ego,ctxx")
    with pytest.raises(InputError, match="an empty or repeated name"):
        score_frames(tmp_path, recipes="ego,ego")


def test_predictors_meet_on_what_people_said():
    descriptions = bundled_examples()
    found = score_described_frames(
        descriptions, ("ego-ctx", "nearest-street"), rng=np.random.default_rng(0)
    )
    assert found.n > 3
    gap, (low, high) = found.paired["ego-ctx-nearest-street"]
    means = found.mean_log_score
    assert gap == pytest.approx(means["ego-ctx"] - means["nearest-street"])
    assert low <= gap <= high
    assert list(found.to_json()) == ["n", "predictors", "paired"]
    with pytest.raises(InputError, match="No description says front, behind, left or right"):
        score_described_frames((), rng=np.random.default_rng(0))


def test_the_second_stage_wants_both_of_its_files(tmp_path):
    assert second_stage((), None) is None
    with pytest.raises(InputError, match="needs both --descriptions"):
        second_stage(("a.jsonl",), None)
    with pytest.raises(InputError, match="needs both --descriptions"):
        second_stage((), tmp_path / "t.json")
