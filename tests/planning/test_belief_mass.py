"""The mass that a path search counts, against the same in numpy."""

from __future__ import annotations

import numpy as np
import pytest

from sloop_ppl.planning._belief_mass import add_mass, eighth_power


@pytest.mark.parametrize("sharp", [0.0, 0.3])
@pytest.mark.parametrize("reach", [0, 2])
def test_mass_is_added_to_the_inner_cells_of_a_map_that_is_not_square(sharp, reach):
    rng = np.random.default_rng(0)
    table = rng.random((3, 5))
    table /= table.sum()
    powers = np.empty(15 if sharp else 0)
    if sharp:
        eighth_power(table.ravel(), table.max(), powers)
        assert np.allclose(powers, (table / table.max()).ravel() ** 8, rtol=1e-13)
    before = rng.random((3 + 2 * reach, 5 + 2 * reach))
    mass = before.copy()
    add_mass(mass, table.ravel(), 0.7, powers, sharp, reach)
    wanted = before.copy()
    added = 0.7 * table + (sharp * powers.reshape(3, 5) if sharp else 0.0)
    wanted[reach : 3 + reach, reach : 5 + reach] += added
    assert np.array_equal(mass, wanted)
