"""`--hearer` of parse, infer and search, with a parser of the test's own."""

from __future__ import annotations

import json

import pytest

import sloop_ppl as sloop
from sloop_ppl.bridge import facade
from sloop_ppl.bridge._typed import read_hearer
from sloop_ppl.cli import main
from sloop_ppl.errors import InputError
from sloop_ppl.language import HEARER, PARSERS, Description, SpatialRelation, TargetObject

MALFORMED = (
    "Hearer '{}' is malformed; expected x,y in metres, such as -20,150, or @LAT,LON in "
    "degrees, such as @41.4993,-81.6944 or 41.4993N,81.6944W: where who "
    "listens is, inside the map or outside"
)


@pytest.fixture
def hearing(monkeypatch):
    """Let the default parser read whatever is said as "the red bike is north of you"."""

    def read(text, city, targets):
        north = SpatialRelation("RedBike", "north", (HEARER,))
        return Description(text, city.name, (TargetObject("RedBike"),), (north,))

    monkeypatch.setitem(PARSERS._entries, "rules", read)


def run(capsys, code, *arguments):
    with pytest.raises(SystemExit) as done:
        main([str(a) for a in arguments])
    out, err = capsys.readouterr()
    assert done.value.code == code, err
    return out, err


def test_the_hearer_goes_into_the_description():
    read = sloop.parse("the red bike is near Ivy", "cleveland", hearer=(10, 400))
    assert read.hearer == (10.0, 400.0)
    assert facade.parse("the red bike is near Ivy", "cleveland").hearer is None
    post = sloop.infer("the red bike is near Ivy", "cleveland", hearer=(10, 400))
    assert post.descriptions[0].hearer == (10.0, 400.0)
    assert sloop.infer(read, "cleveland").descriptions[0].hearer == (10.0, 400.0)
    moved = sloop.infer(read, "cleveland", hearer=(0, 0))
    assert moved.descriptions[0].hearer == (0.0, 0.0)


@pytest.mark.usefixtures("hearing")
def test_infer_and_search_measure_from_the_hearer(capsys):
    words = ("north of you", "--map", "cleveland")
    modes = []
    for place in ("-60,-70", "60,-250"):
        out, _ = run(capsys, 0, "infer", *words, "--hearer", place, "--json")
        modes.append(json.loads(out)["targets"]["RedBike"]["mode_m"])
    (x0, y0), (x1, y1) = modes
    assert abs(x0 + 60) < 10
    assert -70 < y0 < -30
    assert abs(x1 - 60) < 10
    assert y1 < -90  # the nearest cells of the map to who is south of it
    out, _ = run(capsys, 0, "search", *words, "--hearer", "0,0", "--steps", "2", "--json")
    assert json.loads(out)["steps"] == 2


@pytest.mark.usefixtures("hearing")
def test_without_it_the_error_names_the_option(capsys):
    out, err = run(capsys, 2, "infer", "north of you", "--map", "cleveland")
    assert out == ""
    assert err.count("\n") == 1
    assert "--hearer X,Y" in err
    assert "field 'hearer'" in err


@pytest.mark.parametrize("typed", ["1", "1,2,3", "a,b", "nan,0", "inf,0", ""])
def test_what_is_no_place_is_refused(capsys, typed):
    with pytest.raises(InputError) as caught:
        read_hearer(typed)
    assert str(caught.value) == MALFORMED.format(typed)
    for command in ("parse", "infer", "search"):
        out, err = run(
            capsys, 2, command, "the bike is near Ivy", "--map", "cleveland", "--hearer", typed
        )
        assert out == ""
        assert err.strip().endswith(MALFORMED.format(typed))


def test_a_saved_posterior_keeps_its_own(capsys, tmp_path):
    post = sloop.infer("the red bike is near Ivy", "cleveland")
    post.save(tmp_path / "p.nc")
    _, err = run(capsys, 2, "search", "--posterior", tmp_path / "p.nc", "--hearer", "1,2")
    assert "--hearer does not go with --posterior" in err
