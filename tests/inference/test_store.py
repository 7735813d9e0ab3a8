"""A saved posterior carries its model with it, numbers and all."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
import xarray

from sloop_ppl.errors import InputError
from sloop_ppl.inference import Importance, Posterior, infer_description
from sloop_ppl.inference.prior import log_priors
from sloop_ppl.language import StreetPart
from sloop_ppl.maps import load_map
from sloop_ppl.models import LIKELIHOODS, GaussianLikelihood, preset
from sloop_ppl.models.cell_priors import cell_prior
from sloop_ppl.models.tuning import with_parameters
from tests.mixture import MIXTURE
from tests.scenes import TARGET, relation, said

CITY = load_map("cleveland")
SAID = said(relation("behind", "VelvetDog"))
LATER = said(relation("near", "Ivy"))
TUNED = with_parameters(
    replace(MIXTURE, name="mine", likelihood=LIKELIHOODS["student-vonmises"]),
    {"likelihood": {"directed_m": 12.0}, "model": {"lapse": 0.1}, "frames": {"kappa": 2.0}},
)


@pytest.fixture
def saved(tmp_path):
    infer_description(SAID, CITY, TUNED)[0].save(tmp_path / "p.nc")
    return tmp_path / "p.nc"


def test_a_tuned_model_is_read_as_it_was(saved):
    before, after = infer_description(SAID, CITY, TUNED)[0], Posterior.load(saved)
    assert after.model == TUNED
    np.testing.assert_array_equal(after.belief(TARGET), before.belief(TARGET))
    np.testing.assert_array_equal(
        after.update(LATER).belief(TARGET), before.update(LATER).belief(TARGET)
    )


def spoil(path, change):
    with xarray.open_dataset(path, engine="h5netcdf") as opened:
        data = opened.load()
    change(data)
    data.to_netcdf(path.with_name("spoilt.nc"), engine="h5netcdf")
    with pytest.raises(InputError) as error:
        Posterior.load(path.with_name("spoilt.nc"))
    return str(error.value)


def in_parts(change):
    def spoilt(data):
        parts = json.loads(data.attrs["model_parts"])
        change(parts)
        data.attrs["model_parts"] = json.dumps(parts)

    return spoilt


def in_sections(change):
    def spoilt(data):
        sections = json.loads(data.attrs["sections"])
        change(sections)
        data.attrs["sections"] = json.dumps(sections)

    return spoilt


def test_sections_that_a_later_version_adds_are_passed_over(saved, tmp_path):
    with xarray.open_dataset(saved, engine="h5netcdf") as opened:
        data = opened.load()
    in_sections(lambda sections: sections.update(moods=7))(data)
    data.to_netcdf(tmp_path / "later.nc", engine="h5netcdf")
    after = Posterior.load(tmp_path / "later.nc")
    np.testing.assert_array_equal(after.belief(TARGET), Posterior.load(saved).belief(TARGET))


def test_an_engine_is_read_with_its_options(tmp_path):
    drawn = Importance(draws=20)
    before, _ = infer_description(SAID, CITY, "bayes", drawn, rng=np.random.default_rng(0))
    before.save(tmp_path / "p.nc")
    after = Posterior.load(tmp_path / "p.nc")
    assert (after.engine, after.method) == ("importance", drawn)
    one, other = (p.update(LATER, np.random.default_rng(1)) for p in (before, after))
    np.testing.assert_array_equal(one.belief(TARGET), other.belief(TARGET))


def test_parts_of_streets_are_read_as_they_were(tmp_path):
    parts = (StreetPart("side", math.pi / 2), StreetPart("number", number=12), None)
    streets = ("JohnsonCourt", "West6thSt", "WestLakesideAvenue")
    relations = [
        replace(relation("on", street), part=part)
        for street, part in zip(streets, parts, strict=True)
    ]
    infer_description(said(*relations), CITY, TUNED)[0].save(tmp_path / "p.nc")
    (factor,) = Posterior.load(tmp_path / "p.nc").factors
    assert tuple(r.part for r in factor.descriptions[0].relations) == parts


def test_a_model_that_was_told_the_truth_is_read_too(tmp_path):
    before, _ = infer_description(SAID, CITY, "informed", truth={TARGET: (10.0, -20.0)})
    before.save(tmp_path / "p.nc")
    after = Posterior.load(tmp_path / "p.nc")
    np.testing.assert_array_equal(after.belief(TARGET), before.belief(TARGET))
    assert [lapse.p for lapse in after.lapses(TARGET)] == [0.0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            in_parts(lambda parts: parts["likelihood"]["parameters"].update(width=3.0)),
            "of StudentVonMisesLikelihood 'width' is unknown; expected one of contact_m",
        ),
        (in_parts(lambda parts: parts.update(lapses=0.1)), "did you mean 'lapse'?"),
        (
            in_parts(lambda parts: parts["components"][0].update(weight="x")),
            "A model's field 'components[0].weight' is 'x'; expected a number",
        ),
        (
            in_parts(lambda parts: parts.update(joint_grounds=1)),
            "A model's field 'joint_grounds' is 1; expected true or false",
        ),
        (in_parts(lambda parts: parts.update(likelihood=[])), "'likelihood' is a list; expected"),
        (lambda data: data.attrs.update(descriptions=3), "field 'descriptions' is 3"),
        (lambda data: data.attrs.update(truths="[]"), "0 lists of true places for 1 utterances"),
        (lambda data: data.attrs.update(truths='[{"a": 1}]'), "Expected `array"),
        (in_parts(lambda parts: parts["components"].pop()), "4 components; its model has 3"),
        (lambda data: data.attrs.pop("model_parts"), "lacks 'model_parts'; infer it again"),
        (lambda data: data.attrs.update(model_parts="{"), "cannot be read"),
        (lambda data: data.attrs.update(format=2), "has format 2; expected 4"),
        (
            in_sections(lambda sections: sections.update(factors=2)),
            "its section 'factors' has version 2; expected 1; read it with the version of",
        ),
        (in_sections(lambda sections: sections.pop("engine")), "lacks 'engine'; infer it again"),
        (lambda data: data.attrs.pop("engine_options"), "lacks 'engine_options'; infer it again"),
    ],
)
def test_what_a_spoilt_file_gets_wrong_is_named(saved, change, message):
    assert message in spoil(saved, change)


def test_a_model_of_unregistered_parts_is_refused_before_writing(tmp_path):
    own = replace(preset("bayes"), name="own", likelihood=GaussianLikelihood(floor=0.01))
    posterior = infer_description(SAID, CITY, own)[0]
    with pytest.raises(InputError, match="The likelihood of model 'own' is none of the registered"):
        posterior.save(tmp_path / "p.nc")
    assert not (tmp_path / "p.nc").exists()
    assert posterior.dataset["belief"].sum() == pytest.approx(1)


TURNS = {
    "y from the north": lambda data: data.sortby("y", ascending=False),
    "x from the east": lambda data: data.sortby("x", ascending=False),
    "x before y": lambda data: data.transpose("x", "y", ...),
    "shuffled": lambda data: data.isel(x=np.random.default_rng(0).permutation(data.sizes["x"])),
}


def rewritten(path, turn):
    with xarray.open_dataset(path, engine="h5netcdf") as opened:
        data = turn(opened.load())
    data.to_netcdf(path.with_name("turned.nc"), engine="h5netcdf")
    return path.with_name("turned.nc")


@pytest.mark.parametrize("turn", TURNS)
def test_a_file_whose_axes_were_turned_is_read_by_coordinate(saved, turn):
    turned = rewritten(saved, TURNS[turn])
    expected = Posterior.load(saved)
    np.testing.assert_array_equal(Posterior.load(turned).belief(TARGET), expected.belief(TARGET))
    prior = log_priors(turned, (TARGET,), CITY)[TARGET]
    np.testing.assert_array_equal(prior, log_priors(saved, (TARGET,), CITY)[TARGET])
    table = TURNS[turn](expected.dataset)["belief"].sel(target=TARGET)
    np.testing.assert_array_equal(log_priors(table, (TARGET,), CITY)[TARGET], prior)


@pytest.mark.parametrize(
    "part",
    [
        lambda data: data.isel(x=slice(0, 20)),
        lambda data: data.isel(y=slice(1, None)),
        lambda data: data.coarsen(x=2, y=2, boundary="trim").mean(),
        lambda data: data.isel(x=slice(None, None, 2)),
        lambda data: data.assign_coords(x=data.x + 5.0),
        lambda data: data.assign_coords(y=data.y * np.nan),
        lambda data: data.drop_vars("x"),
    ],
)
def test_a_cut_coarse_or_shifted_table_is_refused(saved, part):
    beliefs = Posterior.load(saved).dataset[["belief"]]
    tables = part(beliefs)["belief"].sel(target=TARGET)
    with pytest.raises(InputError, match="Prior of"):
        log_priors(tables, (TARGET,), CITY)
    with pytest.raises(InputError) as caught:
        Posterior.load(rewritten(saved, part))
    assert "\n" not in str(caught.value)


def put(name, value, index=-1):
    def changed(data):
        data[name].values.reshape(-1)[index] = value

    return changed


@pytest.mark.parametrize(
    "change",
    [
        put("log_prior", -3.0),
        put("log_factor", -3.0, 0),
        put("log_sensed", 1.0),
        put("belief", 0.5),
        put("entry_target", 0.0 + 1),
        lambda data: data.attrs.pop("tables_digest"),
    ],
)
def test_tables_that_were_changed_are_refused(saved, change):
    assert "infer it again" in spoil(saved, change)


def without_digest(data):
    del data.attrs["tables_digest"]
    in_sections(lambda sections: sections.pop("digest"))(data)


@pytest.mark.parametrize(
    "change",
    [
        put("log_prior", np.nan),
        put("log_prior", np.inf),
        put("log_factor", np.nan, 0),
        put("entry_target", 7),
        put("entry_target", -1),
        put("entry_description", 9),
    ],
)
def test_a_file_without_digest_holds_numbers_that_can_be_meant(saved, change):
    def both(data):
        without_digest(data)
        change(data)

    assert "cannot be read: its" in spoil(saved, both)


def test_a_file_without_digest_is_read(saved, tmp_path):
    with xarray.open_dataset(saved, engine="h5netcdf") as opened:
        data = opened.load()
    without_digest(data)
    data.to_netcdf(tmp_path / "earlier.nc", engine="h5netcdf")
    after = Posterior.load(tmp_path / "earlier.nc")
    np.testing.assert_array_equal(after.belief(TARGET), Posterior.load(saved).belief(TARGET))


def test_a_file_that_claims_terabytes_is_refused_before_they_are_taken(tmp_path):
    import h5netcdf

    with h5netcdf.File(tmp_path / "big.nc", "w") as file:
        file.dimensions = {"y": 1_000_000, "x": 1_000_000}
        file.create_variable("belief", ("y", "x"), float, chunks=(1000, 1000), fillvalue=0.0)
        file.attrs["title"] = "sloop_ppl posterior"
    for read in (Posterior.load, cell_prior):
        with pytest.raises(InputError, match="GiB of tables; expected at most"):
            read(tmp_path / "big.nc")
