"""The demonstrations run, show what they claim, and are the same every time."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


def example(name: str):
    spec = importlib.util.spec_from_file_location(f"example_{name}", EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_the_mistaken_phrase_is_named_and_the_car_is_found(tmp_path, capsys):
    result = example("mistaken_phrase").main(tmp_path / "a.png", smoke=True)
    assert result.suspected == "on West 4th Street"
    assert result.p_wrong["on West 4th Street"] > 0.7
    assert max(p for phrase, p in result.p_wrong.items() if phrase != result.suspected) < 0.3
    assert result.error_m["SLOOP's product"] > 80
    assert result.error_m["with a lapse for each phrase"] < 15
    assert result.log_score["with a lapse for each phrase"] > -6
    assert result.log_score["SLOOP's product"] < -20
    assert "“on West 4th Street” is wrong with probability 0.8" in capsys.readouterr().out
    assert (tmp_path / "a.png").stat().st_size > 10_000


def test_finding_one_car_moves_the_other(tmp_path, capsys):
    result = example("speaker_frame").main(tmp_path / "a.png", smoke=True)
    before, after = result.east
    assert before < 0.3
    assert after > 0.55
    assert result.faces_west[0] < 0.1
    assert result.faces_west[1] > 0.4
    assert result.east_strangers[0] == pytest.approx(result.east_strangers[1])
    assert result.east_strangers[0] == pytest.approx(before, abs=0.02)
    assert "once the Honda is found" in capsys.readouterr().out


def test_two_questions_find_the_other_bar(tmp_path, capsys):
    result = example("dialogue").main(tmp_path / "a.png", smoke=True)
    assert len(result.questions) == len(result.answers) == 2
    assert result.bar[0]["Ivy"] >= result.bar[0]["BarleyHouse"]
    assert result.bar[-1]["BarleyHouse"] > 0.9
    assert result.asking > result.silent + 50
    assert "the bar was BarleyHouse" in capsys.readouterr().out
    assert (tmp_path / "a.png").stat().st_size > 50_000


@pytest.mark.slow
@pytest.mark.parametrize("name", ["mistaken_phrase", "speaker_frame"])
def test_an_example_is_a_script_that_gives_the_same_bytes(name, tmp_path):
    told = []
    for run in "ab":
        done = subprocess.run(
            [sys.executable, EXAMPLES / f"{name}.py", "--smoke", "--out", f"{run}.png"],
            cwd=tmp_path, capture_output=True, text=True, check=True,
            env={"PYTHONHASHSEED": str(ord(run)), "PATH": "", "MPLCONFIGDIR": str(tmp_path)},
        )  # fmt: skip
        told.append((done.stdout, (tmp_path / f"{run}.png").read_bytes()))
    assert told[0] == told[1]


def test_a_flown_search_is_drawn(tmp_path, capsys):
    from sloop_ppl.errors import InputError

    try:
        example("flown_search").main(tmp_path / "a.png", smoke=True)
    except InputError as error:
        if "mujoco" in str(error) or "No pictures can be made here" in str(error):
            pytest.skip(str(error))
        raise
    assert "2 steps, found nothing" in capsys.readouterr().out
    assert (tmp_path / "a.png").stat().st_size > 10_000
