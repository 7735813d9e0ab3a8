"""`sloop search` with a planner and a sensor from files of one's own."""

from __future__ import annotations

import json

import pytest

from sloop_ppl.cli import main

SEARCH = ["search", "the green toyota is behind velvet dog", "--map", "cleveland", "--place",
          "GreenToyota=-37.5,-72.5", "--start", "-22.5,-62.5,180", "--steps", "6"]  # fmt: skip

MINE = """
import numpy as np

from sloop_ppl.planning import MaskSensor, Pouct

few = Pouct(sims=20)


class Straight:
    def plan(self, agent):
        return "forward"


class Undecided:
    def plan(self, agent):
        return "up"


class Broken:
    def plan(self, agent):
        return 1 / 0


class Disk(MaskSensor):
    def __init__(self, city):
        super().__init__(city.grid)

    def view(self, pose):
        x, y = np.meshgrid(self.grid.x_m, self.grid.y_m)
        return np.hypot(x - pose.x_m, y - pose.y_m) <= 10.0


class Small(Disk):
    def view(self, pose):
        return np.ones((2, 2), dtype=bool)


class Dead(Disk):
    def view(self, pose):
        raise KeyError("lens")
"""


@pytest.fixture
def mine(tmp_path, monkeypatch):
    (tmp_path / "mine.py").write_text(MINE)
    monkeypatch.chdir(tmp_path)


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as done:
        main([*SEARCH, *arguments])
    out, err = capsys.readouterr()
    return done.value.code, out, err


@pytest.mark.usefixtures("mine")
def test_a_planner_from_a_file_searches(capsys):
    code, out, _ = run(capsys, "--planner", "mine.py:Straight", "--json")
    told = json.loads(out)
    assert code == 0
    assert told["planner"] == "mine.py:Straight"
    assert told["actions"] == ["forward"] * 6
    code, out, _ = run(capsys, "--planner", "mine.py:few", "--json")
    assert json.loads(out)["planner"] == "pouct"
    assert json.loads(out)["sims"] == 20


@pytest.mark.usefixtures("mine")
@pytest.mark.parametrize("planner", ["greedy", "fast"])
def test_a_sensor_from_a_file_sees(planner, capsys, tmp_path):
    out = tmp_path / "e.json"
    code, _, err = run(capsys, "--planner", planner, "--sensor", "mine.py:Disk", "--out", str(out))
    assert code == 0, err
    views = json.loads(out.read_text())["views"]
    assert {len(view) for view in views} == {13}  # every cell within two of the robot's own


@pytest.mark.usefixtures("mine")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["--planner", "mine.py:Undecided"],
            "Planner 'mine.py:Undecided' chose 'up'; expected one of: forward, left, right, find",
        ),
        (
            ["--planner", "mine.py:Broken"],
            "'mine.py:Broken' fails in plan at line 21: ZeroDivisionError: division by zero",
        ),
        (
            ["--planner", "mine.py:Disk"],
            (
                "Planner 'mine.py:Disk' is a Disk; expected a planner's name, or an object with a "
                "method plan(agent) that returns an action"
            ),
        ),
        (
            ["--planner", "mine.py:Strayght"],
            (
                "Planner of mine.py 'Strayght' is unknown; expected one of few, Straight, "
                "Undecided, Broken; did you mean 'Straight'?"
            ),
        ),
        (
            ["--planner", "yours.py:Any"],
            "Planner file 'yours.py' does not exist; give FILE.py:NAME",
        ),
        (
            ["--sensor", "mine.py:Small"],
            (
                "The view of sensor Small has shape (2, 2) and type bool; expected the map's "
                "cells, (41, 41), as bool"
            ),
        ),
        (
            ["--sensor", "mine.py:Dead"],
            "Sensor 'mine.py:Dead' fails in view at line 40: KeyError: 'lens'",
        ),
        (
            ["--sensor", "mine.py:Straight"],
            (
                "Sensor 'mine.py:Straight' is a Straight; expected an object with the methods "
                "view(pose), log_likelihood(pose, report) and sample(pose, places, rng), such as a "
                "MaskSensor"
            ),
        ),
        (
            ["--sensor", "mine.py:Disk", "--range", "5"],
            (
                "sensor_range_cells is 5.0, but the sensor is a Disk, which has its own; leave "
                "sensor_range_cells out, or the sensor"
            ),
        ),
    ],
)
def test_mistakes_are_one_line(arguments, message, capsys):
    code, out, err = run(capsys, *arguments)
    assert code == 2
    assert out == ""
    assert err.splitlines()[-1].endswith(message)
    assert len(err.splitlines()) == 1


@pytest.mark.usefixtures("mine")
@pytest.mark.parametrize("planner", ["pouct", "pomcp", "greedy", "fast"])
def test_a_sensor_from_a_file_searches_a_belief_from_a_file(planner, capsys):
    with pytest.raises(SystemExit):
        main(["infer", SEARCH[1], "--map", "cleveland", "--out", "p.nc"])
    with pytest.raises(SystemExit) as done:
        main(["search", "--posterior", "p.nc", *SEARCH[4:], "--sensor", "mine.py:Disk",
              "--planner", planner, "--sims", "60", "--json"])  # fmt: skip
    assert done.value.code == 0
    found = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert found["planner"] == planner
    assert found["steps"] <= 6
