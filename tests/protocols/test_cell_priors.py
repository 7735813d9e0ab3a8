"""Every registered prior over cells keeps the protocol's promises."""

from __future__ import annotations

import numpy as np
import pytest

import sloop_ppl as sloop
from sloop_ppl.inference import log_priors
from sloop_ppl.models import CELL_PRIORS, cell_prior
from tests.scenes import TARGET, house_and_street, point_city, symmetric_grid

BLOCK = house_and_street(symmetric_grid(21), house=(12.0, -7.0), street_y=30.0)


@pytest.mark.parametrize("name", CELL_PRIORS)
@pytest.mark.parametrize("city", [BLOCK, sloop.load_map("cleveland")], ids=["block", "cleveland"])
def test_weights_are_finite_positive_somewhere_and_of_the_map(name, city):
    weights = CELL_PRIORS[name](city, TARGET)
    assert weights.shape == city.grid.shape
    assert weights.dtype == np.float64
    assert np.isfinite(weights).all()
    assert (weights > 0).all(), "a description could contradict it"
    assert np.array_equal(weights, CELL_PRIORS[name](city, TARGET))


@pytest.mark.parametrize("name", CELL_PRIORS)
def test_a_bare_map_gets_a_uniform_prior(name):
    bare = point_city(symmetric_grid(5), Pole=(0.0, 0.0))
    weights = CELL_PRIORS[name](bare, TARGET)
    assert np.ptp(weights) == 0


@pytest.mark.parametrize("name", CELL_PRIORS)
def test_it_goes_by_its_name_wherever_a_prior_goes(name):
    assert cell_prior(name) is CELL_PRIORS[name]
    (log_p,) = log_priors(name, (TARGET,), BLOCK).values()
    assert np.exp(log_p).sum() == pytest.approx(1)
    (by_target,) = log_priors({TARGET: name}, (TARGET,), BLOCK).values()
    assert np.array_equal(log_p, by_target)


@pytest.mark.parametrize("name", CELL_PRIORS)
def test_finer_cells_keep_the_mass_of_blocks(name):
    """Of blocks of 20 m, but for the edges of street and house."""
    masses = []
    for cell_m in (5.0, 2.5):
        city = house_and_street(symmetric_grid(round(200 / cell_m), cell_m), street_y=33.0)
        weights = CELL_PRIORS[name](city, TARGET)
        side = round(20 / cell_m)
        blocks = weights.reshape(10, side, 10, side).sum((1, 3))
        masses.append(blocks / blocks.sum())
    assert 0.5 * np.abs(masses[0] - masses[1]).sum() < 0.03
