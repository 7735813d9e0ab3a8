from __future__ import annotations

import builtins
import json
import warnings
from dataclasses import replace

import numpy as np
import pytest
import shapely

import sloop_ppl as sloop
from sloop_ppl.errors import InputError, OutputError, UnknownName
from sloop_ppl.eval import bundled_examples
from sloop_ppl.inference import infer_description, write_geojson
from sloop_ppl.maps import load_map
from sloop_ppl.models import preset
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = load_map("cleveland")
SAID = said(
    relation("behind", "VelvetDog"),
    relation("on", "West6thSt", figure="RedBike"),
    targets=(TARGET, "RedBike"),
)


@pytest.fixture(scope="module")
def posterior():
    return infer_description(SAID, CITY)[0]


def test_cells_lie_where_they_are_on_earth(posterior):
    cells = posterior.to_geojson(TARGET)
    assert cells["type"] == "FeatureCollection"
    assert len(cells["features"]) == CITY.grid.size
    held = [feature["properties"] for feature in cells["features"]]
    assert sum(p["probability"] for p in held) == pytest.approx(1)
    peak = max(cells["features"], key=lambda feature: feature["properties"]["probability"])
    square = shapely.geometry.shape(peak["geometry"])
    lon, lat = CITY.grid.to_lonlat(*posterior.mode(TARGET))
    assert square.contains(shapely.Point(float(lon), float(lat)))
    assert square.exterior.is_ccw
    x, y = CITY.grid.from_lonlat(*np.array(square.exterior.coords).T)
    assert np.ptp(x) == pytest.approx(5, abs=0.01)
    assert np.ptp(y) == pytest.approx(5, abs=0.01)


def test_fronts_set_from_outside_are_exported_and_not_saved(tmp_path):
    turned = infer_description(SAID, CITY, do={"frame": 1.0})[0]
    with pytest.raises(InputError, match=r"its fronts were set with do=.*; save the posterior inf"):
        turned.save(tmp_path / "p.nc")
    assert turned.to_geojson(TARGET, least=0.9)["features"] == []


def test_neighbours_share_their_corners(posterior):
    squares = [
        shapely.geometry.shape(f["geometry"]) for f in posterior.to_geojson(TARGET)["features"]
    ]
    whole = shapely.union_all(squares)
    assert whole.geom_type == "Polygon"
    assert len(whole.interiors) == 0


def test_the_hpd_property_styles_the_region(posterior):
    inside = sum(f["properties"]["hpd"] <= 0.9 for f in posterior.to_geojson(TARGET)["features"])
    assert abs(inside - int(posterior.hpd(TARGET, 0.9).sum())) <= 1


def test_all_targets_and_only_what_is_probable(posterior, tmp_path):
    write_geojson(posterior, tmp_path / "cells.geojson", least=1e-3)
    cells = json.loads((tmp_path / "cells.geojson").read_text(encoding="utf-8"))
    told = [feature["properties"] for feature in cells["features"]]
    assert {p["target"] for p in told} == {TARGET, "RedBike"}
    assert min(p["probability"] for p in told) >= 1e-3
    assert cells["attribution"] == CITY.attribution


def test_cells_that_cannot_be_exported(posterior, tmp_path):
    block = house_and_street(symmetric_grid(9))
    nowhere = infer_description(said(relation("near", "House")), block)[0]
    with pytest.raises(InputError) as caught:
        nowhere.to_geojson(TARGET)
    assert str(caught.value) == (
        "Map 'block' has no centre on earth, so its cells have no longitude; give its grid a "
        "centre=(lat, lon)"
    )
    with pytest.raises(InputError, match=r"least is 1; expected a probability in \[0, 1\)"):
        posterior.to_geojson(TARGET, least=1)
    with pytest.raises(UnknownName, match="Target 'Bus' is unknown"):
        posterior.to_geojson("Bus")
    with pytest.raises(OutputError, match=r"ends in '.kml'; expected one of .geojson, .json"):
        write_geojson(posterior, tmp_path / "cells.kml")


