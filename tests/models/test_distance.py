"""Distances on a fine grid: to the ground's cells of 5 m, by brute force, and kept."""

from __future__ import annotations

import numpy as np

from sloop_ppl.models._reference_regions import ground_distance_m
from tests.scenes import house_and_street, symmetric_grid


def test_a_fine_grid_measures_to_the_cells_of_five_metres():
    coarse = house_and_street(symmetric_grid(11), house=(6.0, -8.0), street_y=20.0)
    fine = coarse.with_grid(symmetric_grid(55, cell_m=1.0))
    rows, cols = np.nonzero(coarse.cells("House"))
    x, y = coarse.grid.x_m[cols], coarse.grid.y_m[rows]
    apart = np.hypot(fine.grid.x_m[None, :, None] - x, fine.grid.y_m[:, None, None] - y).min(-1)
    np.testing.assert_allclose(ground_distance_m(fine, "House"), apart, atol=1e-9)


def test_a_fine_distance_is_computed_once():
    fine = house_and_street(symmetric_grid(20, cell_m=2.5))
    assert ground_distance_m(fine, "House") is ground_distance_m(fine, "House")
    assert not np.array_equal(ground_distance_m(fine, "House"), ground_distance_m(fine, "MainSt"))
