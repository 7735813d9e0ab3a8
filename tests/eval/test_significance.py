"""Intervals and tests, against brute force and figures worked out by hand."""

import itertools
import math

import numpy as np
import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.eval._significance import holm, sign_flip_p, t_estimate


def test_a_t_interval_by_hand():
    told = t_estimate([2.0, 4.0, 4.0, 6.0, 9.0])
    half = 2.776445 * math.sqrt(7.0 / 5)  # t of 4 degrees of freedom; variance 28 / 4
    assert (told.mean, told.low, told.high) == pytest.approx((5.0, 5 - half, 5 + half), abs=1e-5)


def test_fewer_than_five_have_no_interval():
    told = t_estimate([1.0, 2.0, 3.0, 4.0])
    assert told.mean == 2.5
    assert not told.bounded


def test_sign_flips_by_brute_force():
    rng = np.random.default_rng(3)
    values = rng.normal(0.4, 1.0, size=12)
    clusters = [0, 0, 1, 2, 2, 2, 3, 4, 5, 6, 6, 7]
    sums = [sum(v for v, c in zip(values, clusters, strict=True) if c == k) for k in range(8)]
    least = abs(sum(sums)) - 1e-12
    flips = itertools.product((1, -1), repeat=8)
    as_far = [abs(sum(s * x for s, x in zip(f, sums, strict=True))) >= least for f in flips]
    assert sign_flip_p(values, clusters, rng=rng) == pytest.approx(np.mean(as_far))


def test_many_clusters_are_drawn_and_agree_with_a_normal_test():
    # 40 clusters of one: z = 2.53 by the exact variance of the flipped sum; p about .011. Twenty
    # thousand draws leave a standard error of .0007.
    values = np.array([1.0] * 28 + [-1.0] * 12)
    p = sign_flip_p(values, list(range(40)), rng=np.random.default_rng(0))
    exact = 2 * sum(math.comb(40, k) for k in range(28, 41)) / 2**40
    assert p == pytest.approx(exact, abs=0.004)


def test_no_difference_is_as_probable_as_can_be():
    assert sign_flip_p([0.0, 0.0, 0.0], ["a", "b", "c"], rng=np.random.default_rng(0)) == 1.0


def test_flipping_clusters_whole_is_more_careful():
    rng = np.random.default_rng(0)
    values = [1.0] * 10
    assert sign_flip_p(values, ["a"] * 5 + ["b"] * 5, rng=rng) == 0.5
    assert sign_flip_p(values, list(range(10)), rng=rng) == pytest.approx(2 / 2**10)


def test_bad_differences():
    with pytest.raises(InputError, match="expected at least one difference and a cluster for each"):
        sign_flip_p([1.0], [], rng=np.random.default_rng(0))


def test_holm_keeps_order_and_never_exceeds_one():
    assert holm([0.5, 0.9, 0.001]) == pytest.approx([1.0, 1.0, 0.003])
    assert holm([]) == []