def test_arviz_holds_draws_of_every_latent(posterior):
    arviz = pytest.importorskip("arviz", reason="the extra [arviz] is not installed")
    data = posterior.to_arviz(400)
    assert isinstance(data, arviz.InferenceData)
    draws = data.posterior
    assert dict(draws.sizes)["draw"] == 400
    assert dict(draws.sizes)["chain"] == 4
    assert set(draws) == {
        "RedCar_x", "RedCar_y", "RedCar_front",
        "RedBike_x", "RedBike_y", "RedBike_component", "RedBike_is",
    }  # fmt: skip
    share = float((draws["RedBike_component"] == 0).mean())
    assert share == pytest.approx(posterior.component("RedBike")["product"], abs=0.02)
    named = draws["RedBike_is"].sel(component="product")
    assert float(named.mean()) == pytest.approx(share)
    assert float(draws["RedCar_x"].mean()) == pytest.approx(posterior.expected(TARGET)[0], abs=2)
    assert float(data.constant_data["belief"].sum()) == pytest.approx(2)
    assert draws.identical(posterior.to_arviz(400).posterior)
    drawn = posterior.to_arviz(400, rng=np.random.default_rng(0)).posterior
    assert not draws.identical(drawn)
    assert arviz.summary(data, var_names=["RedCar_x"], kind="stats").shape[0] == 1


def test_arviz_summarises_compares_and_checks_without_a_warning(posterior, caplog):
    arviz = pytest.importorskip("arviz", reason="the extra [arviz] is not installed")
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    example = next(e for e in bundled_examples() if e.id == "cleveland-ex-01")
    said = sloop.parse(example.text, CITY)
    data = sloop.infer(said, CITY).to_arviz()
    assert set(data.groups()) == {
        "posterior", "prior", "posterior_predictive", "observed_data", "log_likelihood",
        "constant_data",
    }  # fmt: skip
    lapsing = replace(preset("bayes"), lapse=0.4)
    other = sloop.infer(said, CITY, lapsing).to_arviz()
    with warnings.catch_warnings():
        # ArviZ's own use of pandas, of which nobody else can do anything
        warnings.filterwarnings("ignore", message="The inplace keyword")
        summary = arviz.summary(data)
        ranked = arviz.compare({"bayes": data, "lapsing": other})
        arviz.plot_ppc(data, num_pp_samples=20)
    assert caplog.records == []
    assert "GreenToyota_is[0, product]" in summary.index
    assert set(ranked.index) == {"bayes", "lapsing"}
    assert not ranked["warning"].any()
    matplotlib.pyplot.close("all")


def test_arviz_groups_are_what_the_posterior_says(posterior):
    pytest.importorskip("arviz", reason="the extra [arviz] is not installed")
    data = posterior.to_arviz(500)
    words = data.observed_data.attrs["words"]
    assert [words[i] for i in data.observed_data["word"].values] == ["behind", "at"]
    log_p = data.log_likelihood["word"]
    assert (log_p <= 0).all()
    # The share of draws of a word is the mean of its probability.
    drawn, said = data.posterior_predictive["word"], data.observed_data["word"]
    share = (drawn == said).mean(("chain", "draw"))
    np.testing.assert_allclose(share, np.exp(log_p).mean(("chain", "draw")), atol=0.03)
    # The prior is uniform over the map, and its components have their weights.
    assert float(data.prior["RedCar_x"].std()) == pytest.approx(CITY.grid.x_m.std(), rel=0.02)
    weights = data.prior["RedCar_is"].isel(chain=0, draw=0)
    wanted = posterior.component_prior(TARGET)
    assert dict(zip(weights["component"].values.tolist(), weights.values, strict=True)) == (
        pytest.approx(wanted)
    )


def test_without_arviz_it_says_how_to_get_it(posterior, monkeypatch):
    real = builtins.__import__

    def none_of_it(name, *args, **kwargs):
        if name == "arviz":
            raise ImportError(name)
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", none_of_it)
    with pytest.raises(InputError) as caught:
        posterior.to_arviz()
    assert str(caught.value) == (
        "ArviZ is not installed; install it with: pip install 'sloop-ppl[arviz]'"
    )
