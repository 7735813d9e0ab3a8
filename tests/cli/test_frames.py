"""`sloop frames train`, `sloop frames predict`, `sloop eval frames` and `--frames`."""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path

import pytest
from support.facing_block import facing_town

from sloop_ppl.cli import main
from sloop_ppl.maps import write_map
from sloop_ppl.models.frames import load_weights
from sloop_ppl.models.tuning import load_parameters

TEXT = "the green toyota is behind velvet dog"


def run(capsys, code, *arguments):
    with pytest.raises(SystemExit) as done:
        main([str(a) for a in arguments])
    out, err = capsys.readouterr()
    assert done.value.code == code, err
    return out, err


@pytest.fixture
def towns(tmp_path):
    folder = tmp_path / "maps"
    folder.mkdir()
    for i in range(2):
        write_map(facing_town(f"town{i}", blocks=5, seed=i), folder / f"town{i}.geojson")
    return folder


@pytest.mark.slow
def test_train_writes_weights_that_predict_and_infer(capsys, tmp_path, towns):
    out = tmp_path / "mine.safetensors"
    told, err = run(
        capsys, 0, "frames", "train", "--maps", towns, "--out", out, "--recipe", "ego",
        "--epochs", 1, "--json",
    )  # fmt: skip
    assert json.loads(told)["trained_on"] == "town0 (60), town1 (60)"
    assert "pass 1: loss" in err
    about = load_weights(out).about
    assert about["command"] == (
        "sloop frames train --maps DIR --recipe ego --epochs 1 --seed 0 --out ego.safetensors"
    )
    first, tuned = out.read_bytes(), tmp_path / "tuned.json"
    examples = (Path(str(files("sloop_ppl"))) / "data" / "examples.jsonl").read_text("utf-8")
    framed = [line for line in examples.splitlines() if '"behind"' in line or '"front"' in line]
    said = tmp_path / "said.jsonl"
    said.write_text("\n".join(framed[:2]), "utf-8")
    told, err = run(
        capsys, 0, "frames", "train", "--maps", towns, "--out", out, "--recipe", "ego",
        "--epochs", 1, "--descriptions", said, "--tuned", tuned,
    )  # fmt: skip
    assert "tuned: kappa" in told
    assert list(load_parameters(tuned)["frames"]) == ["kappa", "absolute"]
    assert out.read_bytes() == first
    told, _ = run(
        capsys, 0, "frames", "predict", towns / "town0.geojson", "--frames", out, "--json"
    )
    assert len(json.loads(told)["landmarks"]) == 60
    told, _ = run(capsys, 0, "infer", TEXT, "--map", "cleveland", "--frames", out, "--json")
    frames = json.loads(told)["targets"]["GreenToyota"]["frames"]
    assert len(frames) > 1


def test_predict_tells_distributions(capsys, tmp_path):
    figure = tmp_path / "fronts.png"
    told, _ = run(
        capsys, 0, "frames", "predict", "cleveland", "--landmark", "BallBuilding", "--landmark",
        "WaringBlock", "--json", "--figure", figure,
    )  # fmt: skip
    report = json.loads(told)
    assert list(report) == ["map", "frames", "landmarks"]
    assert list(report["landmarks"]) == ["BallBuilding", "WaringBlock"]
    for front in report["landmarks"].values():
        weights = [part["p"] for part in front["parts"]]
        assert sum(weights) + front["lapse"] == pytest.approx(1)
    assert figure.stat().st_size > 10_000
    told, _ = run(capsys, 0, "frames", "predict", "cleveland", "--landmark", "West6thSt")
    assert told.count("p 0.50") == 2


def test_infer_takes_the_name_of_a_predictor(capsys):
    mixture, _ = run(
        capsys, 0, "infer", TEXT, "--map", "cleveland", "--frames", "ego-ctx", "--json"
    )
    frames = json.loads(mixture)["targets"]["GreenToyota"]["frames"]
    assert list(frames[0]) == ["ground", "relation", "mean_deg", "kappa", "p"]
    shares = [frame["p"] for frame in frames]
    assert shares == sorted(shares, reverse=True)
    assert sum(shares) <= 1
    point, _ = run(
        capsys, 0, "infer", TEXT, "--map", "cleveland", "--model", "sloop", "--frames", "ego-ctx",
        "--json",
    )  # fmt: skip
    (frame,) = json.loads(point)["targets"]["GreenToyota"]["frames"]
    assert frame["kappa"] is None


def test_all_predictors_are_listed(capsys):
    told, _ = run(capsys, 0, "list", "frames")
    assert told.split() == ["nearest-street", "address", "random", "ego-ctx", "ctx", "ego"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["frames", "predict", "cleveland", "--frames", "ego-ctxx"], "did you mean 'ego-ctx'?"),
        (["frames", "predict", "cleveland", "--frames", "no.safetensors"], "do not exist"),
        (["frames", "predict", "cleveland", "--landmark", "Nowhere"], "'Nowhere' is unknown"),
        (["frames", "predict", "cleveland", "--figure", "fronts.xyz"], "fronts.xyz"),
        (["frames", "train", "--maps", "no-folder", "--out", "w.safetensors"], "is no folder"),
        (["frames", "train", "--maps", ".", "--out", "w.pt"], "expected one of .safetensors"),
        (["frames", "train", "--maps", "."], "Missing option '--out'"),
        (["frames", "train", "--maps", ".", "--out", "w.safetensors", "--tuned", "t.json"],
         "needs both --descriptions"),
        (["eval", "frames", "--maps", "no-folder"], "is no folder"),
        (["eval", "frames"], "0 cities have 50 labelled buildings or more"),
        (["eval", "frames", "--maps", ".", "--recipes", "deep"], "Recipe 'deep' is unknown"),
        (["infer", TEXT, "--map", "cleveland", "--frames", "no.safetensors"], "do not exist"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line(capsys, arguments, says):
    _, err = run(capsys, 2, *arguments)
    assert says in err
    assert err.count("\n") == 1


def test_frames_train_refuses_a_recipe_there_is_none_of(capsys, towns):
    _, err = run(
        capsys, 2, "frames", "train", "--maps", towns, "--out", towns / "w.safetensors",
        "--recipe", "deep",
    )  # fmt: skip
    assert "Recipe 'deep' is unknown" in err.splitlines()[-1]
    assert not (towns / "w.safetensors").exists()
