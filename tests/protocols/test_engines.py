"""Every registered engine weighs component and cell as the exact one does, to its tolerance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sloop_ppl.inference import ENGINES, infer_description
from sloop_ppl.models import (
    Component,
    PredictedSpread,
    ground_description,
    preset,
    program_data,
)
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(15), house=(12.0, -7.0), street_y=30.0)
# One mode and no uniform tails, which a normal guide cannot have.
MODEL = replace(
    preset("bayes"),
    lapse=0.05,
    frame_prior=PredictedSpread(lapse=0.0),
    components=(Component("product", 0.8), Component("at", 0.2, combine="sum", read_as="at")),
)
FRAMED = said(relation("behind", "House"), relation("near", "MainSt"))
PLAIN = said(relation("near", "House"), relation("south", "MainSt"))
TOLERANCE = {"exact": 0.0, "enumerate": 1e-5, "importance": 0.02, "nuts": 0.08, "svi": 0.12}
"""Total variation from exact; an engine that is not named here has 0.1."""
SLOW = ("nuts", "svi")

ALL = [pytest.param(name, marks=pytest.mark.slow if name in SLOW else ()) for name in ENGINES]


def run(name, what, seed=0, city=CITY, model=MODEL):
    return infer_description(what, city, model, name, rng=np.random.default_rng(seed))


def total_variation(a, b):
    return 0.5 * np.abs(a.belief(TARGET) - b.belief(TARGET)).sum()


@pytest.mark.parametrize("name", ALL)
def test_beliefs_components_and_evidence_agree_with_exact(name):
    exact, info = infer_description(FRAMED, CITY, MODEL)
    got, got_info = run(name, FRAMED)
    tolerance = TOLERANCE.get(name, 0.1)
    belief = got.belief(TARGET)
    assert belief.shape == CITY.grid.shape
    assert belief.sum() == pytest.approx(1)
    assert (belief >= 0).all()
    assert total_variation(exact, got) <= tolerance
    assert got.component(TARGET) == pytest.approx(exact.component(TARGET), abs=tolerance + 1e-9)
    assert got_info.log_evidence == pytest.approx(info.log_evidence, abs=tolerance + 1e-9)
    assert got_info.engine == name


@pytest.mark.parametrize("name", ENGINES)
def test_factors_have_the_shape_that_was_promised(name):
    """Two targets, of one of which nothing is said; no frame, so that all are quick."""
    two = replace(PLAIN, targets=said(targets=(TARGET, "Bike")).targets)
    data = program_data(ground_description(two, CITY, MODEL), CITY, MODEL)
    tables = ENGINES[name].weigh(data, np.random.default_rng(0))
    assert len(tables) == 2
    for table in tables:
        assert table.shape == (len(MODEL.components), CITY.grid.size)
        assert table.dtype == np.float64
        assert not np.isnan(table).any()
    silent = np.logaddexp.reduce(tables[1], 0)
    assert np.ptp(silent) < 1e-9, "nothing was said, so no cell is likelier"


@pytest.mark.parametrize("name", ENGINES)
def test_without_frames_every_engine_is_exact(name):
    exact, info = infer_description(PLAIN, CITY, MODEL)
    got, got_info = run(name, PLAIN)
    assert total_variation(exact, got) < 1e-9
    assert got_info.log_evidence == pytest.approx(info.log_evidence, abs=1e-9)


@pytest.mark.parametrize("name", ENGINES)
def test_the_order_of_relations_and_of_updates_is_irrelevant(name):
    turned = replace(PLAIN, relations=PLAIN.relations[::-1])
    assert total_variation(run(name, PLAIN)[0], run(name, turned)[0]) < 1e-9
    first, second = (said(relation(word, "House")) for word in ("near", "east"))
    rng = np.random.default_rng(0)
    one_way = run(name, first)[0].update(second, rng)
    other_way = run(name, second)[0].update(first, rng)
    assert total_variation(one_way, other_way) < 1e-9


@pytest.mark.parametrize("name", ENGINES)
def test_a_prior_of_zeros_stays_zero(name):
    prior = np.ones(CITY.grid.shape)
    prior[:5] = 0.0
    got = infer_description(PLAIN, CITY, MODEL, name, prior=prior, rng=np.random.default_rng(0))[
        0
    ].belief(TARGET)
    assert got[:5].sum() == 0
    assert got.sum() == pytest.approx(1)


@pytest.mark.parametrize("name", ["exact", "enumerate", "importance"])
def test_the_same_seed_gives_the_same_bytes(name):
    runs = [run(name, FRAMED, seed=7)[0].belief(TARGET) for _ in range(2)]
    assert runs[0].tobytes() == runs[1].tobytes()


@pytest.mark.parametrize("name", ["exact", "enumerate"])
def test_halving_the_cells_keeps_the_mass_of_blocks(name):
    """Of blocks of 10 m, within .02 (the contract's figure for the widths in metres)."""
    masses = []
    for cell_m in (5.0, 2.5):
        grid = symmetric_grid(round(120 / cell_m), cell_m)
        city = house_and_street(grid, house=(12.5, -7.5), street_y=33.0)
        belief = run(name, said(relation("behind", "House")), city=city)[0].belief(TARGET)
        side = round(10 / cell_m)
        masses.append(belief.reshape(12, side, 12, side).sum((1, 3)))
    assert 0.5 * np.abs(masses[0] - masses[1]).sum() < 0.02
