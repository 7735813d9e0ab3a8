"""Finished fits are kept on disk, taken up again, and made anew when what they are of differs."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from sloop_ppl.cli import main
from sloop_ppl.errors import InputError
from sloop_ppl.eval import _fit_files as files_module
from sloop_ppl.eval import _selection as selection
from sloop_ppl.eval._fit_files import fit_files
from sloop_ppl.eval._kept_fits import KeptFits
from sloop_ppl.inference.learning import Fitted
from tests.support.example_lines import write_examples

WANTED = ("austin-ex-04", "cleveland-ex-04")
FITTED = Fitted(
    "mine",
    {"model": {"lapse": 0.1 + 0.2}},
    {"model": {"lapse": (0.1, 0.7)}},
    {"mean_log_score_after": -3.25, "targets": 2},
)


@pytest.fixture
def said(tmp_path, monkeypatch):
    monkeypatch.setattr(files_module, "git_state", lambda: None)  # someone may commit meanwhile
    return write_examples(tmp_path / "said.jsonl", *WANTED)


def test_a_fit_comes_back_as_it_was(tmp_path):
    kept = KeptFits(tmp_path / "m.fits", {"models": {"mine": "1"}})
    assert not kept.path.exists()
    assert kept.get("mine", ["a", "b"]) is None
    kept.keep("mine", ["a", "b"], FITTED)
    told = []
    again = KeptFits(tmp_path / "m.fits", {"models": {"mine": "1"}}, told.append)
    assert told == [f"finished fits taken from {kept.path}: 1"]
    assert again.get("mine", ["b", "a"]).to_json() == FITTED.to_json()
    assert again.get("mine", ["a"]) is again.get("other", ["a", "b"]) is None
    again.remove()
    assert not kept.path.exists()


def test_fits_of_something_else_are_made_anew(tmp_path):
    KeptFits(tmp_path / "m.fits", {"models": {"mine": "1"}}).keep("mine", ["a"], FITTED)
    told = []
    other = KeptFits(tmp_path / "m.fits", {"models": {"mine": "2"}}, told.append)
    (line,) = told
    assert line.endswith("holds fits of something else (models.mine was 1 and is 2): starting anew")
    assert (other.count, other.get("mine", ["a"])) == (0, None)
    other.keep("mine", ["b"], FITTED)
    assert other.count == 1
    assert other.get("mine", ["a"]) is None


@pytest.mark.parametrize(
    "damage",
    [
        lambda text: text[:40],
        lambda text: "{}",
        lambda text: "[]",
        lambda text: text.replace('"fitted"', '"other"'),
        lambda text: text.replace("0.7", '"much"'),
        lambda text: text.replace('"mine"', "7"),
    ],
)
def test_a_torn_or_strange_file_is_no_fit(tmp_path, damage):
    kept = KeptFits(tmp_path / "m.fits", {})
    kept.keep("mine", ["a"], FITTED)
    (file,) = kept.path.glob("fit-*.json")
    assert kept.get("mine", ["a"]) is not None
    text = file.read_text()
    assert damage(text) != text
    file.write_text(damage(text))
    assert kept.get("mine", ["a"]) is None


def test_another_folder_is_left_alone(tmp_path):
    (tmp_path / "m.fits").mkdir()
    KeptFits(tmp_path / "m.fits", {})  # an empty one will do
    (tmp_path / "m.fits" / "thesis.txt").write_text("mine")
    with pytest.raises(InputError, match=r"m\.fits' is no folder of fits; finished fits are kept"):
        KeptFits(tmp_path / "m.fits", {})
    assert (tmp_path / "m.fits" / "thesis.txt").exists()


def stopped_after(monkeypatch, count):
    """Let Ctrl-C come in a fit, after some; return the list of what is fitted."""
    made = []

    def stop(examples, model, **options):
        if len(made) == count:
            raise KeyboardInterrupt
        made.append({example.city.name for example in examples})
        return real(examples, model, **{**options, "learn": ["lapse", "weights"]})

    real = selection.fit
    monkeypatch.setattr(selection, "fit", stop)
    return made


def test_the_same_command_goes_on_after_ctrl_c(said, tmp_path, monkeypatch, capsys):
    out = tmp_path / "m.json"
    command = ["eval", "fit", str(said), "--models", "student-vonmises", "--out"]
    with monkeypatch.context() as patch:
        stopped_after(patch, 1)
        with pytest.raises(SystemExit) as done:
            main([*command, str(out)])
    assert done.value.code == 130
    err = capsys.readouterr().err
    assert "fit 1 of 3, student-vonmises to cleveland: 5 iterations: mean log score" in err
    kept = f"finished fits kept in {tmp_path / 'm.fits'}: 1; the same command goes on"
    assert err.endswith(f"{kept}\nsloop: stopped\n")
    assert not out.exists()
    with monkeypatch.context() as patch:
        made = stopped_after(patch, 9)
        with pytest.raises(SystemExit) as done:
            main([*command, str(out)])
        assert done.value.code in (0, None)
        assert made == [{"austin"}, {"austin", "cleveland"}]
        assert f"finished fits taken from {tmp_path / 'm.fits'}: 1\n" in capsys.readouterr().err
        assert not (tmp_path / "m.fits").exists()
        with pytest.raises(SystemExit):
            main([*command, str(tmp_path / "whole.json")])
    assert json.loads(out.read_text()) == json.loads((tmp_path / "whole.json").read_text())


def test_other_descriptions_are_fitted_anew(said, tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        stopped_after(patch, 2)
        with pytest.raises(KeyboardInterrupt):
            fit_files([said], out=tmp_path / "m.json", models="student-vonmises")
    assert len(list((tmp_path / "m.fits").glob("fit-*.json"))) == 2
    write_examples(said, "austin-ex-04", "cleveland-ex-06")
    told, made = [], stopped_after(monkeypatch, 9)
    fit_files([said], out=tmp_path / "m.json", models="student-vonmises", progress=told.append)
    assert "holds fits of something else (descriptions.said.jsonl was " in told[0]
    assert told[0].endswith("): starting anew")
    assert made == [{"cleveland"}, {"austin"}, {"austin", "cleveland"}]


def test_files_of_one_name_are_told_apart(said, tmp_path):
    (tmp_path / "more").mkdir()
    other = write_examples(tmp_path / "more" / "said.jsonl", "austin-ex-05", "cleveland-ex-02")
    with pytest.MonkeyPatch.context() as patch:
        stopped_after(patch, 1)
        with pytest.raises(KeyboardInterrupt):
            fit_files([said, other], out=tmp_path / "m.json", models="student-vonmises")
    told = json.loads((tmp_path / "m.fits" / "manifest.json").read_text())
    assert set(told["descriptions"]) == {str(said), str(other)}


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C is another thing there")
def test_ctrl_c_at_any_moment_ends_with_130(said, tmp_path):
    asked = [
        sys.executable, "-c", "from sloop_ppl.cli import main; main()", "eval", "fit", str(said),
        "--models", "student-vonmises", "--out", str(tmp_path / "m.json"),
    ]  # fmt: skip
    command = subprocess.Popen(asked, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    while "done" not in command.stderr.readline():
        assert command.poll() is None
    time.sleep(0.05)
    command.send_signal(signal.SIGINT)
    out, err = command.communicate()
    assert command.returncode == 130
    assert out == ""
    assert err.endswith("sloop: stopped\n")
    assert "Traceback" not in err
    assert list((tmp_path / "m.fits").glob("fit-*.json"))
