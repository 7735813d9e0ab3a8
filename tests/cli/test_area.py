"""`--area` of infer and search."""

from __future__ import annotations

import json

import pytest

from sloop_ppl.cli import main

WORDS = ("the red bike is near Ivy", "--map", "cleveland")


def run(capsys, code, *arguments):
    with pytest.raises(SystemExit) as done:
        main([str(a) for a in arguments])
    out, err = capsys.readouterr()
    assert done.value.code == code, err
    return out, err


def test_infer_tells_of_the_area(capsys, tmp_path):
    square = [[-50, -50], [0, -50], [0, 0], [-50, 0], [-50, -50]]
    path = tmp_path / "square.geojson"
    path.write_text(json.dumps({"type": "Polygon", "coordinates": [square]}))
    told = []
    for area in ("-50,-50,0,0", str(path)):
        out, _ = run(capsys, 0, "infer", *WORDS, "--area", area, "--json")
        told.append(json.loads(out)["targets"]["RedBike"])
    assert told[0] == told[1]
    assert -50 <= told[0]["mode_m"][0] <= 0
    assert told[0]["hpd90_cells"] <= 100
    out, _ = run(capsys, 0, "infer", *WORDS, "--area", "-100,-100,200,200", "--json")
    whole, _ = run(capsys, 0, "infer", *WORDS, "--json")
    assert json.loads(out)["targets"]["RedBike"]["mode_m"] == pytest.approx(
        json.loads(whole)["targets"]["RedBike"]["mode_m"]
    )


def test_search_starts_and_imagines_in_the_area(capsys, tmp_path):
    out, _ = run(
        capsys, 0, "search", *WORDS, "--area", "-50,-50,0,0", "--planner", "greedy", "--steps", "2",
        "--seed", "3", "--posterior-out", tmp_path / "p.nc", "--json",
    )  # fmt: skip
    told = json.loads(out)
    for x, y in (told["poses"][0][:2], told["places"]["RedBike"]):
        assert -50 <= x <= 0
        assert -50 <= y <= 0
    _, err = run(
        capsys, 2, "search", "--posterior", tmp_path / "p.nc", "--area", "0,0,9,9", "--json"
    )
    assert err.strip() == (
        "sloop: --area does not go with --posterior; leave it out: a saved posterior keeps its own"
    )


@pytest.mark.parametrize("command", ["infer", "search"])
@pytest.mark.parametrize(
    ("area", "message"),
    [
        ("500,0,600,10", "The area (500, 0, 600, 10) is outside the map"),
        ("50,0,-50,10", "The area (50, 0, -50, 10) is empty or in another order"),
        ("0,0,nan,10", "The area (0, 0, nan, 10) is not finite"),
        ("nowhere.geojson", "Area 'nowhere.geojson' cannot be read"),
    ],
)
def test_bad_areas_are_one_line(capsys, command, area, message):
    _, err = run(capsys, 2, command, *WORDS, "--area", area)
    assert len(err.strip().splitlines()) == 1
    assert message in err
