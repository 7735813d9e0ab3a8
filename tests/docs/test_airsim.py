"""The Python of docs/airsim.md runs as it stands, against a server of a stand-in vehicle."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

pytest.importorskip("msgpack", reason="the server needs msgpack, of sloop-ppl[sim]")

from bare_client import BareClient
from kinematic_vehicle import Box, KinematicVehicle
from serving import served

import sloop_ppl.simulation
from sloop_ppl.simulation.airsim_server import AirSimServer

PAGE = (Path(__file__).parents[2] / "docs" / "airsim.md").read_text()


def test_the_search_of_the_page_finds_its_car(monkeypatch, capsys):
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    vehicle = KinematicVehicle({"Car_12": Box(-19.5, 51.6, -15.5, 53.4, 1.5)})
    with served(vehicle) as server:
        client = BareClient(server.port)
        monkeypatch.setattr(sloop_ppl.simulation, "connect", lambda host, port: client)
        exec(compile(code, "docs/airsim.md", "exec"), {})
        client.raw.close()
    assert capsys.readouterr().out.startswith("True ")


def test_the_page_lists_the_calls_that_are_served():
    section = PAGE.split("## Our server")[1]
    (listed,) = re.findall(r"```\n(ping .*?)```", section, re.DOTALL)
    names = re.sub(r"\(.*?\)", "", listed).split()
    assert len(names) == 19
    assert set(names) == set(AirSimServer(KinematicVehicle())._calls)
