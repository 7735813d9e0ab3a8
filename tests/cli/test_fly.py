"""`sloop fly`: the keys of a search and of a flight, films, and what is refused in one line."""

from __future__ import annotations

import json
import re
from importlib.util import find_spec

import pytest

from sloop_ppl.cli import main
from sloop_ppl.web._episode_file import read_episode_file

TEXT = "the green toyota is on West 6th Street"
FLY = ["fly", TEXT, "--map", "cleveland", "--place", "GreenToyota=-2.5,-17.5", "--start",
       "-27.5,22.5,0", "--sims", "50", "--detector", "rays"]  # fmt: skip


@pytest.fixture(autouse=True)
def _simulator(request):
    if "monkeypatch" not in request.fixturenames and find_spec("mujoco") is None:
        pytest.skip("the simulator needs mujoco")


def run(capsys, *arguments, code=0):
    with pytest.raises(SystemExit) as done:
        main([str(a) for a in arguments])
    out, err = capsys.readouterr()
    assert done.value.code == code, err
    return out, err


def refused(capsys, *arguments):
    out, err = run(capsys, *arguments, code=2)
    assert out == ""
    assert err.splitlines()[-1].startswith("sloop: ")
    assert "Traceback" not in err
    return err.splitlines()[-1]


def test_a_flown_search_has_the_keys_of_a_search_and_its_own(tmp_path, capsys):
    out, err = run(capsys, *FLY, "--json", "--mjcf", tmp_path / "city.xml")
    flown = json.loads(out)
    searched, _ = run(
        capsys, "search", TEXT, "--map", "cleveland", "--place", "GreenToyota=-2.5,-17.5",
        "--steps", "1", "--planner", "greedy", "--json",
    )  # fmt: skip
    assert set(json.loads(searched)) - {"notes"} <= set(flown)
    assert flown["found"] is True
    assert flown["collisions"] == []
    assert len(flown["detections"]) == flown["steps"]
    assert any(flown["detections"])
    assert flown["time_s"] > flown["steps"]
    assert flown["text"] == TEXT
    (tmp_path / "fly.json").write_text(out)
    played = read_episode_file(tmp_path / "fly.json", "fly")  # as the workbench opens it
    assert len(played["search"]["steps"]) == flown["steps"]
    assert any(step["seen"] for step in played["search"]["steps"])
    assert err.count("facing") == flown["steps"]
    assert (tmp_path / "city.xml").exists()
    again, _ = run(capsys, *FLY, "--json")
    assert again == out


def test_a_flight_is_played_by_a_page_without_a_server(tmp_path, capsys):
    out, _ = run(capsys, *FLY, "--json", "--html", tmp_path / "fly.html")
    page = (tmp_path / "fly.html").read_text()
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    steps = json.loads(found[1])["search"]["steps"]
    flown = json.loads(out)
    assert len(steps) == flown["steps"]
    assert steps[-1]["found"] == ["GreenToyota"]
    refused, words = run(capsys, *FLY, "--html", tmp_path / "fly.txt", code=2)
    assert (refused, words.count("\n")) == ("", 1)


def test_what_is_said_on_the_way_and_where_nothing_was_told(capsys):
    arguments = [a for a in FLY if not a.startswith("GreenToyota") and a != "--place"]
    out, err = run(capsys, *arguments, "--steps", "3", "--say", "2=it is near Velvet Dog", "--json")
    flown = json.loads(out)
    assert flown["imagined"] == ["GreenToyota"]
    assert flown["said"] == {"2": "it is near Velvet Dog"}
    assert "told: “it is near Velvet Dog”" in err


def test_a_battery_ends_a_flight(capsys):
    out, err = run(capsys, *FLY, "--battery", "2", "--json")
    assert json.loads(out)["steps"] == 2
    assert "The battery is empty" in err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--detector", "sonar"), "Detector 'sonar' is unknown"),
        (("--altitude", "1"), "The altitude is 1 m"),
        (("--altitude", "900"), "The altitude is 900 m"),
        (("--wind", "-1"), "wind_m_s is -1"),
        (("--place", "GreenToyota=-2,-78"), "inside Hoyt Block"),
        (("--altitude", "10", "--start", "-2.5,-77.5"), "inside a no-fly building"),
        (("--video", "flight.avi"), ".avi"),
        (("--set", "true_positive_rate=.5"), "true_positive_rate is 0.5"),
        (("--questions", "2"), "does not go with"),
    ],
)
def test_mistakes_are_one_line(capsys, options, words):
    arguments = list(FLY)
    for name in ("--place", "--start", "--detector"):
        if name in options:
            at = arguments.index(name)
            del arguments[at : at + 2]
    assert words in refused(capsys, *arguments, *options)


def test_who_has_no_simulator_is_told_how_to_get_it(capsys, monkeypatch):
    from sloop_ppl.simulation import _mujoco

    monkeypatch.setattr(_mujoco, "find_spec", lambda name: None)
    _mujoco.mujoco.cache_clear()
    try:
        for command in (FLY, ["eval", "camera"], ["eval", "fly", "--out", "none"]):
            assert "pip install 'sloop-ppl[sim]'" in refused(capsys, *command)
    finally:
        _mujoco.mujoco.cache_clear()


def test_a_film_shows_flight_camera_and_belief(tmp_path, capsys):
    from PIL import Image

    from sloop_ppl.simulation._mujoco import rendering_fault

    if rendering_fault():
        pytest.skip(rendering_fault())
    film = tmp_path / "flight.gif"
    try:
        run(capsys, *FLY, "--steps", "3", "--video", film)
    except AssertionError as error:
        if "No pictures can be made here" in str(error):
            pytest.skip(str(error))
        raise
    with Image.open(film) as pictures:
        assert pictures.n_frames > 10
        assert pictures.size[0] > 1000
