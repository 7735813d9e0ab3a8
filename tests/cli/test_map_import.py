"""`sloop map import` and `sloop map fetch`: data on stdout, one line and code 2 for mistakes."""

import json

import pytest
from support.osm_block import CENTRE, block

from sloop_ppl.cli import main
from sloop_ppl.maps import load_map


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as stopped:
        main([str(a) for a in arguments])
    out, err = capsys.readouterr()
    return stopped.value.code, out, err


@pytest.fixture
def file(tmp_path):
    return block().write(tmp_path / "block.osm")


def test_a_square_patch(capsys, file, tmp_path):
    out = tmp_path / "town.geojson"
    lat, lon = CENTRE
    code, told, err = run(
        capsys, "map", "import", file, "--center", f"{lat},{lon}", "--side-m", 200, "--out", out
    )
    assert code == 0
    assert told.splitlines()[0] == f"{out}: CityMap('town', 41 x 41 cells of 5 m, 14 landmarks)"
    assert err.splitlines()[0] == "reading block.osm"
    assert load_map(out).landmark("FirstBank").name == "First Bank"


def test_everything_as_json(capsys, file, tmp_path):
    out = tmp_path / "town.geojson"
    code, told, _ = run(
        capsys, "map", "import", file, "--all", "--cell-m", 10, "--out", out, "--json"
    )
    assert code == 0
    assert json.loads(told)["cell_m"] == 10
    code, shown, _ = run(capsys, "map", "show", out, "--json")
    assert json.loads(shown) == json.loads(told)


def test_a_box(capsys, file, tmp_path):
    lat, lon = CENTRE
    box = f"{lon - 0.001},{lat - 0.0003},{lon + 0.001},{lat + 0.0003}"
    code, told, _ = run(
        capsys, "map", "import", file, "--bbox", box, "--out", tmp_path / "a.geojson", "--json"
    )
    assert code == 0
    assert json.loads(told)["shape"] == [14, 34]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--center", "1;2", "--side-m", "9"], "'1;2' is not LAT,LON; expected numbers in degrees"),
        (["--center", "1,nan", "--side-m", "9"], "'1,nan' is not LAT,LON"),
        (["--center", "1,2"], "centre and side_m go together; one of them is missing"),
        (["--bbox", "1,2,3"], "'1,2,3' is not WEST,SOUTH,EAST,NORTH"),
        (["--all", "--bbox", "1,2,3,4"], "The patch is given in no way or in several"),
        ([], "The patch is given in no way or in several"),
        (["--all", "--cell-m", "0"], "cell_m is 0.0; expected a positive number of metres"),
    ],
)
def test_mistakes_are_one_line(capsys, file, tmp_path, options, message):
    out = tmp_path / "a.geojson"
    code, told, err = run(capsys, "map", "import", file, *options, "--out", out)
    assert (code, told) == (2, "")
    assert err.splitlines()[-1].startswith("sloop: ")
    assert message in err.splitlines()[-1]
    assert not out.exists()


def test_an_output_path_is_checked_before_the_work(capsys, file, tmp_path):
    code, _, err = run(capsys, "map", "import", file, "--all", "--out", tmp_path / "a.txt")
    assert code == 2
    assert len(err.splitlines()) == 1
    code, _, err = run(
        capsys, "map", "import", file, "--all", "--out", tmp_path / "no" / "a.geojson"
    )
    assert code == 2
    assert err.endswith("does not exist; make it first\n")


def test_a_broken_file_leaves_the_old_map(capsys, tmp_path):
    out = tmp_path / "a.geojson"
    out.write_text("old")
    broken = tmp_path / "b.osm"
    broken.write_text("<osm>")
    assert run(capsys, "map", "import", broken, "--all", "--out", out)[0] == 2
    assert out.read_text() == "old"


def test_fetch_needs_a_place(capsys, tmp_path):
    code, _, err = run(capsys, "map", "fetch", " ", "--out", tmp_path / "a.geojson")
    assert (code, len(err.splitlines())) == (2, 1)
    assert "The place is empty" in err


def test_a_file_without_its_nodes_is_refused_unless_that_is_allowed(capsys, tmp_path):
    osm = block()
    osm.nodes = [node for node in osm.nodes if "<tag" in node]
    file = osm.write(tmp_path / "ways.xml")
    lat, lon = CENTRE
    patch = ("--center", f"{lat},{lon}", "--side-m", 200, "--out", tmp_path / "a.geojson")
    code, out, err = run(capsys, "map", "import", file, *patch)
    assert (code, out) == (2, "")
    assert "give --allow-incomplete" in err
    assert not (tmp_path / "a.geojson").exists()
    code, out, _ = run(capsys, "map", "import", file, *patch, "--allow-incomplete")
    assert code == 0
    assert "left out, without coordinates in the file: " in out
