"""Every mistake of a user is one line on stderr and exit code 2."""

from __future__ import annotations

import json

import numpy as np
import pytest

from sloop_ppl.cli import main

TEXT = "the green toyota is behind velvet dog"
INFER = ["infer", TEXT, "--map", "cleveland"]
SEARCH = ["search", TEXT, "--map", "cleveland"]


def refused(capsys, arguments):
    """Run a command that must be refused; return the one line it says."""
    with pytest.raises(SystemExit) as stopped:
        main([str(a) for a in arguments])
    out, err = capsys.readouterr()
    assert stopped.value.code == 2
    assert out == ""
    assert err.endswith("\n")
    assert err.count("\n") == 1, err
    assert "Traceback" not in err
    return err


CASES = {
    "unknown map": (
        ["infer", TEXT, "--map", "clevland"],
        (
            "Map 'clevland' is unknown; expected one of austin, cleveland, denver, honolulu, "
            "suburb, washington_dc; did you mean 'cleveland'? (or give the path of a .geojson file)"
        ),
    ),
    "unknown model": (
        [*INFER, "--model", "sloop-m5"],
        (
            "Model 'sloop-m5' is unknown; expected one of uniform, keyword, informed, sloop, "
            "sloop-m2, sloop-m4, bayes, referent-gaussian; did you mean 'sloop-m4'?"
        ),
    ),
    "unknown variant": ([*INFER, "--model", "sloop", "--variant", "draft"], "published, paper"),
    "variant of bayes": ([*INFER, "--variant", "paper"], "only the sloop models"),
    "unknown engine": ([*INFER, "--engine", "exat"], "did you mean 'exact'?"),
    "unknown frames": ([*INFER, "--frames", "compass"], "nearest-street"),
    "unknown planner": ([*SEARCH, "--planner", "pouctt"], "did you mean 'pouct'?"),
    "unknown list": (["list", "planers"], "did you mean 'planners'?"),
    "informed without truth": ([*INFER, "--model", "informed"], "needs to be told where"),
    "no relation": (
        ["infer", "what a lovely day", "--map", "cleveland"],
        "recognised no target, no landmark, no relation word",
    ),
    "no relation to parse": (["parse", "what a lovely day", "--map", "cleveland"], "No relation"),
    "landmark of another map": (
        ["infer", "the red bike is behind the Norwood Tower", "--map", "cleveland"],
        "'Norwood Tower' was not found on map 'cleveland' (nearest: ",
    ),
    "missing option": (["infer", TEXT], "Missing option '--map'"),
    "unknown option": ([*INFER, "--modle", "sloop"], "No such option: --modle"),
    "unknown command": (["infr"], "No such command 'infr'"),
    "not a number": ([*SEARCH, "--sims", "many"], "--sims"),
    "no simulations": ([*SEARCH, "--sims", "0"], "sims is 0"),
    "malformed place": ([*SEARCH, "--place", "GreenToyota:1,2"], "expected OBJECT=x,y"),
    "place of three numbers": ([*SEARCH, "--place", "GreenToyota=1,2,3"], "expected OBJECT=x,y"),
    "NaN place": ([*SEARCH, "--place", "GreenToyota=nan,2"], "expected OBJECT=x,y"),
    "repeated place": (
        [*SEARCH, "--place", "GreenToyota=1,2", "--place", "GreenToyota=3,4"],
        "given twice",
    ),
    "place of no target": ([*SEARCH, "--place", "RedBike=1,2"], "RedBike"),
    "target outside": ([*SEARCH, "--place", "GreenToyota=500,0"], "outside the map"),
    "start outside": ([*SEARCH, "--start", "0,-101"], "outside the map"),
    "malformed start": ([*SEARCH, "--start", "here"], "Start 'here' is malformed"),
    "figure ending": ([*INFER, "--figure", "belief.xyz"], "belief.xyz"),
    "figure folder": ([*INFER, "--figure", "no/such/folder/belief.png"], "does not exist"),
    "posterior ending": ([*INFER, "--out", "posterior.pickle"], "expected one of .nc"),
    "posterior folder": ([*INFER, "--out", "no/such/folder/p.nc"], "does not exist"),
    "animation ending": ([*SEARCH, "--animation", "search.png"], "search.png"),
    "no prior": ([*INFER, "--prior", "absent.nc"], "'absent.nc' cannot be read"),
    "no targets file": ([*INFER, "--targets", "absent.json"], "absent.json"),
    "odd range": ([*SEARCH, "--range", "0"], "sensor_range_cells is 0"),
}


@pytest.mark.parametrize("name", CASES)
def test_one_line_and_exit_code_2(name, capsys):
    arguments, said = CASES[name]
    line = refused(capsys, arguments)
    assert line.startswith("sloop: ")
    assert said in line


def test_a_file_that_is_no_map_names_feature_and_field(tmp_path, capsys):
    path = tmp_path / "broken.geojson"
    path.write_text(
        json.dumps(
            {
                "type": "FeatureCollection",
                "name": "broken",
                "centre": {"lat": 41.5, "lon": -81.7},
                "half_extent_m": 100,
                "features": [
                    {
                        "type": "Feature",
                        "properties": {"id": "Depot", "kind": "shed"},
                        "geometry": {"type": "Point", "coordinates": [-81.7, 41.5]},
                    }
                ],
            }
        )
    )
    line = refused(capsys, ["infer", TEXT, "--map", path])
    assert "Depot" in line
    assert "kind" in line


def test_outputs_are_checked_before_the_work(tmp_path, capsys, monkeypatch):
    """Nothing is inferred when the figure cannot be written."""
    import sloop_ppl.bridge._requests as requests

    monkeypatch.setattr(requests, "parse", lambda *_, **__: pytest.fail("worked before checking"))
    refused(capsys, [*INFER, "--figure", tmp_path / "absent" / "f.png"])
    refused(capsys, [*SEARCH, "--out", tmp_path / "absent" / "e.json"])
    refused(capsys, [*SEARCH, "--animation", tmp_path / "s.docx"])


def test_a_prior_made_on_another_map_is_refused(tmp_path, capsys):
    path = tmp_path / "p.nc"
    with pytest.raises(SystemExit) as done:
        main(
            [
                "infer",
                "the red bike is near the Norwood Tower",
                "--map",
                "austin",
                "--out",
                str(path),
            ]
        )
    assert done.value.code == 0
    capsys.readouterr()
    assert "made on another map ('austin')" in refused(capsys, [*INFER, "--prior", path])


def test_a_text_file_is_no_prior(tmp_path, capsys):
    path = tmp_path / "p.nc"
    path.write_text("not netCDF")
    assert "cannot be read" in refused(capsys, [*INFER, "--prior", path])


def test_a_netcdf_file_of_something_else_is_no_prior(tmp_path, capsys):
    import xarray

    path = tmp_path / "other.nc"
    xarray.Dataset({"t": ("x", np.zeros(3))}).to_netcdf(path, engine="h5netcdf")
    assert "not a posterior saved by sloop_ppl" in refused(capsys, [*INFER, "--prior", path])
