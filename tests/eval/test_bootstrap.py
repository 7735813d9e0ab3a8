import numpy as np
import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.eval._bootstrap import clustered_interval


def test_clusters_are_drawn_whole():
    # Drawing two clusters gives 1 or 3, a quarter each, or else their size-weighted mean.
    values, clusters = [1.0, 1.0, 1.0, 3.0], ["a", "a", "a", "b"]
    for level, expected in ((0.4, (1.5, 1.5)), (0.6, (1.0, 3.0))):
        rng = np.random.default_rng(0)
        assert clustered_interval(values, clusters, rng=rng, level=level) == expected


def test_a_copied_observation_narrows_nothing_within_its_cluster():
    rng = np.random.default_rng(1)
    values = rng.normal(size=40)
    once = clustered_interval(values, list(range(40)), rng=np.random.default_rng(2))
    thrice = clustered_interval(
        np.repeat(values, 3), list(np.repeat(np.arange(40), 3)), rng=np.random.default_rng(2)
    )
    assert thrice == pytest.approx(once)


def test_it_covers():
    # 200 sets of 30 clusters; the percentile bootstrap covers some 93 %: fewer than 170 of 200
    # has a probability below 1e-4.
    covered = 0
    for seed in range(200):
        rng = np.random.default_rng(seed)
        centres = np.repeat(rng.normal(size=30), 2)
        low, high = clustered_interval(
            centres + 0.1 * rng.normal(size=60),
            list(np.repeat(np.arange(30), 2)),
            rng=rng,
            draws=400,
        )
        covered += low <= 0 <= high
    assert covered >= 170


def test_one_cluster_has_no_spread():
    assert clustered_interval([1.0, 2.0], ["a", "a"], rng=np.random.default_rng(0)) == (1.5, 1.5)


@pytest.mark.parametrize(("values", "clusters"), [([], []), ([1.0], ["a", "b"])])
def test_bad_input(values, clusters):
    with pytest.raises(InputError, match="expected at least one value and a cluster for each"):
        clustered_interval(values, clusters, rng=np.random.default_rng(0))
