from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from sloop_ppl.errors import InputError
from sloop_ppl.planning import SearchConfig
from sloop_ppl.planning.path_search import sharpened

tables = hnp.arrays(float, (4, 5), elements=st.floats(0, 1)).filter(lambda t: t.max() > 1e-6)


@given(tables, st.floats(0, 1))
def test_it_is_a_belief_whose_cells_keep_their_order(table, share):
    table = table / table.sum()
    got = sharpened(table, share)
    assert got.min() >= 0
    assert got.sum() == pytest.approx(1)
    assert got.max() >= table.max() - 1e-12
    order = np.argsort(table, axis=None)
    assert (np.diff(got.ravel()[order]) >= -1e-15).all()


def test_two_cells_by_hand():
    table = np.array([[0.75, 0.25]])
    sharp = 3**8 / (3**8 + 1)
    assert sharpened(table, 0.5)[0, 0] == pytest.approx((0.75 + sharp) / 2)
    assert sharpened(table, 1.0)[0, 0] == pytest.approx(sharp)
    assert (table == [[0.75, 0.25]]).all()


def test_a_uniform_belief_stays_as_it_is():
    table = np.full((9, 11), 1 / 99)
    assert sharpened(table, 0.3) == pytest.approx(table)


def test_no_hedge_takes_the_belief_at_its_word():
    table = np.array([[0.9, 0.1]])
    assert sharpened(table, 0.0) is table


@pytest.mark.parametrize("hedge", [-0.1, 1.1, float("nan")])
def test_a_hedge_that_is_no_share_is_refused(hedge):
    with pytest.raises(InputError, match=r"hedge is .*; expected a number in \[0, 1\]"):
        SearchConfig(hedge=hedge)
