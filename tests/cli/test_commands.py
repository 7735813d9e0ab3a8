"""What the commands print and write."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

from sloop_ppl.cli import main

TEXT = "the green toyota is behind velvet dog"


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as done:
        main([str(a) for a in arguments])
    out, err = capsys.readouterr()
    assert done.value.code == 0, err
    return out, err


def test_parse_prints_the_contracts_keys(capsys):
    out, _ = run(capsys, "parse", TEXT, "--map", "cleveland", "--json")
    told = json.loads(out)
    assert list(told) == ["text", "map", "targets", "relations", "readings", "unresolved"]
    (relation,) = told["relations"]
    assert set(relation) == {
        "figure", "relation", "ground", "group", "negated", "status", "either", "distance_m",
        "distance", "candidates", "spans", "confidence",
    }  # fmt: skip
    assert (relation["figure"], relation["relation"], relation["ground"]) == (
        "GreenToyota",
        "behind",
        "VelvetDog",
    )
    assert [TEXT[slice(*relation["spans"][k])] for k in ("figure", "relation", "ground")] == [
        "green toyota",
        "behind",
        "velvet dog",
    ]
    assert (relation["status"], relation["either"]) == ("asserted", None)
    assert relation["candidates"] == [{"ground": "VelvetDog", "p": 1.0}]
    likely, nothing = told["readings"]
    assert likely["relations"] == told["relations"]
    assert nothing["relations"] == []
    assert likely["p"] + nothing["p"] == pytest.approx(1)
    assert relation["confidence"] == pytest.approx(likely["p"], abs=1e-4)


def test_parse_shows_the_words_it_read(capsys):
    out, _ = run(capsys, "parse", TEXT, "--map", "cleveland")
    for word in ("GreenToyota", "behind", "VelvetDog", "velvet dog"):
        assert word in out


def test_parse_names_the_part_of_a_street_that_is_meant(capsys):
    text = "The red bike is near the NE corner of West 6th Street and Johnson Court"
    printed = json.loads(run(capsys, "parse", text, "--map", "cleveland", "--json")[0])
    parts = [(r["relation"], r["ground"], r.get("part")) for r in printed["relations"]]
    corner = {"kind": "corner", "bearing_deg": 45, "number": None}
    assert parts == [
        ("near", "West6thSt", None),
        ("near", "JohnsonCourt", None),
        ("northeast", "West6thSt", corner),
        ("northeast", "JohnsonCourt", corner),
    ]
    assert "part" not in printed["relations"][0]
    out, _ = run(capsys, "parse", "The red bike is at 9 Johnson Court", "--map", "cleveland")
    assert "9 JohnsonCourt" in out


def test_infer_prints_the_contracts_keys(capsys):
    out, _ = run(capsys, "infer", TEXT, "--map", "cleveland", "--json")
    told = json.loads(out)
    assert list(told) == ["map", "model", "engine", "log_evidence", "readings", "targets"]
    assert [reading["relations"] for reading in told["readings"]] == [1, 0]
    assert sum(reading["posterior"] for reading in told["readings"]) == pytest.approx(1)
    target = told["targets"]["GreenToyota"]
    assert set(target) == {
        "mode_m", "mode_lonlat", "entropy_nats", "expected_m", "hpd90_cells", "nearest",
        "components", "frames", "grounds",
    }  # fmt: skip
    assert target["grounds"] == [
        {"relation": "behind", "candidates": [{"ground": "VelvetDog", "p": 1.0}]}
    ]
    assert sum(target["components"].values()) == pytest.approx(1)
    (frame,) = target["frames"]
    assert set(frame) == {"ground", "relation", "mean_deg", "kappa", "p"}
    # Velvet Dog faces West 6th Street, which lies to its northeast; behind it is the southwest.
    assert 0 < frame["mean_deg"] < 90
    assert target["expected_m"][0] < -31
    assert target["expected_m"][1] < -39


def test_infer_says_in_words_where_the_belief_lies(capsys):
    out, _ = run(capsys, "infer", TEXT, "--map", "cleveland", "--model", "sloop-m4")
    assert "GreenToyota: most probably" in out
    assert "Velvet Dog" in out


def test_infer_explains(capsys):
    out, _ = run(capsys, "infer", TEXT, "--map", "cleveland", "--explain")
    assert out.startswith("GreenToyota\n  where: most probably ")
    assert "what would change it:" in out


def test_infer_exports_cells(tmp_path, capsys):
    cells = tmp_path / "cells.geojson"
    run(capsys, "infer", TEXT, "--map", "cleveland", "--export", cells)
    told = json.loads(cells.read_text(encoding="utf-8"))
    assert len(told["features"]) == 41 * 41


def test_infer_writes_what_it_is_asked_for(tmp_path, capsys):
    from sloop_ppl import Posterior

    figure, saved = tmp_path / "f.png", tmp_path / "p.nc"
    run(capsys, "infer", TEXT, "--map", "cleveland", "--figure", figure, "--out", saved)
    assert figure.read_bytes().startswith(b"\x89PNG")
    assert Posterior.load(saved).targets == ("GreenToyota",)
    again, _ = run(capsys, "infer", TEXT, "--map", "cleveland", "--prior", saved, "--json")
    first, _ = run(capsys, "infer", TEXT, "--map", "cleveland", "--json")
    entropies = [json.loads(t)["targets"]["GreenToyota"]["entropy_nats"] for t in (again, first)]
    assert entropies[0] < entropies[1]  # said twice, it is believed more


def test_declared_targets_are_the_ones_that_are_read(tmp_path, capsys):
    declared = tmp_path / "targets.json"
    declared.write_text(
        json.dumps([{"id": "MyDog", "names": ["my dog", "rex"], "colour": None, "kind": "dog"}])
    )
    out, _ = run(
        capsys, "infer", "Rex is near the Hat Factory", "--map", "cleveland",
        "--targets", declared, "--json",
    )  # fmt: skip
    assert list(json.loads(out)["targets"]) == ["MyDog"]


def test_search_prints_the_contracts_keys_and_progress_apart(capsys):
    out, err = run(
        capsys, "search", TEXT, "--map", "cleveland", "--place", "GreenToyota=-37.5,-72.5",
        "--start", "-22.5,-62.5,180", "--planner", "greedy", "--json",
    )  # fmt: skip
    told = json.loads(out)
    assert set(told) == {
        "map", "model", "planner", "seed", "sims", "places", "poses", "actions", "observations",
        "rewards", "found", "found_targets", "steps", "discounted_return",
    }  # fmt: skip
    assert told["found"] is True
    assert told["found_targets"] == ["GreenToyota"]
    assert told["steps"] == len(told["actions"]) == len(told["poses"]) - 1
    assert told["poses"][0] == [-22.5, -62.5, 180.0]
    assert err.count("\n") == told["steps"]
    returns = sum(0.95**t * r for t, r in enumerate(told["rewards"]))
    assert told["discounted_return"] == pytest.approx(returns)


def test_a_place_that_is_not_given_is_imagined_from_the_belief(capsys):
    out, _ = run(
        capsys, "search", TEXT, "--map", "cleveland", "--planner", "random", "--steps", 3, "--json"
    )
    told = json.loads(out)
    assert told["imagined"] == ["GreenToyota"]
    assert list(told["places"]) == ["GreenToyota"]


@pytest.mark.slow
def test_search_gives_the_same_bytes_whatever_the_hash_seed():
    command = [
        sys.executable, "-c", "from sloop_ppl.cli import main; main()", "search", TEXT,
        "--map", "cleveland", "--place", "GreenToyota=-37.5,-72.5", "--seed", "0", "--json",
    ]  # fmt: skip
    outs = {
        subprocess.run(
            command, env={**os.environ, "PYTHONHASHSEED": seed}, capture_output=True, check=True
        ).stdout
        for seed in ("0", "1", "4242")
    }
    assert len(outs) == 1


@pytest.mark.slow
def test_the_demonstration_writes_its_five_files(tmp_path, capsys):
    out, _ = run(capsys, "demo", "--out", tmp_path / "out")
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert written == {"belief.png", "search.png", "search.gif", "posterior.nc", "episode.json"}
    assert "RedBike" in out
    episode = json.loads((tmp_path / "out" / "episode.json").read_text())
    assert episode["found_targets"] == ["GreenToyota", "RedBike"]


def test_map_show_counts_by_kind(capsys):
    out, _ = run(capsys, "map", "show", "cleveland", "--json")
    told = json.loads(out)
    assert list(told) == ["name", "extent_m", "cell_m", "shape", "counts", "named"]
    assert told["counts"]["building"] == 28
    assert told["shape"] == [41, 41]


@pytest.mark.parametrize(
    ("what", "name"),
    [("models", "sloop-m4"), ("engines", "exact"), ("planners", "pouct"), ("maps", "austin"),
     ("likelihoods", "gaussian-clipped"), ("frames", "nearest-street")],
)  # fmt: skip
def test_list_names_what_can_be_chosen(what, name, capsys):
    out, _ = run(capsys, "list", what)
    assert name in out.split()


def test_version(capsys):
    out, _ = run(capsys, "--version")
    assert out.startswith("sloop_ppl ")


def test_any_map_file_works_like_a_bundled_name(tmp_path, capsys):
    from sloop_ppl.maps import load_map, write_map

    path = tmp_path / "mine.geojson"
    write_map(load_map("cleveland"), path)
    by_path, _ = run(capsys, "infer", TEXT, "--map", path, "--json")
    by_name, _ = run(capsys, "infer", TEXT, "--map", "cleveland", "--json")
    assert (
        json.loads(by_path)["targets"]["GreenToyota"]["mode_m"]
        == (json.loads(by_name)["targets"]["GreenToyota"]["mode_m"])
    )


def test_an_engine_that_draws_is_seeded(capsys):
    given = ("infer", TEXT, "--map", "cleveland", "--engine", "importance", "--seed", "3")
    first, again = (run(capsys, *given, "--json")[0] for _ in range(2))
    assert first == again
    other, _ = run(capsys, *given[:-1], "4", "--json")
    assert other != first


def test_an_explanation_beside_json_goes_to_stderr(capsys):
    out, err = run(capsys, "infer", TEXT, "--map", "cleveland", "--json", "--explain")
    assert json.loads(out)["map"] == "cleveland"
    assert "what would change it:" in err
