"""Priors over cells: by name, learnt from places, and from files."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray

import sloop_ppl as sloop
from sloop_ppl.errors import InputError, OutputError, OutsideMap, UnknownName
from sloop_ppl.inference import infer_description, log_priors
from sloop_ppl.models import CELL_PRIORS, LearntCells, cell_prior, learn_cells
from sloop_ppl.models.cell_priors import FEATURES, CellsOfKinds, cell_features
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(11), house=(0.0, -10.0), street_y=20.0)
STREET = CITY.cells("MainSt")
NEAR = said(relation("near", "House"))


def test_streets_hold_their_share():
    on = CELL_PRIORS["streets"](CITY, TARGET)
    assert on[STREET].sum() == pytest.approx(0.95)
    assert on.sum() == pytest.approx(1)
    assert CELL_PRIORS["off-streets"](CITY, TARGET)[STREET].sum() == pytest.approx(0.05)


@pytest.mark.parametrize("share", [0.0, 1.0, -0.1, float("nan")])
def test_a_share_that_excludes_something_is_refused(share):
    with pytest.raises(InputError, match="expected between 0 and 1"):
        CellsOfKinds(("street",), share)


def test_the_posterior_is_prior_times_what_was_said():
    flat = infer_description(NEAR, CITY)[0].belief(TARGET)
    on_streets = infer_description(NEAR, CITY, prior="streets")[0].belief(TARGET)
    product = flat * CELL_PRIORS["streets"](CITY, TARGET)
    np.testing.assert_allclose(on_streets, product / product.sum(), rtol=1e-9)


def test_a_function_of_map_and_target_is_a_prior():
    def northern(city, target):
        assert target == TARGET
        return np.repeat(city.grid.y_m[:, None] > 0, city.grid.n_cols, 1).astype(float)

    belief = infer_description(NEAR, CITY, prior=northern)[0].belief(TARGET)
    assert belief[CITY.grid.y_m <= 0].sum() == 0


def test_targets_may_have_priors_of_their_own():
    two = said(relation("near", "House"), targets=(TARGET, "Bike"))
    tables = log_priors({"Bike": "streets"}, [t.id for t in two.targets], CITY)
    assert np.ptp(tables[TARGET]) == 0
    assert np.exp(tables["Bike"])[STREET.reshape(-1)].sum() == pytest.approx(0.95)


def test_an_unknown_name_lists_what_there_is():
    with pytest.raises(UnknownName) as raised:
        cell_prior("street")
    assert str(raised.value) == (
        "Prior over cells 'street' is unknown; expected one of uniform, streets, "
        "off-streets; did you mean 'streets'?, or the path of a .nc or .json file"
    )


@pytest.mark.parametrize("wrong", [3.5, object()])
def test_what_is_no_prior_is_refused(wrong):
    with pytest.raises(InputError, match="Prior"):
        infer_description(NEAR, CITY, prior=wrong)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (np.ones((3, 3)), r"has shape \(3, 3\); expected \(11, 11\)"),
        (np.full((11, 11), np.nan), "holds NaN"),
        (-np.ones((11, 11)), "negative"),
        (np.zeros((11, 11)), "zero everywhere"),
    ],
)
def test_a_bad_table_is_refused_however_it_comes(table, message, tmp_path):
    path = tmp_path / "prior.nc"
    xarray.Dataset({"belief": (("y", "x"), table)}).to_netcdf(path, engine="h5netcdf")
    for prior in (table, lambda city, target: table, path, str(path)):
        with pytest.raises(InputError, match=message):
            infer_description(NEAR, CITY, prior=prior)


def test_weights_may_be_as_great_as_floats_go():
    great, one = np.full((11, 11), 1e308), np.zeros((11, 11))
    one[3, 4] = 1e-300
    even = infer_description(NEAR, CITY)[0].belief(TARGET)
    np.testing.assert_allclose(infer_description(NEAR, CITY, prior=great)[0].belief(TARGET), even)
    certain = infer_description(NEAR, CITY, prior=one)[0]
    assert certain.belief(TARGET)[3, 4] == 1
    assert str(certain.entropy(TARGET)) == "0.0"


# -- learnt -------------------------------------------------------------------------------------


def features_by_hand():
    """House of 8 x 8 m, street in the row of 20 m; the rest is open."""
    features = np.full(CITY.grid.shape, FEATURES.index("open"))
    features[CITY.cells("House")] = FEATURES.index("building")
    features[STREET] = FEATURES.index("street")
    return features


def test_a_cell_is_the_first_feature_that_touches_it():
    assert np.array_equal(cell_features(CITY), features_by_hand())


def test_densities_are_those_worked_out_on_paper():
    """Three places on the street and one in the open; strength 4."""
    places = [(0.0, 20.0), (10.0, 20.0), (-20.0, 20.0), (-20.0, -20.0)]
    learnt = learn_cells([(CITY, place) for place in places], strength=4.0)
    features = features_by_hand()
    share = np.bincount(features.reshape(-1), minlength=len(FEATURES)) / 121
    for feature, count in (("street", 3), ("open", 1), ("building", 0)):
        a = share[FEATURES.index(feature)]
        assert learnt.density[feature] == pytest.approx((count + 4 * a) / (4 + 4) / a)
    assert learnt.density["park"] == 1.0
    table = learnt(CITY, TARGET)
    table = table / table.sum()
    street = share[FEATURES.index("street")]
    assert table[STREET].sum() == pytest.approx((3 + 4 * street) / 8)


def test_it_learns_what_places_are_drawn_from():
    rng = np.random.default_rng(0)
    truth = CELL_PRIORS["streets"](CITY, TARGET).reshape(-1)
    cells = rng.choice(truth.size, 4000, p=truth)
    places = [(CITY, CITY.grid.centre_of(*divmod(int(c), 11))) for c in cells]
    learnt = learn_cells(places)(CITY, TARGET)
    assert (learnt / learnt.sum())[STREET].sum() == pytest.approx(0.95, abs=0.015)


def test_learnt_is_kept_in_a_file(tmp_path):
    learnt = learn_cells([(CITY, (0.0, 20.0))])
    learnt.save(tmp_path / "cells.json")
    assert cell_prior(tmp_path / "cells.json") == learnt
    with pytest.raises(OutputError, match=r"\.json"):
        learnt.save(tmp_path / "cells.txt")


def test_nothing_to_learn_from_is_refused():
    with pytest.raises(InputError, match="no known place"):
        learn_cells([])
    with pytest.raises(OutsideMap):
        learn_cells([(CITY, (1e4, 0.0))])
    with pytest.raises(InputError, match="strength is 0"):
        learn_cells([(CITY, (0.0, 0.0))], strength=0.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"kind": "other"}, "is no prior over cells"),
        ({"counts": {"streets": 1}}, "did you mean 'street'"),
        ({"counts": {}}, "lacks 'street'"),
        ({"strength": -1.0}, "strength is -1"),
        ({"strength": "many"}, "is not one"),
        ({"shares": dict.fromkeys(FEATURES, 0.5)}, "sum to one"),
        ({"counts": dict.fromkeys(FEATURES, -1)}, "at least 0"),
    ],
)
def test_a_bad_file_of_counts_is_refused(change, message, tmp_path):
    path = tmp_path / "cells.json"
    learn_cells([(CITY, (0.0, 20.0))]).save(path)
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(InputError, match=message):
        LearntCells.load(path)


@pytest.mark.parametrize("text", ["", "[1, 2]", "{"])
def test_a_file_that_holds_something_else_is_refused(text, tmp_path):
    (tmp_path / "cells.json").write_text(text)
    with pytest.raises(InputError, match=r"is no JSON|is no prior over cells"):
        LearntCells.load(tmp_path / "cells.json")
    with pytest.raises(InputError, match="cannot be read"):
        LearntCells.load(tmp_path / "absent.json")


# -- netCDF -------------------------------------------------------------------------------------


def test_a_saved_posterior_is_a_prior_of_the_targets_it_holds(tmp_path):
    cleveland = sloop.load_map("cleveland")
    first = infer_description(said(relation("near", "Ivy")), cleveland)[0]
    first.save(tmp_path / "p.nc")
    tables = log_priors(tmp_path / "p.nc", (TARGET, "Bike"), cleveland)
    np.testing.assert_allclose(np.exp(tables[TARGET]), first.belief(TARGET).reshape(-1))
    assert np.ptp(tables["Bike"]) == 0


def test_a_file_of_another_map_or_other_cells_is_refused(tmp_path):
    first = infer_description(said(relation("near", "Ivy")), sloop.load_map("cleveland"))[0]
    first.save(tmp_path / "p.nc")
    with pytest.raises(InputError, match=r"made on another map \('cleveland'\)"):
        log_priors(tmp_path / "p.nc", (TARGET,), sloop.load_map("austin"))
    grid = CITY.grid
    shifted = xarray.Dataset(
        {"belief": (("y", "x"), np.ones(grid.shape))},
        coords={"y": grid.y_m, "x": grid.x_m + 1.0},
    )
    shifted.to_netcdf(tmp_path / "own.nc", engine="h5netcdf")
    with pytest.raises(InputError, match="its x starts at -24 m, expected -25 m"):
        log_priors(tmp_path / "own.nc", (TARGET,), CITY)


def test_a_file_that_is_not_there_or_is_text_is_refused(tmp_path):
    with pytest.raises(InputError, match="cannot be read: no such file"):
        cell_prior(tmp_path / "absent.nc")
    (tmp_path / "text.nc").write_text("x")
    with pytest.raises(InputError, match="cannot be read: no netCDF"):
        cell_prior(tmp_path / "text.nc")


@pytest.mark.parametrize(
    ("variables", "message"),
    [
        ({"t": ("x", np.ones(3))}, "not a posterior saved by sloop_ppl"),
        ({"belief": (("x", "y"), np.ones((11, 11)))}, r"dims \('x', 'y'\)"),
        ({"belief": (("target", "y", "x"), np.ones((1, 11, 11)))}, "does not name its targets"),
    ],
)
def test_a_file_without_a_table_is_refused(variables, message, tmp_path):
    xarray.Dataset(variables).to_netcdf(tmp_path / "own.nc", engine="h5netcdf")
    with pytest.raises(InputError, match=message):
        cell_prior(tmp_path / "own.nc")
