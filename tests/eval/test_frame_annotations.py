"""How far annotators agree, solved by hand; labels, and the Human row."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import sloop_ppl as sloop
from sloop_ppl.cli import main
from sloop_ppl.errors import InputError
from sloop_ppl.eval._annotated_frames import HUMAN, score_annotated
from sloop_ppl.eval._frame_annotations import (
    FrameJudgement,
    angular_alpha,
    angular_distance,
    circular_mean,
    consensus,
    frame_agreement,
    labels_of,
    read_judgements,
)
from sloop_ppl.eval._frame_files import frame_lines, score_frames

DEG = math.pi / 180


def judged(annotator, degrees, *, ground="Ivy", relation="front", city="cleveland"):
    front = None if degrees is None else degrees * DEG
    return FrameJudgement(city, "", ground, relation, annotator, front)


def line(name, annotator, degrees, ground="Ivy", relation="front", text="in front of it"):
    about = {"ground": ground, "relation": relation, "annotator": annotator}
    record = {"id": name, "map": "cleveland", "text": text, "frames": []}
    if degrees is None:
        return record | {"unclear": about}
    return record | {"frames": [{**about, "front_deg": degrees}]}


def written(path, *records):
    path.write_text("".join(json.dumps(r) + "\n" for r in records))
    return path


def test_angles_go_round():
    assert angular_distance(350 * DEG, 10 * DEG) == pytest.approx(20 * DEG)
    assert angular_distance(-math.pi, math.pi) == pytest.approx(0)
    assert circular_mean([350 * DEG, 10 * DEG]) == pytest.approx(0)
    assert circular_mean([0, math.pi]) is None


def test_alpha_by_hand():
    """Two units of two: 0 and 20, 180 and 200 degrees.

    Observed: every pair of a unit is 20 apart, so D_o = 20**2. Expected, over the 6 pairs of all
    four: 20, 180, 160, 160, 180, 20 apart (200 is 160 from 0, 180 from 20).
    """
    units = [[0, 20 * DEG], [180 * DEG, 200 * DEG]]
    expected = np.mean([20**2, 180**2, 160**2, 160**2, 180**2, 20**2])
    assert angular_alpha(units) == pytest.approx(1 - 20**2 / expected)
    # A unit of one value says nothing; turning everything changes nothing.
    turned = [[a + 1.0 for a in unit] for unit in [*units, [2.0]]]
    assert angular_alpha(turned) == pytest.approx(angular_alpha(units))
    assert angular_alpha([[1.0, 1.0], [2.0, 2.0]]) == pytest.approx(1)
    assert angular_alpha([[1.0, 1.0]]) is None
    assert angular_alpha([[1.0]]) is None


def test_alpha_of_three_annotators_by_hand():
    """A unit of three counts its 6 ordered pairs by 1 / 2, one of two its 2 by 1; n is 5."""
    units = [[0, 30 * DEG, 60 * DEG], [90 * DEG, 90 * DEG]]
    observed = (2 * (30**2 + 30**2 + 60**2) / 2 + 0) / 5
    values = [0, 30, 60, 90, 90]
    pairs = [(a - b) ** 2 for i, a in enumerate(values) for b in values[i + 1 :]]
    assert angular_alpha(units) == pytest.approx(1 - observed / (2 * sum(pairs) / 20))


def test_alpha_of_random_directions_is_about_zero():
    """The standard deviation over seeds is .02; 6 of them fail once in 10**9 runs."""
    rng = np.random.default_rng(0)
    units = rng.uniform(0, 2 * math.pi, (2000, 2)).tolist()
    assert abs(angular_alpha(units)) < 0.12


def test_agreement_per_word_and_city():
    judgements = [
        judged("a", 0), judged("b", 10), judged("c", 20),
        judged("a", 90, ground="Rumor", relation="behind"),
        judged("b", None, ground="Rumor", relation="behind"),
        judged("a", 0, ground="LoganSt", city="denver"),
        judged("b", 40, ground="LoganSt", city="denver"),
    ]  # fmt: skip
    found = frame_agreement(judgements)
    rows = {(r.word, r.city): r for r in found.rows}
    assert found.annotators == ("a", "b", "c")
    # Ivy: 10, 10 and 20 apart, 13.3 on average; Logan Street: 40.
    everything = rows[None, None]
    assert (everything.units, everything.unclear) == (2, pytest.approx(1 / 7))
    assert everything.mean_deg == pytest.approx((40 / 3 + 40) / 2)
    assert rows["front", "cleveland"].mean_deg == pytest.approx(40 / 3)
    assert rows[None, "denver"].median_deg == pytest.approx(40)
    assert (rows["behind", None].units, rows["behind", None].mean_deg) == (0, None)
    assert rows["behind", None].unclear == 0.5
    assert ("behind", "denver") not in rows


def test_one_annotator_agrees_with_no_one():
    with pytest.raises(InputError, match=r"by two annotators \(a\)"):
        frame_agreement([judged("a", 0), judged("a", 10, ground="Rumor")])


def test_the_last_word_of_an_annotator_counts(tmp_path):
    path = written(
        tmp_path / "kept.jsonl",
        line("1", "a", 10), line("2", "b", 50), line("3", "a", 30), line("4", "b", None),
    )  # fmt: skip
    found = {one.annotator: one.front_rad for one in read_judgements([path])}
    assert found == {"a": pytest.approx(30 * DEG), "b": None}


def test_description_files_are_annotations_too(tmp_path):
    record = line("1", "a", 10)
    del record["frames"][0]["annotator"]
    path = written(tmp_path / "mia.jsonl", {**record, "relations": [], "targets": {}})
    assert read_judgements([path])[0].annotator == "mia"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "kept.jsonl:1: is not JSON"),
        ('{"id": "1"}', "field 'map' is missing; expected a text"),
        ('{"id": "1", "map": "m", "frames": [{"ground": "g", "relation": "r"}]}', "front_deg"),
        ('{"id": "1", "map": "m", "frames": [{"ground": "g", "relation": "r", "front_deg": NaN}]}',
         "is nan; expected a finite number"),
        ('{"id": "1", "map": "m"}', "has a frame; expected annotations of frames"),
    ],
)  # fmt: skip
def test_what_is_no_annotation_is_named(tmp_path, text, message):
    (tmp_path / "kept.jsonl").write_text(text + "\n")
    with pytest.raises(InputError, match=message):
        read_judgements([tmp_path / "kept.jsonl"])


def test_labels_are_means_of_front_and_behind():
    judgements = [
        judged("a", 350), judged("b", 10), judged("a", 100, relation="left"),
        judged("a", 90, ground="Rumor", relation="behind"), judged("a", None, ground="RTA"),
        judged("a", 0, ground="Hanabi"), judged("b", 180, ground="Hanabi"),
    ]  # fmt: skip
    maps, labels = labels_of(judgements)
    assert list(maps) == ["cleveland"]
    found = {one.building: one.frame_angle_rad for one in labels["cleveland"]}
    assert found == {"Ivy": pytest.approx(0), "Rumor": pytest.approx(90 * DEG)}
    with pytest.raises(InputError, match="Annotations of map 'atlantis'"):
        labels_of([judged("a", 0, city="atlantis")])
    with pytest.raises(InputError, match="'Nowhere' is unknown"):
        labels_of([judged("a", 0, ground="Nowhere")])


def test_people_and_predictors_against_the_annotators():
    judgements = [judged("a", 0), judged("b", 30), judged("c", 60), judged("a", 0, ground="Rumor")]
    means = consensus(judgements)
    assert means["cleveland", "", "Ivy", "front"] == pytest.approx(30 * DEG)
    found = score_annotated(judgements, ("nearest-street",))
    assert found.phrases == 2
    # a against the mean of b and c is 45 degrees off, b against that of a and c 0, c 45.
    assert found.boxes[HUMAN] == pytest.approx((45, 0, 45))
    city = sloop.load_map("cleveland")
    street = city.bearing_to_nearest_path("Ivy")
    expected = math.degrees(angular_distance(street, 30 * DEG))
    assert found.boxes["nearest-street"][0] == pytest.approx(expected)
    alone = score_annotated([judged("a", 0)], ("nearest-street",))
    assert HUMAN not in alone.boxes


def test_the_human_row_is_told_and_drawn(tmp_path):
    path = written(
        tmp_path / "kept.jsonl",
        line("1", "a", 0), line("2", "b", 30),
        line("3", "a", 80, "Rumor"), line("4", "b", 80, "Rumor"),
    )  # fmt: skip
    report = score_frames(annotations=[path])
    payload = report.to_json()
    assert payload["folds"] == []
    assert payload["annotated"]["predictors"]["Human"] == {
        "n": 4, "mean_deviation_deg": pytest.approx(15), "median_deviation_deg": pytest.approx(15),
    }  # fmt: skip
    assert any("Human: mean 15.0" in str(row) for row in frame_lines(report))
    (axes,) = report.figure().axes
    assert [t.get_text() for t in axes.get_yticklabels()][-1] == "Human (4)"


def test_the_commands(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "kept.jsonl", line("1", "a", 0), line("2", "b", 30))

    def run(*arguments):
        with pytest.raises(SystemExit) as end:
            main(arguments)
        return end.value.code, capsys.readouterr()

    code, shown = run("frames", "agreement", "kept.jsonl", "--json")
    assert code == 0
    assert json.loads(shown.out)["rows"][0]["mean_deg"] == pytest.approx(30)
    code, shown = run("frames", "agreement", "kept.jsonl")
    assert "30.0°" in shown.out
    code, shown = run("frames", "train", "--out", "w.safetensors")
    assert code == 2
    assert "Missing option '--maps' or '--annotations'" in shown.err
    code, shown = run("frames", "train", "--out", "w.safetensors", "--annotations", "kept.jsonl")
    assert code == 2
    assert "There are 1 labelled buildings to train on" in shown.err


@pytest.mark.slow
def test_a_network_is_trained_on_annotations(tmp_path, capsys):
    """Twenty places, all said to face north: the network learns to say so of them."""
    from sloop_ppl.models.frames import load_weights, predict_frames

    city = sloop.load_map("cleveland")
    grounds = [m.id for m in city.landmarks if m.name and m.kind in ("building", "poi")][:20]
    path = written(tmp_path / "kept.jsonl", *(line(g, "a", 90, g) for g in grounds))
    out = tmp_path / "north.safetensors"
    with pytest.raises(SystemExit) as end:
        main(["frames", "train", "--annotations", str(path), "--recipe", "ego-ctx", "--epochs",
              "2", "--out", str(out), "--json"])  # fmt: skip
    assert end.value.code == 0
    about = json.loads(capsys.readouterr().out)
    assert about["trained_on"] == "cleveland (20)"
    assert about["labels"] == "annotators: the mean of the fronts they drew"
    frames = predict_frames(load_weights(out), city, grounds[:3])
    assert all(np.isfinite(f.binned(24)).all() for f in frames)
