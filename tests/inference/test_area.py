"""A belief of a part of the map: it is the belief of the whole, with the rest cut off."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray

import sloop_ppl as sloop
from sloop_ppl.errors import InputError
from sloop_ppl.inference import Posterior, infer_batch, infer_description
from sloop_ppl.maps import load_map
from sloop_ppl.models import preset
from sloop_ppl.planning import SearchConfig, run_search
from tests.scenes import TARGET, relation, said

CITY = load_map("cleveland")
SAID = said(relation("behind", "VelvetDog"))
LATER = said(relation("near", "Ivy"))
OTHER = said(relation("near", "Ivy", figure="RedBike"), targets=("RedBike",))
AREA = (-60, -80, 20, 0)
X, Y = np.meshgrid(CITY.grid.x_m, CITY.grid.y_m)
INSIDE = (X >= -60) & (X <= 20) & (Y >= -80) & (Y <= 0)


def restricted(belief):
    return np.where(INSIDE, belief, 0) / belief[INSIDE].sum()


@pytest.mark.parametrize("name", ["uniform", "keyword", "sloop", "sloop-m4", "bayes"])
def test_phrases_mean_what_they_mean_on_the_map(name):
    # The prior is uniform and each phrase divided by its sum over the map, so that the belief is
    # that of the map, cut: a phrase divided by its sum over the area would not be.
    whole, _ = infer_description(SAID, CITY, name)
    part, _ = infer_description(SAID, CITY, name, area=AREA)
    np.testing.assert_allclose(part.belief(TARGET), restricted(whole.belief(TARGET)), atol=1e-15)
    assert (part.belief(TARGET)[~INSIDE] == 0).all()


def test_what_is_derived_is_of_the_area():
    post = sloop.infer("the red bike is far from Ivy", CITY, area=AREA)
    row, col = CITY.grid.cell_at(*post.mode("RedBike"))
    assert INSIDE[row, col]
    assert not (post.hpd("RedBike") & ~INSIDE).any()
    x, y = post.expected("RedBike")
    assert -60 < x < 20
    assert -80 < y < 0
    assert post.area.n_cells == INSIDE.sum() == 256


def test_more_evidence_and_other_targets_keep_to_the_area():
    part, _ = infer_description(SAID, CITY, "bayes", area=AREA)
    whole, _ = infer_description(SAID, CITY, "bayes")
    seen = {TARGET: np.where(X < -20, -1.0, 0.0)}
    for step in (
        lambda post: post.update(LATER),
        lambda post: post.condition(seen),
        lambda post: post.update(OTHER),
    ):
        one, other = step(part), step(whole)
        assert one.area is part.area
        for target in one.targets:
            np.testing.assert_allclose(
                one.belief(target), restricted(other.belief(target)), atol=1e-15
            )


def test_a_prior_is_cut_to_the_area_and_must_leave_some():
    east = np.where(X > 0, 1.0, 0.0)
    post, _ = infer_description(SAID, CITY, "uniform", prior=east, area=AREA)
    belief = post.belief(TARGET)
    assert (belief > 0).sum() == (INSIDE & (X > 0)).sum()
    with pytest.raises(InputError, match="The prior is zero in all 256 cells of the area"):
        infer_description(SAID, CITY, prior=np.where(X > 50, 1.0, 0.0), area=AREA)


@pytest.mark.parametrize("engine", ["enumerate", "importance"])
def test_other_engines_keep_to_the_area(engine):
    rng = np.random.default_rng(0)
    exact, _ = infer_description(LATER, CITY, "bayes", area=AREA)
    other, _ = infer_description(LATER, CITY, "bayes", engine, rng=rng, area=AREA)
    assert (other.belief(TARGET)[~INSIDE] == 0).all()
    apart = np.abs(other.belief(TARGET) - exact.belief(TARGET)).sum() / 2
    assert apart < 0.05


def test_a_batch_is_of_the_area():
    (one,) = infer_batch([SAID], CITY, "bayes", area=AREA)
    post, _ = infer_description(SAID, CITY, "bayes", area=AREA)
    np.testing.assert_allclose(one[TARGET], post.belief(TARGET), atol=1e-15)


def test_a_file_keeps_the_area(tmp_path):
    post, _ = infer_description(SAID, CITY, "bayes", area=AREA)
    post.save(tmp_path / "p.nc")
    read = Posterior.load(tmp_path / "p.nc")
    np.testing.assert_array_equal(read.area.cells, post.area.cells)
    np.testing.assert_array_equal(read.belief(TARGET), post.belief(TARGET))
    np.testing.assert_allclose(
        read.update(OTHER).belief("RedBike"), post.update(OTHER).belief("RedBike")
    )
    infer_description(SAID, CITY, "bayes")[0].save(tmp_path / "whole.nc")
    assert Posterior.load(tmp_path / "whole.nc").area is None


def test_an_area_of_a_later_version_is_refused(tmp_path):
    infer_description(SAID, CITY, "bayes", area=AREA)[0].save(tmp_path / "p.nc")
    with xarray.open_dataset(tmp_path / "p.nc", engine="h5netcdf") as opened:
        data = opened.load()
    sections = json.loads(data.attrs["sections"])
    data.attrs["sections"] = json.dumps({**sections, "area": 2})
    data.to_netcdf(tmp_path / "later.nc", engine="h5netcdf")
    with pytest.raises(InputError, match="its section 'area' has version 2; expected 1"):
        Posterior.load(tmp_path / "later.nc")


def test_start_and_targets_are_drawn_in_the_area():
    post, _ = infer_description(SAID, CITY, "uniform", area=(40, 40, 60, 60))
    config = SearchConfig(max_steps=1)
    starts, places = set(), set()
    for seed in range(12):
        episode = sloop.search(
            post, CITY, planner="greedy", rng=np.random.default_rng(seed), config=config
        )
        starts.add(episode.start[:2])
        places.add(episode.places[TARGET])
    for x, y in starts | places:
        assert 40 <= x <= 60
        assert 40 <= y <= 60
    assert len(starts) > 4
    assert len(places) > 4


def test_an_area_that_is_all_no_fly_has_no_start():
    with pytest.raises(InputError) as error:
        run_search(
            {TARGET: np.ones(CITY.grid.shape)},
            CITY,
            {TARGET: (0.0, 0.0)},
            planner="greedy",
            rng=np.random.default_rng(0),
            start_area=np.zeros(CITY.grid.shape, dtype=bool),
        )
    assert str(error.value).startswith("No cell of the area is free to start in; give a start")


def test_the_informed_baseline_keeps_to_the_area():
    post, _ = infer_description(
        SAID, CITY, preset("informed"), truth={TARGET: (0.0, -20.0)}, area=AREA
    )
    assert post.belief(TARGET)[INSIDE].sum() == pytest.approx(1)
