"""Means by relations, by how many, and by city, of scores made up by hand."""

import pytest

from sloop_ppl.eval._belief_scores import BeliefScore, Region, ScoredTarget
from sloop_ppl.eval._breakdown import breakdown


def scored(map_, relations, log_score, covers=(0.5, 1.0)):
    regions = tuple(Region(c, 100 * (i + 1) * abs(log_score)) for i, c in enumerate(covers))
    score = BeliefScore(log_score, 0.0, 0.0, 0.0, 0.0, log_score + 0.5, regions)
    return ScoredTarget(f"{map_} {log_score}", f"{log_score}", "Car", map_, relations, score)


SCORES = [
    scored("austin", (), -8.0, (0.0, 0.0)),
    scored("denver", ("near",), -1.0, (1.0, 1.0)),
    scored("denver", ("near", "near"), -2.0),
    scored("austin", ("near", "on", "between"), -3.0),
    scored("austin", ("on", "near", "on", "on"), -5.0, (0.25, 0.75)),
]


def test_groups_by_hand():
    told = breakdown(SCORES)
    assert {k: (v["n"], v["mean_log_score"]) for k, v in told["by_relations"].items()} == {
        "0": (1, -8.0), "1": (1, -1.0), "2": (1, -2.0), "3+": (2, -4.0)
    }  # fmt: skip
    # The most frequent first, then by the alphabet; a target counts once for each of its words.
    assert list(told["by_relation"]) == ["near", "on", "between"]
    assert {k: v["n"] for k, v in told["by_relation"].items()} == {"near": 4, "on": 2, "between": 1}
    assert told["by_relation"]["near"]["mean_log_score"] == -11 / 4
    assert told["by_relation"]["near"]["mean_log_score_1pct"] == -11 / 4 + 0.5
    assert list(told["by_city"]) == ["austin", "denver"]
    assert told["by_city"]["denver"]["mean_log_score"] == -1.5


def test_calibration_is_the_mean_over_targets():
    told = breakdown(SCORES)["calibration"]
    assert list(told) == ["50", "90"]
    assert told["50"]["coverage"] == pytest.approx((0 + 1 + 0.5 + 0.5 + 0.25) / 5)
    assert told["90"]["coverage"] == pytest.approx((0 + 1 + 1 + 1 + 0.75) / 5)
    assert told["50"]["area_m2"] == pytest.approx(100 * 19 / 5)
    assert told["90"]["area_m2"] == pytest.approx(200 * 19 / 5)


def test_the_interval_holds_the_mean_and_is_the_same_again():
    group = breakdown(SCORES)["by_relation"]["near"]
    low, high = group["ci95"]
    assert -5 <= low < group["mean_log_score"] < high <= -1
    assert breakdown(SCORES)["by_relation"]["near"]["ci95"] == [low, high]
