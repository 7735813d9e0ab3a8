"""What docs/simulation.md says of numbers, commands and pictures is so."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from sloop_ppl.simulation import CLEARANCE_M, DETECTORS, measured_rates

PAGE = Path(__file__).parents[2] / "docs" / "simulation.md"
TEXT = " ".join(PAGE.read_text(encoding="utf-8").split())


def test_its_pictures_are_there():
    for name in re.findall(r"\]\((images/[^)]+)\)", TEXT):
        assert (PAGE.parent / name).stat().st_size > 10_000


def test_its_numbers_are_those_of_the_code():
    assert f"keep {CLEARANCE_M:g} m from their walls" in TEXT
    for name in DETECTORS:
        assert f"`{name}`" in TEXT
    rates = measured_rates("camera")
    shown = (
        f"{rates.true_positive:g}".lstrip("0"), f"{rates.false_positive:g}".lstrip("0"),
        f"{rates.position_noise_cells:g}".lstrip("0"),
    )  # fmt: skip
    assert "The planner is given {}, {} and a noise of {} cells".format(*shown) in TEXT


@pytest.mark.parametrize("command", ["fly", "eval camera", "eval fly"])
def test_its_commands_are_there(command, capsys):
    from sloop_ppl.cli import main

    with pytest.raises(SystemExit) as done:
        main([*command.split(), "--help"])
    assert not done.value.code
    assert f"sloop {command}" in TEXT
    assert "--" in capsys.readouterr().out
