"""Coverage of the regions: by hand, and calibrated by construction."""

import numpy as np
import pytest

from sloop_ppl.eval._belief_scores import LEVELS, score_belief
from sloop_ppl.eval.descriptions import Place
from sloop_ppl.maps import Grid

GRID = Grid(0, 0, 10, 10, cell_m=5.0)  # 3 x 3 cells
BELIEF = np.array([[0.4, 0.2, 0.2], [0.1, 0.1, 0.0], [0.0, 0.0, 0.0]])


def regions(row, col):
    place = Place(float(GRID.x_m[col]), float(GRID.y_m[row]), (row, col))
    return score_belief(BELIEF, GRID, place).regions


def test_regions_by_hand():
    half, most = regions(0, 0)
    assert (half.covers, most.covers) == (1.0, 1.0)
    # One cell whole and half of the next; three cells whole and one of .1.
    assert (half.area_m2, most.area_m2) == (pytest.approx(1.5 * 25), pytest.approx(4 * 25))
    half, most = regions(0, 2)  # tied: of .4 in two cells .1 is taken for the half
    assert (half.covers, most.covers) == (pytest.approx(0.25), 1.0)
    half, most = regions(1, 1)
    assert (half.covers, most.covers) == (0.0, pytest.approx(0.5))
    assert [r.covers for r in regions(2, 2)] == [0.0, 0.0]


@pytest.mark.parametrize("seed", range(5))
def test_a_belief_that_is_right_is_covered_just_so_often(seed):
    rng = np.random.default_rng(seed)
    belief = np.round(rng.dirichlet(np.full(9, 0.6)).reshape(3, 3), 1 + seed % 3)  # with ties
    belief /= belief.sum()
    covered = np.zeros(len(LEVELS))
    for row, col in np.ndindex(3, 3):
        place = Place(float(GRID.x_m[col]), float(GRID.y_m[row]), (row, col))
        told = score_belief(belief, GRID, place).regions
        covered += belief[row, col] * np.array([region.covers for region in told])
    assert covered == pytest.approx(LEVELS)


def test_one_per_cent_of_the_uniform_belief():
    score = score_belief(BELIEF, GRID, Place(10.0, 10.0, (2, 2)))
    assert score.log_score_mixed == pytest.approx(np.log(0.01 / 9))
    score = score_belief(BELIEF, GRID, Place(0.0, 0.0, (0, 0)))
    assert score.log_score_mixed == pytest.approx(np.log(0.99 * 0.4 + 0.01 / 9))
