"""Calibration of stated probabilities: hand-solved cases and draws from known curves."""

import math

import numpy as np
import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.eval._calibration import CalibrationBin, calibration


def judge(stated, right, clusters=None, **options):
    clusters = range(len(stated)) if clusters is None else clusters
    return calibration(stated, right, clusters, rng=np.random.default_rng(0), **options)


def drawn(slope, n=4000, seed=1):
    rng = np.random.default_rng(seed)
    stated = rng.uniform(0.05, 0.95, n)
    chance = 1 / (1 + np.exp(-slope * np.log(stated / (1 - stated))))
    return stated, rng.random(n) < chance


def test_two_levels_solved_by_hand():
    # .9 is right 3 times of 4, .6 half of the time: the logits of these shares lie on any line.
    found = judge([0.9] * 4 + [0.6] * 4, [1, 1, 1, 0, 1, 1, 0, 0])
    assert found.slope == pytest.approx(math.log(3) / (math.log(9) - math.log(1.5)), rel=1e-3)
    assert found.right == 0.625
    assert found.brier == pytest.approx((3 * 0.01 + 0.81 + 2 * 0.16 + 2 * 0.36) / 8)
    assert found.brier_constant == pytest.approx(0.625 * 0.375)
    # 15 pairs of right and wrong: 3 * 2 in order, 3 * 1 + 2 * 2 ties, 2 * 1 the wrong way round.
    assert found.auc == pytest.approx((6 + 7 / 2) / 15)


@pytest.mark.parametrize("slope", [0.4, 1.0, 2.0])
def test_the_slope_of_a_known_curve_is_found(slope):
    # Standard error about .05: outside .25 less than one time in 100,000; the seed is fixed.
    found = judge(*drawn(slope))
    low, high = found.slope_ci95
    assert abs(found.slope - slope) < 0.25
    assert low < slope < high
    assert high - low < 0.4


def test_the_interval_is_wider_when_statements_come_in_clusters():
    stated, right = drawn(1.0, n=400)
    # Each statement ten times over tells no more than once, if the clusters are known.
    ten = np.repeat(np.arange(400), 10)
    clustered = judge(stated[ten], right[ten], list(ten)).slope_ci95
    blind = judge(stated[ten], right[ten]).slope_ci95
    assert clustered[1] - clustered[0] > 2 * (blind[1] - blind[0])


def test_bins_keep_equal_statements_together():
    found = judge(
        [0.2] * 3 + [0.5] * 2 + [0.7] * 4 + [0.9], [0, 0, 1, 1, 0, 1, 1, 1, 0, 1], bin_size=4
    )
    assert found.bins == (
        CalibrationBin(5, pytest.approx(0.32), 0.4),
        CalibrationBin(5, pytest.approx(0.74), 0.8),  # what is left over joins the last
    )
    (whole,) = judge([0.2, 0.8], [0, 1]).bins
    assert (whole.n, whole.right) == (2, 0.5)


@pytest.mark.parametrize(
    ("stated", "right"), [([1.0] * 4, [1, 1, 0, 1]), ([0.4, 0.8], [1, 1]), ([0.4, 0.8], [0, 0])]
)
def test_where_no_slope_can_be_told_there_is_none(stated, right):
    found = judge(stated, right)
    assert found.slope is None
    assert found.slope_ci95 is None
    assert (found.auc is None) == (len(set(right)) == 1)


def test_certain_statements_have_a_finite_slope():
    found = judge([1.0, 1.0, 1.0, 0.0, 0.0], [1, 1, 0, 0, 1])
    assert math.isfinite(found.slope)
    separated = judge([0.9, 0.8, 0.2, 0.1], [1, 1, 0, 0])
    assert separated.slope > 2
    assert math.isfinite(separated.slope)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (([], [], []), "There are 0 probabilities, 0 outcomes and 0 clusters; expected at least"),
        (([0.5], [1, 0], ["a"]), "There are 1 probabilities, 2 outcomes and 1 clusters; expected"),
        (([1.5], [1], ["a"]), "A stated probability is outside [0, 1]; expected a probability"),
    ],
)
def test_bad_arguments(given, message):
    with pytest.raises(InputError) as caught:
        judge(*given)
    assert str(caught.value).startswith(message)
